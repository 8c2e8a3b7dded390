"""KITTI: rectified images of one camera or a stereo pair, calibration, depth, disparity, boxes, poses."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_export.camera.description import second_from_first
from tacos_export.conventions import depth_codes
from tacos_export.dataset.frame import (
    Dataset,
    box_of,
    distortion_faults,
    photograph,
    visible_objects,
    write_image,
    write_lines,
)
from tacos_framework import Camera, Fault, FrameBatch, UserError
from tacos_framework.camera import invert_pose

CODES_PER_UNIT = 256.0
"""Depth [1/m] and disparity [1/px] in 16 bits, as the development kits of KITTI have it."""

_FOLDERS = ("image_2", "image_3")
_UNKNOWN_3D = "-1 -1 -1 -1000 -1000 -1000 -10"


class KittiWriter:
    """``image_2/`` (left), ``image_3/`` (right), ``calib/``, ``depth_2/``, ``disp_2/``, ``label_2/``, poses.

    Boxes are those of the visible pixels; truncation, occlusion and boxes in space hold KITTI's values for
    unknown. ``poses.txt`` has the poses of the left camera, from where it was at first. Disparity is that of
    the true depth.

    Source: Geiger, Lenz and Urtasun 2012, "Are we ready for autonomous driving?", CVPR, and the development
    kits for objects, depth, stereo and odometry.
    """

    eight_bits: ClassVar[bool] = True

    def __init__(self, dataset: Dataset) -> None:
        self._dataset = dataset
        cameras = dataset.rig.cameras
        faults = distortion_faults(dataset, "kitti")
        if len(cameras) > 2:
            faults.append(Fault("--format kitti", f"the rig has {len(cameras)} cameras", "one or two"))
        if len(cameras) == 2 and not _rectified(*cameras):
            faults.append(
                Fault("--format kitti", "the cameras are no rectified pair", "parallel, side by side, alike")
            )
        if faults:
            raise UserError(faults)
        self._poses: list[str] = []
        self._world_from_first: NDArray[np.float64] | None = None

    def add(self, index: int, frame: FrameBatch) -> None:
        out, stem = self._dataset.out, f"{index:06d}"
        views = frame.capture.views
        for i, folder in enumerate(_FOLDERS[: len(views)]):
            write_image(out / folder / f"{stem}.png", photograph(frame, i, self._dataset.encoding))
        left = views[0]
        write_image(out / "depth_2" / f"{stem}.png", depth_codes(left.depth_m[0], CODES_PER_UNIT))
        if len(views) == 2:
            focal_baseline = -projection(left.camera, views[1].camera)[0, 3]
            disparity = focal_baseline / left.depth_m[0].astype(np.float64)  # 0 where nothing is
            write_image(out / "disp_2" / f"{stem}.png", depth_codes(disparity, CODES_PER_UNIT))
        world = frame.episode.world
        labels = []
        for thing, mask in visible_objects(left, world):
            box = " ".join(f"{edge:.2f}" for edge in box_of(mask))
            kind = world.objects[thing].class_name.replace(" ", "_")
            labels.append(f"{kind} -1 -1 -10 {box} {_UNKNOWN_3D}")
        write_lines(out / f"label_2/{stem}.txt", labels)
        write_lines(out / f"calib/{stem}.txt", self._calibration())
        pose = left.world_from_camera[0]
        if self._world_from_first is None:
            self._world_from_first = pose
        relative = invert_pose(self._world_from_first) @ pose
        self._poses.append(_numbers(relative[:3].ravel()))

    def close(self) -> None:
        write_lines(self._dataset.out / "poses.txt", self._poses)

    def _calibration(self) -> list[str]:
        cameras = self._dataset.rig.cameras
        left, right = cameras[0], cameras[-1]
        projections = [projection(left, camera) for camera in (left, right, left, right)]  # grey, then colour
        identity = _numbers(np.eye(3, 4).ravel())
        return [
            *(f"P{i}: {_numbers(matrix.ravel())}" for i, matrix in enumerate(projections)),
            f"R0_rect: {_numbers(np.eye(3).ravel())}",
            f"Tr_velo_to_cam: {identity}",
            f"Tr_imu_to_velo: {identity}",
        ]


def projection(left: Camera, camera: Camera) -> NDArray[np.float64]:
    """(3, 4) matrix that takes points of the left camera's frame to pixels of a camera parallel to it."""
    return np.asarray(camera.intrinsics @ second_from_first(left, camera)[:3])


def _rectified(left: Camera, right: Camera) -> bool:
    pose = second_from_first(left, right)
    beside = pose[0, 3] < 0 and np.allclose(pose[1:3, 3], 0, atol=1e-9)
    parallel = np.allclose(pose[:3, :3], np.eye(3), atol=1e-9)
    return bool(beside and parallel and np.allclose(left.intrinsics, right.intrinsics))


def _numbers(values: NDArray[np.float64]) -> str:
    return " ".join(f"{value:.12e}" for value in values)
