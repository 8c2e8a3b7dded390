"""NeRF: ``transforms.json`` as instant-ngp and Nerfstudio read it."""

from __future__ import annotations

import json
import math
from typing import Any, ClassVar

import numpy as np

from tacos_export.conventions import centre_from_corner_px, depth_codes
from tacos_export.dataset.frame import Dataset, photograph, refuse_k3, write_image
from tacos_framework import Camera, FrameBatch

DEPTH_CODES_PER_M = 1000.0
"""Depth files are in millimetres."""

_OPENGL_FROM_OPENCV = np.diag([1.0, -1.0, -1.0, 1.0])


class NerfWriter:
    """``images/``, ``depth/`` (16-bit millimetres) and ``transforms.json``.

    ``transform_matrix`` takes points of a camera to the world; here the camera has x right, y *up* and looks
    along *-z* (OpenGL), and principal points count from the image's corner. Each frame has its own
    intrinsics, which stand above them all as well where the rig has one camera. Positions are those of the
    scene, near its origin: ``origin_m`` is to be added for coordinates of the file.

    Source: Mildenhall et al. 2020, "NeRF", ECCV; Müller et al. 2022, "Instant neural graphics primitives",
    ACM TOG.
    """

    eight_bits: ClassVar[bool] = True

    def __init__(self, dataset: Dataset) -> None:
        refuse_k3(dataset, "nerf")
        self._dataset = dataset
        self._frames: list[dict[str, Any]] = []
        self._origin_m = [0.0, 0.0, 0.0]
        self._cameras = {camera.name: self._intrinsics(camera) for camera in dataset.rig.cameras}

    def add(self, index: int, frame: FrameBatch) -> None:
        self._origin_m = frame.episode.world.origin_m.tolist()
        for i, view in enumerate(frame.capture.views):
            name = f"{view.camera.name}_{index:06d}.png"
            write_image(self._dataset.out / "images" / name, photograph(frame, i, self._dataset.encoding))
            write_image(self._dataset.out / "depth" / name, depth_codes(view.depth_m[0], DEPTH_CODES_PER_M))
            self._frames.append(
                {
                    "file_path": f"images/{name}",
                    "depth_file_path": f"depth/{name}",
                    "transform_matrix": (view.world_from_camera[0] @ _OPENGL_FROM_OPENCV).tolist(),
                    **self._cameras[view.camera.name],
                }
            )

    def close(self) -> None:
        shared = self._cameras.popitem()[1] if len(self._cameras) == 1 else {}
        data = {**shared, "origin_m": self._origin_m, "frames": self._frames}
        path = self._dataset.out / "transforms.json"
        path.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")

    def _intrinsics(self, camera: Camera) -> dict[str, Any]:
        lens = self._dataset.lenses[camera.name]
        cx, cy = centre_from_corner_px(camera)
        names = ("k1", "k2", "k3", "k4") if lens.lens == "fisheye" else ("k1", "k2", "p1", "p2")
        return {
            "camera_model": "OPENCV_FISHEYE" if lens.lens == "fisheye" else "OPENCV",
            "fl_x": camera.focal_length_px,
            "fl_y": camera.focal_length_px,
            "cx": cx,
            "cy": cy,
            "w": camera.width_px,
            "h": camera.height_px,
            "camera_angle_x": math.radians(camera.hfov_deg),
            **dict(zip(names, lens.distortion, strict=False)),
        }
