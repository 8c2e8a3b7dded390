"""Content of a file, before anything is made of it: meshes, materials and lights, in the file's own axes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Skin:
    """Look of a surface, as files say it (metallic-roughness)."""

    name: str
    base_colour: NDArray[np.float64] = field(default_factory=lambda: np.full(3, 0.5))
    """(3,) linear factor [1]."""
    opacity: float = 1.0  # 0 for what is not there, 1 for what hides all behind it [1]
    texture: NDArray[np.uint8] | None = None  # (H, W, 3) uint8 sRGB, row 0 at the bottom (v = 0); or None
    normal_map: NDArray[np.uint8] | None = None
    """(H, W, 3) uint8 tangent-space normals, row 0 at the bottom; or None."""
    roughness: float = 0.8  # 0..1 [1]
    metallic: float = 0.0  # 0..1 [1]
    emission: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    """(3,) light sent out, in the file's unit (cd/m2 in glTF)."""
    two_sided: bool = True  # true if both sides are to be seen
    mask: NDArray[np.uint8] | None = None  # (H, W) opacity, row 0 at the bottom [codes]
    cutoff: float = 0.5  # the surface is not there where the mask is below it [1]
    clamped: tuple[bool, bool] = (False, False)
    """True if the texture ends at its edges along u and v, in place of repeating."""
    unlit: bool = False  # true if its colour was photographed with its light


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles of one skin that belong to one node of the file."""

    path: tuple[str, ...]  # names of the nodes from the root down to this one, and of its mesh
    vertices: NDArray[np.float64]  # (V, 3) float64 in the world of the file, in its unit
    triangles: NDArray[np.int64]  # (T, 3) int64
    skin: int  # index into `Model.skins`
    normals: NDArray[np.float64] | None = None
    """(V, 3) float64 of unit length, or None where the file has none."""
    uv: NDArray[np.float64] | None = None  # (V, 2) float64 in tiles, v upwards [1]; or None
    colours: NDArray[np.float64] | None = None  # (V, 3) float64 linear reflectance [1]; or None
    extras: Mapping[str, Any] = field(default_factory=dict)
    """What the file's author noted on the node, inherited from its ancestors."""

    @property
    def name(self) -> str:
        return "/".join(self.path)


@dataclass(frozen=True, eq=False)
class PunctualLight:
    """A light without a surface (KHR_lights_punctual)."""

    kind: Literal["point", "spot", "directional"]
    position: NDArray[np.float64]  # (3,) [the length unit of the file]
    direction: NDArray[np.float64]  # (3,) unit vector along which it shines
    colour: NDArray[np.float64]  # (3,) linear [1]
    intensity: float  # candela of a point or spot, lux of a directional light [cd, lux]
    outer_rad: float = 0.785  # half angle of a spot's cone [rad]


@dataclass(frozen=True, eq=False)
class Model:
    """A file's content."""

    surfaces: tuple[Surface, ...]
    skins: tuple[Skin, ...]
    lights: tuple[PunctualLight, ...] = ()
    up: Literal["x", "y", "z"] | None = None
    """The axis that points upwards where the format says so: x, y or z; else None."""
    notes: tuple[str, ...] = ()  # what the file uses and the reader does not carry out, each with its effect

    @property
    def triangle_count(self) -> int:
        return sum(len(surface.triangles) for surface in self.surfaces)
