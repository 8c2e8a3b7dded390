"""A world on the GPU: uploaded once, drawn for any number of cameras."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import moderngl
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
from tacos_plugins.renderers.moderngl.context import add_level, describe_gl

SURFACE_VERTEX = np.dtype(
    [
        ("in_position", "f4", 3),
        ("in_uv", "f4", 2),
        ("in_map", "f4", 2),
        ("in_light", "f4", 3),
        ("in_bend", "f4", 2),
        ("in_layers", "i4", 2),
    ]
)
GLOSS_VERTEX = np.dtype(
    [("in_normal", "f4", 3), ("in_tangent", "f4", 4), ("in_share", "f4"), ("in_gloss", "i4")]
)
GEOMETRY_VERTEX = np.dtype([("in_position", "f4", 3), ("in_surface", "i4")])

ANISOTROPY = 16.0
"""Samples along the longer side of a pixel's footprint, where the hardware takes them [1]."""


class GpuWorld:
    def __init__(self, context: moderngl.Context, world: World, lit: BakedMesh):
        self._context = context
        self.ambient_cd_m2 = world.ambient_cd_m2
        self.has_sky = world.sky_cd_m2 is not None
        self.probe_boxes_m = np.zeros((1, 3, 3), np.float32)  # of each: place, lower and upper corner
        self.map_origin = (0.0, 0.0, 1.0)  # of the map of probes: x and y [m], and cells per metre
        self.levels, level_of_material = roughness_levels(world.materials)
        self.kinds = [SurfaceKind(bits) for bits in np.unique(lit.chunks.kind).tolist()]
        self.surface = _buffer(context, _surface_vertices(world, lit))
        self.gloss = _buffer(context, _gloss_vertices(lit))
        self.geometry = _buffer(context, _geometry_vertices(lit))
        self.indices = _buffer(context, lit.mesh.triangles)
        self.commands = context.buffer(reserve=20 * max(len(lit.chunks.first), 1), dynamic=True)
        self.textures: dict[str, moderngl.Texture | moderngl.TextureArray] = {
            "colours": _uploaded(context, colour_levels(world.materials)),
            "normals": _uploaded(context, normal_levels(world.materials)),
            "light_map": _map(context, lit.light_map),
            "bend_map": _map(context, lit.bend_map),
            "materials": _table(context, material_table(world.materials, level_of_material)),
            "probe_map": _table(context, np.zeros((1, 1, 1), np.float32)),
            "probes": _layers(context, np.zeros((len(self.levels), 2, 2, 3), np.float32)),
        }
        if world.sky_cd_m2 is not None:
            self.textures["sky"] = _panorama(context, world.sky_cd_m2)

    def set_probes(self, probes: Sequence[Probe], mapped: ProbeMap) -> None:
        """Let glossy surfaces mirror the probes that a map gives each place; before, they mirror darkness."""
        self.probe_boxes_m = np.array([(p.position_m, p.lower_m, p.upper_m) for p in probes], np.float32)
        for name in ("probe_map", "probes"):
            self.textures[name].release()
        self.textures["probes"] = _layers(self._context, prefiltered(probes, self.levels))
        self.textures["probe_map"] = _table(self._context, mapped.packed()[..., None])
        self.map_origin = (float(mapped.origin_m[0]), float(mapped.origin_m[1]), 1 / mapped.cell_m)

    def surface_arrays(self, program: moderngl.Program) -> moderngl.VertexArray:
        """Vertex array that feeds a surface program."""
        return self._arrays(program, (self.surface, SURFACE_VERTEX), (self.gloss, GLOSS_VERTEX))

    def geometry_arrays(self, program: moderngl.Program) -> moderngl.VertexArray:
        """Vertex array that feeds the geometry-buffer program."""
        return self._arrays(program, (self.geometry, GEOMETRY_VERTEX))

    @property
    def nbytes(self) -> int:
        """Memory of the GPU, or of the process where rendering is in software [bytes]."""
        buffers = (self.surface, self.gloss, self.geometry, self.indices, self.commands)
        return sum(buffer.size for buffer in buffers) + sum(map(_texture_bytes, self.textures.values()))

    def release(self) -> None:
        buffers = (self.surface, self.gloss, self.geometry, self.indices, self.commands)
        for held in (*buffers, *self.textures.values()):
            held.release()

    def _arrays(
        self, program: moderngl.Program, *buffers: tuple[moderngl.Buffer, np.dtype[np.void]]
    ) -> moderngl.VertexArray:
        """Bind those fields of vertex buffers that a program reads; the others are skipped."""
        content = []
        for buffer, layout in buffers:
            names = [name for name in layout.names or () if name in program]
            if names:
                content.append((buffer, _format(layout, program), *names))
        return self._context.vertex_array(program, content, index_buffer=self.indices, index_element_size=4)


