"""Tables for shading without OpenGL: attributes, textures, light maps and probes, in memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import World
from tacos_plugins.renderers.light.baked_mesh import BakedMesh
from tacos_plugins.renderers.light.flatten import SurfaceKind
from tacos_plugins.renderers.light.prefilter import BRIGHTEST, prefiltered, roughness_levels
from tacos_plugins.renderers.light.probe_map import ProbeMap
from tacos_plugins.renderers.light.probes import Probe
from tacos_plugins.renderers.light.textures import (
    colour_levels,
    material_table,
    normal_levels,
    texture_layers,
)
from tacos_plugins.renderers.software.surface_attributes import of_vertices, rows_of


@dataclass(frozen=True, eq=False)
class TexelStack:
    """Layers of a texture with their mipmaps, in one run of texels."""

    texels: NDArray[np.int32]
    """(N,) red, green and blue in the lowest three bytes; level after level, in each layer after layer."""
    offsets: NDArray[np.int32]
    """First texel of each level."""
    edge: int
    """Texels along an edge of the finest level."""

    @classmethod
    def of(cls, levels: Sequence[NDArray[np.uint8]]) -> TexelStack:
        """Of (layers, T, T, 4) bytes of each level, the finest first.

        >>> stack = TexelStack.of([np.full((1, 2, 2, 4), 1, np.uint8), np.full((1, 1, 1, 4), 2, np.uint8)])
        >>> stack.offsets.tolist(), stack.edge, hex(stack.texels[4])
        ([0, 4], 2, '0x2020202')
        """
        counts = [level.size // 4 for level in levels]
        texels = np.concatenate([level.reshape(-1) for level in levels]).view("<i4")
        return cls(
            texels.astype(np.int32, copy=False),
            (np.cumsum(counts) - counts).astype(np.int32),
            levels[0].shape[1],
        )


class ShadingTables:
    """Tables of one world. What is numbered from 1 has a place 0 for nothing."""

    def __init__(self, world: World, lit: BakedMesh):
        mesh, chunks = lit.mesh, lit.chunks
        chunk = np.repeat(np.arange(len(chunks.first)), chunks.count)
        bits = chunks.kind & ~int(SurfaceKind.CLOSED)  # a matter of what is seen, not of shading
        distinct, kind_of_chunk = np.unique(bits, return_inverse=True)
        self.kinds = [SurfaceKind(each) for each in distinct.tolist()]
        self.rows_of_kind = [rows_of(kind) for kind in self.kinds]
        self.kind_of_triangle = _from_one(kind_of_chunk[chunk])
        self.movers, mover_of_chunk = np.unique(np.append(chunks.mover, 0), return_inverse=True)
        self.mover_of_triangle = _from_one(mover_of_chunk[chunk])
        self.triangles = np.require(mesh.triangles, np.int32, ("C", "W"))
        self.position_m = _plain(mesh.position_m)
        self.attributes = of_vertices(lit)
        material = mesh.material[mesh.triangles[:, 0]]
        self.flat = _from_one(np.column_stack([texture_layers(world.materials)[material], material]))
        self.levels, level_of_material = roughness_levels(world.materials)
        table = material_table(world.materials, level_of_material)
        self.materials = np.ascontiguousarray(table[:, :, :3].reshape(-1, 9))
        self.colours = TexelStack.of(colour_levels(world.materials))
        self.normals = TexelStack.of(normal_levels(world.materials))
        self.light_map = _bounded(lit.light_map)
        self.bend_map = _plain(lit.bend_map)
        self.ambient_cd_m2 = _plain(world.ambient_cd_m2)
        self.sky = None if world.sky_cd_m2 is None else _bounded(world.sky_cd_m2)
        self.probe_boxes_m = np.array([[[0] * 3, [0] * 3, [1] * 3]], np.float32)
        self.probes = np.zeros((len(self.levels), 2, 2, 3), np.float32)
        self.probe_map, self.map_origin = np.zeros((1, 1), np.float32), (0.0, 0.0, 1.0)

    def set_probes(self, probes: Sequence[Probe], mapped: ProbeMap) -> None:
        """Let glossy surfaces mirror the probes that a map gives each place; before, they mirror darkness."""
        self.probe_boxes_m = np.array([(p.position_m, p.lower_m, p.upper_m) for p in probes], np.float32)
        self.probes = _bounded(prefiltered(probes, self.levels))
        self.probe_map = _plain(mapped.packed())
        self.map_origin = (float(mapped.origin_m[0]), float(mapped.origin_m[1]), 1 / mapped.cell_m)

    @property
    def nbytes(self) -> int:
        """Memory they take [bytes]."""
        held = [*vars(self).values(), self.colours.texels, self.normals.texels]
        return sum(each.nbytes for each in held if isinstance(each, np.ndarray))


def _from_one(values: NDArray[np.integer]) -> NDArray[np.int32]:
    """Values of what is numbered from 1."""
    return np.concatenate([np.zeros((1, *values.shape[1:]), np.int32), values]).astype(np.int32)


def _bounded(light: NDArray[np.floating]) -> NDArray[np.float32]:
    """Light no brighter than OpenGL's textures hold it; the same memory where none is."""
    too_bright = light.size > 0 and float(light.max()) > BRIGHTEST
    return _plain(np.minimum(light, np.float32(BRIGHTEST)) if too_bright else light)


def _plain(values: NDArray[np.floating]) -> NDArray[np.float32]:
    """Values in one run of memory that can be written, as for others loops would be compiled anew."""
    return np.require(values, np.float32, ("C", "W"))
