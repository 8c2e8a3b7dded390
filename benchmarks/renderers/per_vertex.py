"""What one writes with moderngl in an afternoon: a draw call per material, light per vertex, 8 bits."""

from __future__ import annotations

import math
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from renderers import Picture
from renderers.merged import by_material
from renderers.tour import Tour
from tacos_framework import Material, World
from tacos_plugins.renderers.moderngl.context import gl_context
from tacos_plugins.renderers.moderngl.viewpoint import projection_matrix

_NEAR_M = 0.05
_SKY = (0.6, 0.75, 1.0)
_VERTEX = """
#version 330
uniform mat4 clip_from_world;
in vec3 position; in vec2 uv; in vec3 light; in float object_id;
out vec2 at; out vec3 lit; flat out float object;
void main() {
    gl_Position = clip_from_world * vec4(position, 1.0);
    at = uv; lit = light; object = object_id;
}
"""
_SQUARE_ROOTS = "vec3 texel = texture(image, at).rgb; colour = vec4(sqrt(texel * texel * tint * lit), 1.0);"
_DEPTH_AND_ID = "seen = vec2(1.0 / gl_FragCoord.w, object);"
_FRAGMENT = """
#version 330
uniform sampler2D image; uniform vec3 tint;
in vec2 at; in vec3 lit; flat in float object;
%s
void main() { %s }
"""
_COLOUR_OUT, _SEEN_OUT = "layout(location=0) out vec4 colour;", "layout(location=%d) out vec2 seen;"


class PerVertex:
    """Diffuse light of all lamps, without shadows, added up per vertex once; no culling; depth and ids in a
    second target of the same pass.

    With several samples a pixel depth and ids take a pass of their own, since they cannot be averaged.
    """

    def __init__(self, tour: Tour, samples: int = 1) -> None:
        context = gl_context()
        camera, world = tour.camera, tour.episode.world
        self._size = size = (camera.width_px, camera.height_px)
        projection = projection_matrix(camera, _NEAR_M, tour.reach_m)
        self._clip_from_world = projection @ np.linalg.inv(tour.poses)
        colour = context.renderbuffer(size, 4, samples=samples if samples > 1 else 0)
        seen = context.renderbuffer(size, 2, dtype="f4")
        if samples > 1:
            self._resolved = context.framebuffer(context.renderbuffer(size, 4))
            self._passes = [
                context.framebuffer(colour, context.depth_renderbuffer(size, samples=samples)),
                context.framebuffer(seen, context.depth_renderbuffer(size)),
            ]
            ways = [(_COLOUR_OUT, _SQUARE_ROOTS), (_SEEN_OUT % 0, _DEPTH_AND_ID)]
        else:
            self._passes = [context.framebuffer([colour, seen], context.depth_renderbuffer(size))]
            ways = [(_COLOUR_OUT + _SEEN_OUT % 1, _SQUARE_ROOTS + _DEPTH_AND_ID)]
        self._context, self._samples = context, samples
        self._programs = [
            context.program(vertex_shader=_VERTEX, fragment_shader=_FRAGMENT % way) for way in ways
        ]
        light = _light_at_vertices(tour)
        self._draws = [
            (
                _texture(context, world.materials[mesh.shared]),
                tuple(map(float, world.materials[mesh.shared].base_colour)),
                self._arrays(mesh.triangles, mesh.position_m, mesh.uv, lux, mesh.object_id),
            )
            for mesh, lux in zip(by_material(world), light, strict=True)
        ]

    def _arrays(self, triangles: NDArray[np.int32], *attributes: NDArray[Any]) -> list[moderngl.VertexArray]:
        columns = np.column_stack([each.astype(np.float32) for each in attributes])
        vertices, indices = self._context.buffer(columns), self._context.buffer(triangles)
        names = ("position", "uv", "light", "object_id")
        arrays = []
        for program in self._programs:
            used = [name in program for name in names]
            layout = " ".join(
                f"{n}f" if use else f"{4 * n}x" for n, use in zip((3, 2, 3, 1), used, strict=True)
            )
            content = (vertices, layout, *(name for name, use in zip(names, used, strict=True) if use))
            arrays.append(self._context.vertex_array(program, [content], indices))
        return arrays

    def draw(self, frame: int, ids: bool) -> tuple[bytes, bytes]:
        """Bytes of colour and floats of depth, or of depth and id."""
        matrix = self._clip_from_world[frame].T.astype("f4").tobytes()
        self._context.enable_only(moderngl.DEPTH_TEST)
        for number, (target, program) in enumerate(zip(self._passes, self._programs, strict=True)):
            target.use()
            target.clear(*_SKY, 1.0)
            program["clip_from_world"].write(matrix)
            for texture, tint, arrays in self._draws:
                if "tint" in program:
                    texture.use(0)
                    program["tint"].value = tint
                arrays[number].render()
        if self._samples > 1:
            self._context.copy_framebuffer(self._resolved, self._passes[0])
            colour = self._resolved.read(components=3)
            return colour, self._passes[1].read(components=2 if ids else 1, dtype="f4")
        colour = self._passes[0].read(components=3)
        return colour, self._passes[0].read(components=2 if ids else 1, attachment=1, dtype="f4")

    def picture(self, drawn: tuple[bytes, bytes]) -> Picture:
        """Colour as it is, square roots of light for sRGB."""
        width, height = self._size
        colour = np.frombuffer(drawn[0], np.uint8).reshape(height, width, 3)
        seen = np.frombuffer(drawn[1], np.float32).reshape(height, width, -1)
        as_cleared = seen[..., 0] == np.float32(_SKY[0])
        depth = np.where(as_cleared, np.float32(np.inf), seen[..., 0])
        return Picture(colour, depth, seen[..., 1].astype(np.int32) if seen.shape[2] > 1 else None)


def multisampled(tour: Tour) -> PerVertex:
    """With four samples a pixel."""
    return PerVertex(tour, samples=4)


def _light_at_vertices(tour: Tour) -> list[NDArray[np.float32]]:
    """Per mesh (V, 3), so that its mean over all vertices that a lamp reaches is 0.5 [1]."""
    light = []
    for mesh in by_material(tour.episode.world):
        light.append(_direct_lux(tour.episode.world, mesh.position_m, mesh.normal))
    everywhere = np.concatenate(light)
    typical = np.median(everywhere[everywhere.sum(axis=1) > 0])
    return [(0.15 + 0.35 * lux / typical).astype(np.float32) for lux in light]


def _direct_lux(
    world: World, position_m: NDArray[np.float32], normal: NDArray[np.float32]
) -> NDArray[np.float64]:
    lux = np.zeros((len(position_m), 3))
    for lamp in world.lights:
        way = lamp.position_m.astype(np.float64) - position_m
        distance = np.linalg.norm(way, axis=1, keepdims=True)
        cosine = np.clip((way * normal).sum(axis=1, keepdims=True) / distance, 0, None)
        if lamp.normal is None:
            intensity = 1 / (4 * math.pi)
        else:
            intensity = np.clip(-way @ lamp.normal[:, None] / distance, 0, None) / math.pi
        lux += lamp.flux_lm * intensity * cosine / np.maximum(distance, 0.1) ** 2
    return lux


def _texture(context: moderngl.Context, material: Material) -> moderngl.Texture:
    image = material.texture
    if image is None:
        image = np.full((1, 1, 3), 255, np.uint8)
    texture = context.texture((len(image), len(image)), 3, np.ascontiguousarray(image), alignment=1)
    texture.build_mipmaps()
    texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
    return texture
