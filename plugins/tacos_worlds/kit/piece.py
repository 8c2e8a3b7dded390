"""A piece of furniture or decoration, before and after it has a place in the world."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tacos_framework import Light
from tacos_worlds.kit.finishes import Finish, Style
from tacos_worlds.kit.mesh import Mesh, rotation_z
from tacos_worlds.kit.rectangle import Rect

BACKGROUND = "background"


@dataclass(frozen=True)
class Top:
    """A level surface that things can stand on."""

    rect: Rect  # its free part, along the axes [m]
    height_m: float  # above the floor [m]
    use: str  # what it is for, a key of `furnishing.tabletops.THINGS`


@dataclass(frozen=True)
class Seat:
    x_m: float  # where the hips of who sits there rest
    y_m: float
    height_m: float
    yaw_rad: float = 0.0  # which way one looks from it, 0 for +y, counter-clockwise [rad]
    back_deg: float = 4.0  # how far one leans back [deg]


@dataclass(frozen=True, eq=False)
class Piece:
    """Meshes with finishes, around the origin on the floor; the back faces -y, the front +y."""

    class_name: str  # class of the object, or "background" for what carries no label
    parts: tuple[tuple[Mesh, Finish], ...]  # meshes and their finishes
    lights: tuple[Light, ...] = ()  # lamps inside, in the frame of the piece
    can_light: bool = False  # true if its last part is a shade that can glow
    tops: tuple[Top, ...] = ()  # where things can stand on it
    seats: tuple[Seat, ...] = ()  # where people can sit on it

    @cached_property
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
            tops=tuple(
                replace(
                    t,
                    rect=Rect(t.rect.x0 + x, t.rect.y0 + y, t.rect.x1 + x, t.rect.y1 + y),
                    height_m=t.height_m + z,
                )
                for t in self.tops
            ),
            seats=tuple(
                replace(s, x_m=s.x_m + x, y_m=s.y_m + y, height_m=s.height_m + z) for s in self.seats
            ),
        )

    def scaled(self, factor: float) -> Piece:
        """The piece made larger about the origin; its textures grow with it."""
        return replace(
            self,
            parts=tuple(
                (replace(mesh, vertices_m=mesh.vertices_m * factor), finish) for mesh, finish in self.parts
            ),
            tops=(),
            seats=(),
        )

    def turned(self, yaw_rad: float) -> Piece:
        """The piece turned about z; its tops lie along the axes again, exactly so after quarters."""
        turn = rotation_z(yaw_rad).astype(np.float32)
        return replace(
            self,
            parts=tuple((mesh.turned(yaw_rad), finish) for mesh, finish in self.parts),
            lights=tuple(
                replace(
                    light,
                    position_m=turn @ light.position_m,
                    normal=None if light.normal is None else turn @ light.normal,
                    half_u_m=turn @ light.half_u_m,
                    half_v_m=turn @ light.half_v_m,
                )
                for light in self.lights
            ),
            tops=tuple(replace(top, rect=_turned_rect(top.rect, turn)) for top in self.tops),
            seats=tuple(_turned_seat(seat, turn, yaw_rad) for seat in self.seats),
        )


def _turned_rect(rect: Rect, turn: np.ndarray) -> Rect:
    corners = np.array([[x, y] for x in (rect.x0, rect.x1) for y in (rect.y0, rect.y1)]) @ turn[:2, :2].T
    (x0, y0), (x1, y1) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    return Rect(x0, y0, x1, y1)


def _turned_seat(seat: Seat, turn: np.ndarray, yaw_rad: float) -> Seat:
    x, y = (turn[:2, :2] @ np.array([seat.x_m, seat.y_m])).tolist()
    return replace(seat, x_m=x, y_m=y, yaw_rad=seat.yaw_rad + yaw_rad)


def piece(
    class_name: str,
    parts: Sequence[tuple[Mesh, Finish]],
    lights: Sequence[Light] = (),
    *,
    tops: Sequence[Top] = (),
    seats: Sequence[Seat] = (),
) -> Piece:
    """A piece whose footprint is centred on the origin and which stands on the floor."""
    made = Piece(class_name, tuple(parts), tuple(lights), tops=tuple(tops), seats=tuple(seats))
    low, high = made.bounds_m
    centre = (low + high) / 2
    return made.moved(-float(centre[0]), -float(centre[1]), -float(low[2]))


Builder = Callable[[np.random.Generator, Style], Piece]
"""Makes one piece of furniture, drawn at random in a style."""
