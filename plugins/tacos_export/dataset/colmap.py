"""COLMAP: a reconstruction in text whose cameras and poses are known."""

from __future__ import annotations

from typing import ClassVar

from tacos_export.conventions import centre_from_corner_px, in_file_world, quaternion_xyzw
from tacos_export.dataset.frame import Dataset, photograph, write_image, write_lines
from tacos_framework import Camera, FrameBatch
from tacos_framework.camera import invert_pose

_NO_POINTS = "# 3D points: none, as poses were known before any were triangulated"


class ColmapWriter:
    """``images/CAMERA/`` and ``sparse/0/`` with ``cameras.txt``, ``images.txt`` and ``points3D.txt``.

    Poses take points of the world to the camera, quaternions are w, x, y, z, and principal points count from
    the image's corner. There are no points: `colmap point_triangulator` finds them with poses held.

    Source: Schönberger and Frahm 2016, "Structure-from-motion revisited", CVPR, and "Output format" of its
    documentation.
    """

    eight_bits: ClassVar[bool] = True

    def __init__(self, dataset: Dataset) -> None:
        self._dataset = dataset
        self._numbers = {camera.name: i for i, camera in enumerate(dataset.rig.cameras, start=1)}
        self._images: list[str] = []

    def add(self, index: int, frame: FrameBatch) -> None:
        for i, view in enumerate(frame.capture.views):
            name = f"{view.camera.name}/{index:06d}.png"
            write_image(self._dataset.out / "images" / name, photograph(frame, i, self._dataset.encoding))
            pose = invert_pose(in_file_world(view.world_from_camera[0], frame.episode.world))
            x, y, z, w = quaternion_xyzw(pose)
            numbers = " ".join(f"{value:.12g}" for value in (w, x, y, z, *pose[:3, 3]))
            number = len(self._images) // 2 + 1
            self._images += [f"{number} {numbers} {self._numbers[view.camera.name]} {name}", ""]

    def close(self) -> None:
        folder = self._dataset.out / "sparse" / "0"
        cameras = [self._camera(camera) for camera in self._dataset.rig.cameras]
        write_lines(folder / "cameras.txt", ["# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]", *cameras])
        heads = ["# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME", "# POINTS2D[] as X Y POINT3D_ID: none"]
        write_lines(folder / "images.txt", [*heads, *self._images])
        write_lines(folder / "points3D.txt", [_NO_POINTS])

    def _camera(self, camera: Camera) -> str:
        lens = self._dataset.lenses[camera.name]
        f, values = camera.focal_length_px, lens.distortion
        if lens.lens == "fisheye":
            model = "OPENCV_FISHEYE"
        elif not any(values):
            model, values = "PINHOLE", ()
        elif values[4]:
            model, values = "FULL_OPENCV", (*values, 0.0, 0.0, 0.0)
        else:
            model, values = "OPENCV", values[:4]
        numbers = " ".join(f"{value:.12g}" for value in (f, f, *centre_from_corner_px(camera), *values))
        return f"{self._numbers[camera.name]} {model} {camera.width_px} {camera.height_px} {numbers}"
