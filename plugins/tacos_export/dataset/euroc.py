"""EuRoC MAV (ASL): images of all cameras by nanosecond, their calibration, and the body's true path."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_export.conventions import in_file_world, quaternion_xyzw, stamp_ns
from tacos_export.dataset.frame import Dataset, photograph, refuse_k3, write_image, write_lines
from tacos_export.dataset.tum import walk_folder
from tacos_framework import Camera, FrameBatch, Trajectory, to_yaml

_TRUTH = (
    "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], "
    "v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad s^-1], "
    "b_w_RS_S_z [rad s^-1], b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]"
)
_SPEED_STEP_S = 1e-3


class EurocWriter:
    """``walk_000/mav0/cam0/`` and so on, with ``state_groundtruth_estimate0``; one folder a walk.

    The body is the agent, and ``T_BS`` takes points of a camera to it. There is no IMU, so that its
    biases are 0. Its ``radtan`` has no k3: a lens with one is refused.

    Source: Burri et al. 2016, "The EuRoC micro aerial vehicle datasets", IJRR 35(10).
    """

    eight_bits: ClassVar[bool] = True

    def __init__(self, dataset: Dataset) -> None:
        self._dataset = dataset
        refuse_k3(dataset, "euroc")
        self._truth: dict[str, list[str]] = {}
        self._images: dict[str, list[list[str]]] = {}

    def add(self, index: int, frame: FrameBatch) -> None:
        walk = walk_folder(frame)
        time_s = float(frame.episode.time_s[0])
        stamp = str(stamp_ns(time_s))
        listed = self._images.setdefault(walk, [[] for _ in frame.images])
        for i in range(len(frame.images)):
            path = self._dataset.out / walk / "mav0" / f"cam{i}" / "data" / f"{stamp}.png"
            write_image(path, photograph(frame, i, self._dataset.encoding))
            listed[i].append(f"{stamp},{stamp}.png")
        pose = in_file_world(frame.episode.trajectory.at(np.array([time_s]))[0], frame.episode.world)
        x, y, z, w = quaternion_xyzw(pose)
        speed = velocity_m_s(frame.episode.trajectory, time_s)
        numbers = ",".join(f"{value:.9f}" for value in (*pose[:3, 3], w, x, y, z, *speed, *np.zeros(6)))
        self._truth.setdefault(walk, []).append(f"{stamp},{numbers}")

    def close(self) -> None:
        for walk, truth in self._truth.items():
            folder = self._dataset.out / walk / "mav0"
            write_lines(folder / "state_groundtruth_estimate0" / "data.csv", [_TRUTH, *truth])
            for i, camera in enumerate(self._dataset.rig.cameras):
                lines = ["#timestamp [ns],filename", *self._images[walk][i]]
                write_lines(folder / f"cam{i}" / "data.csv", lines)
                described = to_yaml(self._sensor(camera, walk), flow_style=None)
                (folder / f"cam{i}" / "sensor.yaml").write_text(described, encoding="utf-8")

    def _sensor(self, camera: Camera, walk: str) -> dict[str, object]:
        lens = self._dataset.lenses[camera.name]
        f = camera.focal_length_px
        return {
            "sensor_type": "camera",
            "comment": camera.name,
            "T_BS": {"cols": 4, "rows": 4, "data": camera.agent_from_camera.ravel().tolist()},
            "rate_hz": self._rate_hz(walk),
            "resolution": [camera.width_px, camera.height_px],
            "camera_model": "pinhole",
            "intrinsics": [f, f, *camera.centre_px],
            "distortion_model": "radial-tangential" if lens.lens == "brown" else "equidistant",
            "distortion_coefficients": list(lens.distortion[:4]),
        }

    def _rate_hz(self, walk: str) -> float:
        stamps = [int(line.partition(",")[0]) for line in self._truth[walk]]
        return round(1e9 / float(np.median(np.diff(stamps))), 6) if len(stamps) > 1 else 0.0


def velocity_m_s(trajectory: Trajectory, time_s: float) -> NDArray[np.float64]:
    """(3,) speed of the agent in the world, by differences along its path [m/s]."""
    low, high = trajectory.time_s[0], trajectory.time_s[-1]
    ends = np.clip([time_s - _SPEED_STEP_S, time_s + _SPEED_STEP_S], low, high)
    if ends[1] <= ends[0]:
        return np.zeros(3)
    poses = trajectory.at(ends)
    return np.asarray((poses[1, :3, 3] - poses[0, :3, 3]) / (ends[1] - ends[0]))
