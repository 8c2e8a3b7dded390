"""A piece of furniture or decoration, before and after it has a place in the world."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tacos_framework.values import Light
from tacos_worlds.indoor.finishes import Finish, Style
from tacos_worlds.indoor.mesh import Mesh, rotation_z

BACKGROUND = "background"


@dataclass(frozen=True, eq=False)
class Piece:
    """Meshes with finishes, around the origin on the floor; the back faces -y, the front +y.

    Parameters
    ----------
    class_name
        Class of the object, or "background" for what carries no label.
    parts
        Meshes and their finishes.
    lights
        Lamps inside, in the frame of the piece.
    can_light
        Whether its last part is a shade that can glow.
    """

    class_name: str
    parts: tuple[tuple[Mesh, Finish], ...]
    lights: tuple[Light, ...] = ()
    can_light: bool = False

    @property
    def bounds_m(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest corner [m]."""
        low = np.min([mesh.vertices_m.min(axis=0) for mesh, _ in self.parts], axis=0)
        high = np.max([mesh.vertices_m.max(axis=0) for mesh, _ in self.parts], axis=0)
        return low, high

    @property
    def size_m(self) -> tuple[float, float, float]:
        """Width along x, depth along y, height above the lowest point [m]."""
        low, high = self.bounds_m
        x, y, z = (high - low).tolist()
        return x, y, z

    def moved(self, x: float, y: float, z: float = 0.0) -> Piece:
        """The piece shifted [m]."""
        shift = np.array([x, y, z], np.float32)
        return replace(
            self,
            parts=tuple((mesh.moved(x, y, z), finish) for mesh, finish in self.parts),
            lights=tuple(replace(light, position_m=light.position_m + shift) for light in self.lights),
        )

    def scaled(self, factor: float) -> Piece:
        """The piece made larger about the origin; its textures grow with it."""
        return replace(
            self,
            parts=tuple(
                (replace(mesh, vertices_m=mesh.vertices_m * factor), finish) for mesh, finish in self.parts
            ),
        )

    def turned(self, yaw_rad: float) -> Piece:
        """The piece turned about z."""
        turn = rotation_z(yaw_rad).astype(np.float32)
        return replace(
            self,
            parts=tuple((mesh.turned(yaw_rad), finish) for mesh, finish in self.parts),
            lights=tuple(replace(light, position_m=turn @ light.position_m) for light in self.lights),
        )


def piece(class_name: str, parts: Sequence[tuple[Mesh, Finish]], lights: Sequence[Light] = ()) -> Piece:
    """A piece whose footprint is centred on the origin and which stands on the floor."""
    made = Piece(class_name, tuple(parts), tuple(lights))
    low, high = made.bounds_m
    centre = (low + high) / 2
    return made.moved(-float(centre[0]), -float(centre[1]), -float(low[2]))


Builder = Callable[[np.random.Generator, Style], Piece]
"""Makes one piece of furniture, drawn at random in a style."""
