"""pyrender 0.1.45, unlit and with the four lights its shader takes."""

from __future__ import annotations

import os
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from renderers import Picture
from renderers.merged import by_material, by_object
from renderers.tour import Tour
from tacos_framework import Light, Material

os.environ["PYOPENGL_PLATFORM"] = "egl"
if not hasattr(np, "infty"):
    vars(np)["infty"] = np.inf  # pyrender 0.1.45 is from before NumPy 2
warnings.simplefilter("ignore")
import pyrender  # noqa: E402

_MOST_LIGHTS = 4
_WHITE = 4.0  # light of all of them together at the camera, on average over the tour


class Pyrender:
    """Base colour alone, merged by material, four samples a pixel; ids from a second scene, merged by object.

    Each scene has a renderer of its own, as one that changes scenes uploads them anew.
    """

    def __init__(self, tour: Tour, lit: bool = False) -> None:
        self._poses = tour.poses @ np.diag([1.0, -1.0, -1.0, 1.0])  # OpenGL looks along -z
        self._flags = pyrender.RenderFlags.NONE if lit else pyrender.RenderFlags.FLAT
        world, camera = tour.episode.world, tour.camera
        focal, (cx, cy) = camera.focal_length_px, camera.centre_px
        lens = pyrender.IntrinsicsCamera(focal, focal, cx + 0.5, cy + 0.5, znear=0.05, zfar=tour.reach_m)

        self._coloured = pyrender.Scene(ambient_light=[0.3, 0.3, 0.3], bg_color=[0.6, 0.75, 1.0])
        for mesh in by_material(world):
            material = _material(world.materials[mesh.shared], lit)
            primitive = pyrender.Primitive(
                mesh.position_m, mesh.normal, texcoord_0=mesh.uv, indices=mesh.triangles, material=material
            )
            self._coloured.add(pyrender.Mesh([primitive]))
        if lit:
            brightest = sorted(world.lights, key=lambda each: -float(each.flux_lm.mean()))[:_MOST_LIGHTS]
            eyes_m = tour.poses[:, :3, 3]
            arriving = [light.flux_lm.mean() / _distance_m(light, eyes_m) ** 2 for light in brightest]
            white = _WHITE / float(np.mean(np.sum(arriving, axis=0)))
            for light in brightest:
                at = np.eye(4)
                at[:3, 3] = light.position_m
                lamp = pyrender.PointLight(intensity=white * float(light.flux_lm.mean()))
                self._coloured.add(lamp, pose=at)

        self._labelled = pyrender.Scene()
        self._colour_of_node: dict[Any, tuple[int, int, int]] = {}
        for mesh in by_object(world):
            primitive = pyrender.Primitive(mesh.position_m, indices=mesh.triangles)
            node = self._labelled.add(pyrender.Mesh([primitive]))
            self._colour_of_node[node] = (mesh.shared & 255, mesh.shared >> 8, 0)

        self._cameras = [scene.add(lens) for scene in (self._coloured, self._labelled)]
        size = (camera.width_px, camera.height_px)
        self._renderers = [pyrender.OffscreenRenderer(*size) for _ in self._cameras]

    def draw(self, frame: int, ids: bool) -> Any:
        """Colour and depth, and object ids as colours."""
        for_colour, for_ids = self._renderers
        self._coloured.set_pose(self._cameras[0], self._poses[frame])
        colour, depth = for_colour.render(self._coloured, self._flags)
        if not ids:
            return colour, depth, None
        self._labelled.set_pose(self._cameras[1], self._poses[frame])
        labels, _ = for_ids.render(self._labelled, pyrender.RenderFlags.SEG, self._colour_of_node)
        return colour, depth, labels

    def picture(self, drawn: Any) -> Picture:
        """Depth is in metres already, 0 where nothing is."""
        colour, depth, labels = drawn
        if labels is not None:
            labels = labels[..., 0].astype(np.int32) + 256 * labels[..., 1].astype(np.int32)
        return Picture(colour, np.where(depth > 0, depth, np.inf).astype(np.float32), labels)


def lit(tour: Tour) -> Pyrender:
    """With lights, computed per pixel, without shadows."""
    return Pyrender(tour, lit=True)


def _distance_m(light: Light, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    distance_m: NDArray[np.float64] = np.linalg.norm(points_m - light.position_m, axis=1)
    return distance_m


def _material(material: Material, lit: bool) -> pyrender.Material:
    # Unlit, it multiplies texels as they are encoded, and shows what comes out.
    tint = material.base_colour if lit else material.base_colour ** (1 / 2.2)
    texture = None
    if material.texture is not None:
        texture = pyrender.Texture(source=material.texture[::-1], source_channels="RGB")
    return pyrender.MetallicRoughnessMaterial(
        baseColorFactor=[*map(float, tint), 1.0],
        baseColorTexture=texture,
        roughnessFactor=material.roughness,
        metallicFactor=material.metallic,
        doubleSided=True,
    )
