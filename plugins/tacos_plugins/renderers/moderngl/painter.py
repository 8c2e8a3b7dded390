"""Draws one world for one camera pose: the colour pass and the geometry buffer (ids, depth)."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING

import moderngl
import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera.geometry import invert_pose
from tacos_framework.values import Camera
from tacos_plugins.renderers.moderngl.context import describe_gl
from tacos_plugins.renderers.moderngl.culling import DrawList
from tacos_plugins.renderers.moderngl.flatten import SurfaceKind
from tacos_plugins.renderers.moderngl.gpu_world import GpuWorld
from tacos_plugins.renderers.moderngl.prefilter import PROBE_SCALE
from tacos_plugins.renderers.moderngl.probes import MOST_PROBES
from tacos_plugins.renderers.moderngl.programs import compile_program
from tacos_plugins.renderers.moderngl.projection import projection_matrix
from tacos_plugins.renderers.moderngl.targets import RenderTarget

if TYPE_CHECKING:
    from tacos_plugins.renderers.moderngl.projected import Projected

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


@dataclass(frozen=True, eq=False)
class Viewpoint:
    """A camera at a place: its pose both ways, and the projection of the world into its clip space.

    Inverse depth becomes a depth of OpenGL's window by constant and slope in `window_of_inverse` [1, m].
    """

    camera: Camera
    world_from_camera: NDArray[np.float64]
    camera_from_world: NDArray[np.float64]
    clip_from_world: NDArray[np.float64]
    near_m: float
    window_of_inverse: tuple[float, float]

    def onto(self, moved: NDArray[np.float64]) -> Viewpoint:
        """The view from which a thing at rest looks as it does from here once (4, 4) `moved` [m]."""
        return Viewpoint(
            camera=self.camera,
            world_from_camera=invert_pose(moved) @ self.world_from_camera,
            camera_from_world=self.camera_from_world @ moved,
            clip_from_world=self.clip_from_world @ moved,
            near_m=self.near_m,
            window_of_inverse=self.window_of_inverse,
        )

    @property
    def eye_m(self) -> NDArray[np.float64]:
        """(3,) optical centre [m]."""
        return self.world_from_camera[:3, 3]


class Painter:
    """Draws one world.

    Parameters
    ----------
    programs
        The shaders.
    world
        The uploaded world, owned from now on.
    """

    def __init__(self, programs: Programs, world: GpuWorld):
        self.world = world
        self._context, self._programs = programs.context, programs
        self._shaded = {kind: world.surface_arrays(programs.surface(kind)) for kind in world.kinds}
        self._geometry = world.geometry_arrays(programs.geometry)
        self._sky = programs.context.vertex_array(programs.sky, [])
        self._moved: Mapping[int, NDArray[np.float64]] = {}

    def with_moved(self, moved: Mapping[int, NDArray[np.float64]]) -> Painter:
        """This painter, drawing objects where (4, 4) transforms by id take them from where they rest [m]."""
        there = copy(self)
        there._moved = moved
        return there

    def in_view(self, view: Viewpoint) -> NDArray[np.intp]:
        """The chunks of the world that a camera may see."""
        return self.world.culling.in_frustum(view.clip_from_world)

    def with_surfaces(self, chunks: NDArray[np.intp], seen: NDArray[np.float32]) -> NDArray[np.intp]:
        """Those chunks that hold any of the surfaces in an image of surface numbers."""
        return self.world.culling.with_surfaces(chunks, seen)

    def geometry(self, view: Viewpoint, target: RenderTarget, chunks: NDArray[np.intp]) -> None:
        """Draw depth [m] and surface number into a target of 2 channels; infinite and 0 for nothing."""
        self._clear(target, (np.inf, 0.0, 0.0, 0.0))
        program = self._programs.geometry
        draws = self._to_see(view, chunks)
        for mover, bits, first, count in draws.groups:
            seen = self._seen(view, mover)
            _write(program, "clip_from_world", _columns(seen.clip_from_world))
            _write(program, "depth_from_world", seen.camera_from_world[2].astype("f4").tobytes())
            self._draw(self._geometry, SurfaceKind(bits), draws.commands[first : first + count])

    def projected(self, view: Viewpoint, chunks: NDArray[np.intp]) -> list[Projected]:
        """The triangles of some chunks on the image, for what is seen to be drawn without OpenGL."""
        # Compiled loops take a moment to import, which checking a recipe need not wait for.
        from tacos_plugins.renderers.moderngl.projected import pixel_from_camera, project

        camera, world = view.camera, self.world
        mesh = (world.position_m, world.triangles, world.surface_of_vertex)
        shape = (camera.height_px, camera.width_px)
        draws = self._to_see(view, chunks)
        found = []
        for mover, bits, first, count in draws.groups:
            camera_from_world = self._seen(view, mover).camera_from_world[:3]
            pixel_from_world = pixel_from_camera(camera) @ camera_from_world
            closed = bool(bits & SurfaceKind.CLOSED)
            runs = draws.runs(first, count)
            found.append(project(*mesh, runs, pixel_from_world, shape, view.near_m, closed))
        return found

    def _to_see(self, view: Viewpoint, chunks: NDArray[np.intp]) -> DrawList:
        """What is to be drawn of some chunks to know what is seen."""
        return self.world.culling.draw_list(chunks, view.eye_m, SurfaceKind.CLOSED)

    def colour(
        self,
        view: Viewpoint,
        target: RenderTarget,
        chunks: NDArray[np.intp],
        behind: NDArray[np.float32] | None = None,
    ) -> None:
        """Draw luminance into a target of 4 channels [cd/m2].

        Parameters
        ----------
        behind
            (H, W) window depths beyond which nothing is seen, and nothing need be shaded [1].
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
        draws = world.culling.draw_list(chunks, view.eye_m, ~SurfaceKind(0))
        for mover, bits, first, count in draws.groups:
            kind, seen = SurfaceKind(bits), self._seen(view, mover)
            program = self._programs.surface(kind)
            _write(program, "clip_from_world", _columns(seen.clip_from_world))
            if SurfaceKind.GLOSSY in kind:
                self._set_reflections(program, seen)
            self._draw(self._shaded[kind], kind, draws.commands[first : first + count])
        if world.has_sky:
            self._draw_sky(view)
        self._context.depth_func = "<"

    def viewpoint(self, camera: Camera, world_from_camera: NDArray[np.float64], near_m: float) -> Viewpoint:
        """A camera in this world."""
        far_m = max(self.world.far_m(world_from_camera[:3, 3]), 2 * near_m)
        camera_from_world = invert_pose(world_from_camera)
        return Viewpoint(
            camera=camera,
            world_from_camera=world_from_camera,
            camera_from_world=camera_from_world,
            clip_from_world=projection_matrix(camera, near_m, far_m) @ camera_from_world,
            near_m=near_m,
            window_of_inverse=(far_m / (far_m - near_m), -far_m * near_m / (far_m - near_m)),
        )

    def release(self) -> None:
        """Give the world and all that belongs to it back."""
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

    def _seen(self, view: Viewpoint, mover: int) -> Viewpoint:
        """The view of an object that may have moved."""
        return view.onto(self._moved[mover]) if mover in self._moved else view

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
