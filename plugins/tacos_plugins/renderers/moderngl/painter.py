"""Draws one world for one camera pose: the colour pass and the truth pass."""

from __future__ import annotations

import moderngl
import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera.geometry import invert_pose, projection_matrix
from tacos_framework.values import Camera
from tacos_plugins.renderers.moderngl.context import describe_gl
from tacos_plugins.renderers.moderngl.flatten import SurfaceKind
from tacos_plugins.renderers.moderngl.gpu_world import GpuWorld, Visible
from tacos_plugins.renderers.moderngl.prefilter import PROBE_SCALE
from tacos_plugins.renderers.moderngl.programs import compile_program
from tacos_plugins.renderers.moderngl.targets import Targets
from tacos_plugins.renderers.moderngl.textures import ANISOTROPY

_UNITS = ("colours", "normals", "light_map", "bend_map", "materials", "probe_boxes", "probes")


class Programs:
    """The compiled shaders of a context."""

    def __init__(self, context: moderngl.Context):
        self.hardware_filter = not describe_gl().is_software and context.max_anisotropy > 1
        extra = ("FILTER_IN_HARDWARE",) if self.hardware_filter else ()
        self.truth = compile_program(context, "truth.vert", "truth.frag")
        self._context, self._extra = context, extra
        self._surface: dict[SurfaceKind, moderngl.Program] = {}

    def surface(self, kind: SurfaceKind) -> moderngl.Program:
        """The program that draws a kind of surface, compiled on first use."""
        if kind not in self._surface:
            defines = tuple(flag.name for flag in SurfaceKind if flag in kind and flag.name)
            program = compile_program(self._context, "surface.vert", "surface.frag", defines + self._extra)
            for unit, name in enumerate(_UNITS):
                if name in program:
                    program[name] = unit
            self._surface[kind] = program
        return self._surface[kind]


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
        self._programs = programs
        self._surfaces = {kind: world.surface_arrays(programs.surface(kind)) for kind in world.kinds}
        self._truth = world.truth_arrays(programs.truth)
        if programs.hardware_filter:
            for name in ("colours", "normals"):
                world.textures[name].anisotropy = ANISOTROPY

    def colour(
        self, camera: Camera, world_from_camera: NDArray[np.float64], near_m: float, targets: Targets
    ) -> None:
        """Draw luminance into the colour target [cd/m2]."""
        clip, visible = self._look(camera, world_from_camera, near_m)
        targets.colour.use()
        targets.colour.clear(*map(float, self.world.ambient_cd_m2), 1.0, depth=1.0)
        for unit, name in enumerate(_UNITS):
            self.world.textures[name].use(unit)
        first = 0
        for kind, arrays in self._surfaces.items():
            count = int(visible.of_kind[kind])
            program = self._programs.surface(kind)
            program["clip_from_world"].write(_columns(clip))
            if SurfaceKind.GLOSSY in kind:
                self._set_rays(program, camera, world_from_camera)
            self._draw(arrays, visible, first, count)
            first += count

    def truth(
        self, camera: Camera, world_from_camera: NDArray[np.float64], near_m: float, targets: Targets
    ) -> None:
        """Draw depth [m] and object id into the truth target."""
        clip, visible = self._look(camera, world_from_camera, near_m)
        targets.truth.use()
        targets.truth.clear(np.inf, 0.0, 0.0, 0.0, depth=1.0)
        program = self._programs.truth
        program["clip_from_world"].write(_columns(clip))
        program["depth_from_world"].write(invert_pose(world_from_camera)[2].astype("f4").tobytes())
        self._draw(self._truth, visible, 0, len(visible.commands))

    def release(self) -> None:
        """Give the world and all that belongs to it back."""
        for arrays in (*self._surfaces.values(), self._truth):
            arrays.release()
        self.world.release()

    def _look(
        self, camera: Camera, world_from_camera: NDArray[np.float64], near_m: float
    ) -> tuple[NDArray[np.float64], Visible]:
        eye = world_from_camera[:3, 3]
        projection = projection_matrix(camera, near_m, max(self.world.far_m(eye), 2 * near_m))
        clip = projection @ invert_pose(world_from_camera)
        return clip, self.world.visible(clip, eye)

    def _draw(self, arrays: moderngl.VertexArray, visible: Visible, first: int, count: int) -> None:
        if count == 0:
            return
        self.world.commands.orphan()
        self.world.commands.write(visible.commands[first : first + count].tobytes())
        arrays.render_indirect(self.world.commands, moderngl.TRIANGLES, count)

    def _set_rays(
        self, program: moderngl.Program, camera: Camera, world_from_camera: NDArray[np.float64]
    ) -> None:
        rotation = world_from_camera[:3, :3]
        step = 1 / camera.focal_length_px
        # Window coordinates of a pixel centre are half a pixel above its index.
        corner = [-(camera.centre_px[0] + 0.5) * step, -(camera.centre_px[1] + 0.5) * step, 1.0]
        program["ray_x"] = (*map(float, rotation[:, 0] * step), 0.0)
        program["ray_y"] = (*map(float, rotation[:, 1] * step), 0.0)
        program["ray_origin"] = (*map(float, rotation @ corner), 0.0)
        program["eye"] = tuple(map(float, world_from_camera[:3, 3]))
        program["probe_scale"] = PROBE_SCALE
        program["probe_levels"] = len(self.world.levels)


def _columns(matrix: NDArray[np.float64]) -> bytes:
    """A matrix as OpenGL wants it: float32, column by column."""
    return matrix.T.astype("f4").tobytes()
