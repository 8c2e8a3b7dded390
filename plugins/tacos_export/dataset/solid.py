"""An object of a world as a model of its own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tacos_framework import World


@dataclass(frozen=True, eq=False)
class Solid:
    """Triangles of one object around the middle of its box."""

    vertices_m: NDArray[np.float64]  # (V, 3) from that middle, along the axes of the world [m]
    triangles: NDArray[np.int64]  # (T, 3)
    centre_m: NDArray[np.float64]  # (3,) the middle where it rests in the world [m]

    @classmethod
    def of_object(cls, world: World, thing: int) -> Solid:
        parts = [part for part in world.parts if part.object_id == thing]
        first = np.cumsum([0] + [len(part.vertices_m) for part in parts])
        vertices = np.concatenate([part.vertices_m.astype(np.float64) for part in parts])
        triangles = [part.triangles.astype(np.int64) + at for part, at in zip(parts, first, strict=False)]
        centre = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
        return cls(vertices - centre, np.concatenate(triangles), centre)

    @property
    def world_from_model(self) -> NDArray[np.float64]:
        """(4, 4) where it rests in the world [m]."""
        pose = np.eye(4)
        pose[:3, 3] = self.centre_m
        return pose

    def info(self, units_per_m: float) -> dict[str, float]:
        """Its box and diameter (that of the box, which no two of its points exceed), as BOP has them."""
        low, size = self.vertices_m.min(axis=0) * units_per_m, np.ptp(self.vertices_m, axis=0) * units_per_m
        box = {f"min_{axis}": float(value) for axis, value in zip("xyz", low, strict=True)}
        box |= {f"size_{axis}": float(value) for axis, value in zip("xyz", size, strict=True)}
        return {"diameter": float(np.linalg.norm(size)), **box}

    def write_ply(self, path: Path, units_per_m: float) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        axes = "".join(f"property float {axis}\n" for axis in "xyz")
        head = (
            f"ply\nformat binary_little_endian 1.0\nelement vertex {len(self.vertices_m)}\n{axes}"
            f"element face {len(self.triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
        )
        faces = np.empty(len(self.triangles), [("count", "u1"), ("corners", "<i4", 3)])
        faces["count"], faces["corners"] = 3, self.triangles
        content = (self.vertices_m * units_per_m).astype("<f4").tobytes() + faces.tobytes()
        path.write_bytes(head.encode() + content)
