"""Panda3D 1.10, unlit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from panda3d import core

from renderers import Picture
from renderers.merged import Merged, by_material, by_object
from renderers.tour import Tour
from tacos_framework import Material

_NEAR_M = 0.05
# Panda3D's camera looks along y with z up; ours looks along z with y down.
_CAMERA_FROM_PANDA = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])


class Panda:
    """Base colour alone, merged by material; ids as colours of a second scene, merged by object."""

    def __init__(self, tour: Tour, samples: int = 1) -> None:
        core.load_prc_file_data("", "load-display p3headlessgl\naudio-library-name null\nnotify-level error")
        world, camera = tour.episode.world, tour.camera
        self._size, self._reach_m = (camera.width_px, camera.height_px), tour.reach_m
        poses = tour.poses @ _CAMERA_FROM_PANDA
        self._poses = [core.LMatrix4(*map(float, pose.T.ravel())) for pose in poses]  # it multiplies rows
        self._lens = core.PerspectiveLens()
        self._lens.set_film_size(*self._size)
        self._lens.set_focal_length(camera.focal_length_px)
        self._lens.set_near_far(_NEAR_M, tour.reach_m)
        self._pipe = core.GraphicsPipeSelection.get_global_ptr().make_module_pipe("p3headlessgl")
        self._engine = core.GraphicsEngine.get_global_ptr()

        coloured, labelled = core.NodePath("coloured"), core.NodePath("labelled")
        for mesh in by_material(world):
            _paint(coloured.attach_new_node(_node(mesh)), world.materials[mesh.shared])
        for mesh in by_object(world):
            red, green = mesh.shared & 255, mesh.shared >> 8
            labelled.attach_new_node(_node(mesh)).set_color(red / 255, green / 255, 0.0, 1.0)
        self._views = [self._view(coloured, samples), self._view(labelled, 1)]

    def _view(self, scene: core.NodePath, samples: int) -> Any:
        """A buffer that shows a scene: itself, its camera, and the memory its colour and depth go to."""
        wanted = core.FrameBufferProperties()
        wanted.set_rgba_bits(8, 8, 8, 8)
        wanted.set_depth_bits(24)
        if samples > 1:
            wanted.set_multisamples(samples)
            scene.set_antialias(core.AntialiasAttrib.M_multisample)
        scene.set_two_sided(True)
        size = core.WindowProperties.size(*self._size)
        buffer = self._engine.make_output(
            self._pipe, scene.name, 0, wanted, size, core.GraphicsPipe.BF_refuse_window
        )
        buffer.set_clear_color((0.6, 0.75, 1.0, 1.0))
        colour, depth = core.Texture(), core.Texture()
        to_memory = core.GraphicsOutput.RTM_copy_ram
        buffer.add_render_texture(colour, to_memory, core.GraphicsOutput.RTP_color)
        if scene.name == "coloured":
            buffer.add_render_texture(depth, to_memory, core.GraphicsOutput.RTP_depth)
        camera = scene.attach_new_node(core.Camera("camera", self._lens))
        buffer.make_display_region().set_camera(camera)
        return buffer, camera, colour, depth

    def draw(self, frame: int, ids: bool) -> list[bytes]:
        """Bytes of colour, of window depth as floats, and of colours for ids."""
        for (buffer, camera, _, _), active in zip(self._views, (True, ids), strict=True):
            buffer.set_active(active)
            camera.set_mat(self._poses[frame])
        self._engine.render_frame()
        (_, _, colour, depth), (_, _, labels, _) = self._views
        drawn = [colour, depth, labels] if ids else [colour, depth]
        return [bytes(memoryview(texture.get_ram_image())) for texture in drawn]

    def picture(self, drawn: list[bytes]) -> Picture:
        """Its images have their first row at the bottom, and blue first."""
        width, height = self._size
        images = [
            np.frombuffer(each, kind).reshape(height, width, -1)[::-1]
            for each, kind in zip(drawn, (np.uint8, np.float32, np.uint8), strict=False)
        ]
        window = images[1][..., 0].astype(np.float64)
        far, near = self._reach_m, _NEAR_M
        depth = np.where(window < 1, far * near / (far - window * (far - near)), np.inf)
        labels = images[2].astype(np.int32) if len(images) > 2 else None
        ids = None if labels is None else labels[..., 2] + 256 * labels[..., 1]
        return Picture(images[0][..., 2::-1], depth.astype(np.float32), ids)


def multisampled(tour: Tour) -> Panda:
    """With four samples a pixel."""
    return Panda(tour, samples=4)


def _node(mesh: Merged) -> core.GeomNode:
    layout = core.GeomVertexArrayFormat()
    layout.add_column("vertex", 3, core.Geom.NT_float32, core.Geom.C_point)
    layout.add_column("texcoord", 2, core.Geom.NT_float32, core.Geom.C_texcoord)
    vertices = core.GeomVertexData(
        "mesh",
        core.GeomVertexFormat.register_format(core.GeomVertexFormat(layout)),
        core.Geom.UH_static,
    )
    columns = np.column_stack([mesh.position_m, mesh.uv]).astype(np.float32)
    vertices.unclean_set_num_rows(len(columns))
    _fill(vertices.modify_array_handle(0), columns)
    triangles = core.GeomTriangles(core.Geom.UH_static)
    triangles.set_index_type(core.Geom.NT_uint32)
    indices = triangles.modify_vertices()
    indices.unclean_set_num_rows(mesh.triangles.size)
    _fill(indices.modify_handle(), mesh.triangles.astype(np.uint32))
    geometry = core.Geom(vertices)
    geometry.add_primitive(triangles)
    node = core.GeomNode(str(mesh.shared))
    node.add_geom(geometry)
    return node


def _fill(handle: Any, content: NDArray[Any]) -> None:
    handle.copy_data_from(content.tobytes())


def _paint(node: core.NodePath, material: Material) -> None:
    node.set_color(*map(float, material.base_colour ** (1 / 2.2)), 1.0)  # multiplies encoded texels
    if material.texture is None:
        return
    image = np.ascontiguousarray(material.texture[..., ::-1])  # blue first, and the first row at the bottom
    texture = core.Texture()
    texture.setup_2d_texture(image.shape[1], image.shape[0], core.Texture.T_unsigned_byte, core.Texture.F_rgb)
    texture.set_ram_image(image.tobytes())
    texture.set_minfilter(core.SamplerState.FT_linear_mipmap_linear)
    node.set_texture(texture)