def _format(layout: np.dtype[np.void], program: moderngl.Program) -> str:
    """moderngl's words for a vertex layout, fields the program does not read as padding."""
    words = []
    for name in layout.names or ():
        field = layout[name]
        count = field.shape[0] if field.shape else 1
        kind = "f" if field.base.kind == "f" else "i"
        words.append(f"{count}{kind}" if name in program else f"{field.itemsize}x")
    return " ".join(words)


def _surface_vertices(world: World, lit: BakedMesh) -> NDArray[np.void]:
    mesh = lit.mesh
    vertices = np.zeros(len(mesh.position_m), SURFACE_VERTEX)
    vertices["in_position"] = mesh.position_m
    vertices["in_uv"] = mesh.uv
    vertices["in_map"] = lit.map_coordinates
    vertices["in_light"] = lit.vertex_light.luminance_cd_m2
    vertices["in_bend"] = lit.vertex_light.bend
    vertices["in_layers"] = texture_layers(world.materials)[mesh.material]
    return vertices


def _gloss_vertices(lit: BakedMesh) -> NDArray[np.void]:
    mesh = lit.mesh
    vertices = np.zeros(len(mesh.position_m), GLOSS_VERTEX)
    vertices["in_normal"] = mesh.normal
    vertices["in_tangent"] = lit.tangents
    vertices["in_share"] = lit.vertex_light.unshadowed_share
    vertices["in_gloss"] = mesh.material
    return vertices


def _geometry_vertices(lit: BakedMesh) -> NDArray[np.void]:
    vertices = np.zeros(len(lit.mesh.position_m), GEOMETRY_VERTEX)
    vertices["in_position"] = lit.mesh.position_m
    vertices["in_surface"] = lit.surface
    return vertices


def _buffer(context: moderngl.Context, data: NDArray[Any]) -> moderngl.Buffer:
    return context.buffer(data.tobytes() or bytes(64))  # OpenGL refuses empty buffers


def _texture_bytes(texture: moderngl.Texture | moderngl.TextureArray) -> int:
    """Memory of a texture, mipmap levels included [bytes]."""
    texels = texture.width * texture.height * getattr(texture, "layers", 1)
    level = texels * 4 * int(texture.dtype[1])  # drivers keep three channels as four
    return level * 4 // 3 if texture.dtype == "f1" else level


def _table(context: moderngl.Context, data: NDArray[np.float32]) -> moderngl.Texture:
    rows, columns, channels = data.shape
    texture = context.texture((columns, rows), channels, data.tobytes(), dtype="f4")
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    return texture


def _map(context: moderngl.Context, data: NDArray[np.float32]) -> moderngl.Texture:
    rows, columns, channels = data.shape
    halves = data.clip(max=BRIGHTEST).astype(np.float16)
    texture = context.texture((columns, rows), channels, halves.tobytes(), dtype="f2")
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
    texture.repeat_x = texture.repeat_y = False
    return texture


def _panorama(context: moderngl.Context, data: NDArray[np.float32]) -> moderngl.Texture:
    texture = _map(context, data)
    texture.repeat_x = True
    return texture


def _layers(context: moderngl.Context, data: NDArray[np.float32]) -> moderngl.TextureArray:
    layers, rows, columns, channels = data.shape
    # A mirror image of the sun is brighter than half floats reach; what saturates a sensor may do so here.
    content = np.minimum(data, np.finfo(np.float16).max).astype(np.float16).tobytes()
    texture = context.texture_array((columns, rows, layers), channels, content, dtype="f2")
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
    texture.repeat_x = texture.repeat_y = False
    return texture


def _uploaded(context: moderngl.Context, levels: Sequence[NDArray[np.uint8]]) -> moderngl.TextureArray:
    layers, edge = levels[0].shape[:2]
    texture = context.texture_array((edge, edge, layers), 4, levels[0])
    texture.repeat_x = texture.repeat_y = True
    for number, level in enumerate(levels[1:], start=1):
        add_level(texture, number, level)
    in_software = describe_gl().is_software  # where blending two levels costs half as much again per pixel
    between_levels = moderngl.LINEAR_MIPMAP_NEAREST if in_software else moderngl.LINEAR_MIPMAP_LINEAR
    texture.filter = (between_levels, moderngl.LINEAR)
    if not in_software and context.max_anisotropy > 1:
        texture.anisotropy = min(ANISOTROPY, context.max_anisotropy)
    return texture
