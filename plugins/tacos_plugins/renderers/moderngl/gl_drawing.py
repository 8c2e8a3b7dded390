"""Draws one world by OpenGL: the colour pass and the geometry buffer (depth, surfaces)."""

from __future__ import annotations

from collections.abc import Callable

import moderngl
import numpy as np
from numpy.typing import NDArray

from tacos_plugins.renderers.light.flatten import SurfaceKind
from tacos_plugins.renderers.light.prefilter import PROBE_SCALE
from tacos_plugins.renderers.light.probes import MOST_PROBES
from tacos_plugins.renderers.moderngl.context import describe_gl
from tacos_plugins.renderers.moderngl.culling import DrawList
from tacos_plugins.renderers.moderngl.gpu_world import GpuWorld
from tacos_plugins.renderers.moderngl.programs import compile_program
from tacos_plugins.renderers.moderngl.targets import RenderTarget
from tacos_plugins.renderers.moderngl.viewpoint import Viewpoint

_UNITS = ("colours", "normals", "light_map", "bend_map", "materials", "probe_map", "probes")


class Programs:
    """The compiled shaders of a context."""

    def __init__(self, context: moderngl.Context):
        filters = not describe_gl().is_software and context.max_anisotropy > 1
        self._extra = (f"MOST_PROBES {MOST_PROBES}", *(("FILTER_IN_HARDWARE",) if filters else ()))
        self.geometry = compile_program(context, "geometry_buffer.vert", "geometry_buffer.frag")
        self.sky = compile_program(context, "sky.vert", "sky.frag")
        self.context = context
        self._surface: dict[SurfaceKind, moderngl.Program] = {}

    def surface(self, kind: SurfaceKind) -> moderngl.Program:
        """The program that draws a kind of surface, compiled on first use."""
        kind &= ~SurfaceKind.CLOSED  # a matter of drawing, not of shading
        if kind not in self._surface:
            defines = tuple(flag.name for flag in SurfaceKind if flag in kind and flag.name)
            program = compile_program(self.context, "surface.vert", "surface.frag", defines + self._extra)
            for unit, name in enumerate(_UNITS):
                if name in program:
                    program[name] = unit
            self._surface[kind] = program
        return self._surface[kind]


class GlDrawing:
    """Drawing of one world by OpenGL.

    - `world`: the uploaded world, owned from now on.
    """

    def __init__(self, programs: Programs, world: GpuWorld):
        self.world = world
        self._context, self._programs = programs.context, programs
        self._shaded = {kind: world.surface_arrays(programs.surface(kind)) for kind in world.kinds}
        self._geometry = world.geometry_arrays(programs.geometry)
        self._sky = programs.context.vertex_array(programs.sky, [])

    def geometry(self, seen_by: Callable[[int], Viewpoint], target: RenderTarget, draws: DrawList) -> None:
        """Draw depth [m] and surface number into a target of 2 channels; infinite and 0 for nothing.

        `seen_by`: the camera as each moving thing sees it.
        """
        self._clear(target, (np.inf, 0.0, 0.0, 0.0))
        program = self._programs.geometry
        for mover, bits, first, count in draws.groups:
            seen = seen_by(mover)
            _write(program, "clip_from_world", _columns(seen.clip_from_world))
            _write(program, "depth_from_world", seen.camera_from_world[2].astype("f4").tobytes())
            self._draw(self._geometry, SurfaceKind(bits), draws.commands[first : first + count])

    def colour(
        self,
        seen_by: Callable[[int], Viewpoint],
        target: RenderTarget,
        draws: DrawList,
        behind: NDArray[np.float32] | None = None,
    ) -> None:
        """Draw luminance into a target of 4 channels [cd/m2].

        `seen_by`: the camera as each moving thing sees it. `behind`: (H, W) window depths beyond which
        nothing is seen, and nothing need be shaded [1].
        """
        world = self.world
        red, green, blue = map(float, world.ambient_cd_m2)
        if behind is not None:
            target.fill_depth(behind)
        # Depth was filled: clearing all would be one more pass over memory.
        self._clear(target, (red, green, blue, 1.0), depth=behind is None)
        for unit, name in enumerate(_UNITS):
            world.textures[name].use(unit)
        self._context.depth_func = "<="
        for mover, bits, first, count in draws.groups:
            kind, seen = SurfaceKind(bits), seen_by(mover)
            program = self._programs.surface(kind)
            _write(program, "clip_from_world", _columns(seen.clip_from_world))
            if SurfaceKind.GLOSSY in kind:
                self._set_reflections(program, seen)
            self._draw(self._shaded[kind], kind, draws.commands[first : first + count])
        if world.has_sky:
            self._draw_sky(seen_by(0))
        self._context.depth_func = "<"

    def release(self) -> None:
        for arrays in (*self._shaded.values(), self._geometry, self._sky):
            arrays.release()
        self.world.release()

    def _clear(
        self, target: RenderTarget, colour: tuple[float, float, float, float], depth: bool = True
    ) -> None:
        target.framebuffer.use()
        target.framebuffer.depth_mask = depth  # what is not written is not cleared either
        target.framebuffer.clear(color=colour, depth=1.0)
        target.framebuffer.depth_mask = True

    def _draw(self, arrays: moderngl.VertexArray, kind: SurfaceKind, commands: NDArray[np.uint32]) -> None:
        if SurfaceKind.CLOSED in kind:
            self._context.enable(moderngl.CULL_FACE)
        else:
            self._context.disable(moderngl.CULL_FACE)
        self.world.commands.orphan()
        self.world.commands.write(commands.tobytes())
        arrays.render_indirect(self.world.commands, moderngl.TRIANGLES, len(commands))

    def _draw_sky(self, view: Viewpoint) -> None:
        """Last, so that only what is left of the image is shaded."""
        program = self._programs.sky
        self.world.textures["sky"].use(0)
        _set_pixel_rays(program, view)
        self._context.disable(moderngl.CULL_FACE)
        self._sky.render(moderngl.TRIANGLES, vertices=3)

    def _set_reflections(self, program: moderngl.Program, view: Viewpoint) -> None:
        _set_pixel_rays(program, view)
        program["eye"] = tuple(map(float, view.eye_m))
        program["probe_scale"] = PROBE_SCALE
        program["probe_levels"] = len(self.world.levels)
        boxes = np.zeros((MOST_PROBES, 3, 3), np.float32)
        boxes[: len(self.world.probe_boxes_m)] = self.world.probe_boxes_m
        _write(program, "probe_boxes", boxes.tobytes())
        program["map_origin"] = self.world.map_origin


def _set_pixel_rays(program: moderngl.Program, view: Viewpoint) -> None:
    """The world direction of each pixel centre, from its window coordinates."""
    camera, rotation = view.camera, view.world_from_camera[:3, :3]
    step = 1 / camera.focal_length_px
    # Window coordinates of a pixel centre are half a pixel above its index.
    corner = [-(camera.centre_px[0] + 0.5) * step, -(camera.centre_px[1] + 0.5) * step, 1.0]
    program["ray_x"] = (*map(float, rotation[:, 0] * step), 0.0)
    program["ray_y"] = (*map(float, rotation[:, 1] * step), 0.0)
    program["ray_origin"] = (*map(float, rotation @ corner), 0.0)


def _write(program: moderngl.Program, name: str, value: bytes) -> None:
    uniform = program[name]
    assert isinstance(uniform, moderngl.Uniform)
    uniform.write(value)


def _columns(matrix: NDArray[np.float64]) -> bytes:
    """A matrix as OpenGL wants it: float32, column by column."""
    return matrix.T.astype("f4").tobytes()
