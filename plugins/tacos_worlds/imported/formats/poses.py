"""Recorded trajectories: TUM, EuRoC and KITTI.

References
----------
Sturm et al. (2012), TUM RGB-D benchmark: ``time tx ty tz qx qy qz qw``.
Burri et al. (2016), EuRoC MAV: ``time_ns, px, py, pz, qw, qx, qy, qz, ...``.
Geiger et al. (2012), KITTI odometry: twelve numbers a line, the rows of [R | t].
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tacos_worlds.imported.formats.file_bytes import file_bytes
from tacos_worlds.imported.formats.gltf_buffers import Damaged

KITTI_RATE_HZ = 10.0
"""KITTI's files hold no times; its cameras took 10 frames a second [Hz]."""

AGENT_FROM_OPTICAL = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
"""Axes of an optical frame (x right, y down, z ahead) in those of an agent (x ahead, y left, z up)."""

_ROTATION_TOLERANCE = 0.01
"""Files have six digits or more; what is further from a rotation than this is damaged, or mirrored [1]."""


@dataclass(frozen=True, eq=False)
class RecordedPath:
    """Poses over time, as a file has them.

    Parameters
    ----------
    time_s
        (K,) rising, from 0 [s].
    poses
        (K, 4, 4) of a body in the world of the recording [m].
    """

    time_s: NDArray[np.float64]
    poses: NDArray[np.float64]
    form: Literal["tum", "euroc", "kitti"]


def read_poses(file: Path) -> RecordedPath:
    """Read a file of poses; the format is told by its numbers.

    Raises
    ------
    Damaged, Unreadable
        Where no line, or some line, is what one of the formats has.
    """
    rows: list[list[float]] = []
    commas = False
    for number, line in enumerate(file_bytes(file).decode("utf-8", "replace").splitlines(), start=1):
        text = line.split("#", 1)[0].strip()
        if not text:
            continue
        commas = commas or "," in text
        try:
            rows.append([float(word) for word in text.replace(",", " ").split()])
        except ValueError as error:
            raise Damaged(f"line {number} is not a line of numbers: {text[:60]!r}") from error
        if len(rows[-1]) != len(rows[0]):
            raise Damaged(f"line {number} has {len(rows[-1])} numbers, the first one {len(rows[0])}")
    if not rows:
        raise Damaged("it holds no poses")
    table = np.array(rows)
    if not np.isfinite(table).all():
        raise Damaged("it holds numbers that are not finite")
    if table.shape[1] == 12 and not commas:
        poses = np.tile(np.eye(4), (len(table), 1, 1))
        poses[:, :3] = table.reshape(-1, 3, 4)
        _check_rotations(poses[:, :3, :3])
        return RecordedPath(np.arange(len(table)) / KITTI_RATE_HZ, poses, "kitti")
    if table.shape[1] >= 8 and commas:
        return _timed(table[:, 0] * 1e-9, table[:, 1:4], table[:, [5, 6, 7, 4]], "euroc")
    if table.shape[1] == 8:
        return _timed(table[:, 0], table[:, 1:4], table[:, 4:8], "tum")
    raise Damaged(
        f"its lines have {table.shape[1]} numbers: TUM has 8, EuRoC 8 or more with commas, KITTI 12"
    )


def _check_rotations(matrices: NDArray[np.float64]) -> None:
    bounded = np.clip(matrices, -2.0, 2.0)  # what is beyond is no rotation either way, and may not overflow
    off = np.abs(np.swapaxes(bounded, 1, 2) @ bounded - np.eye(3)).max(axis=(1, 2)) > _ROTATION_TOLERANCE
    if len(wrong := np.flatnonzero(off | (np.linalg.det(bounded) < 0))):
        raise Damaged(f"pose {wrong[0] + 1} has a matrix that is no rotation")


def _timed(
    time_s: NDArray[np.float64],
    position_m: NDArray[np.float64],
    quaternion: NDArray[np.float64],
    form: Literal["tum", "euroc"],
) -> RecordedPath:
    if np.any(np.diff(time_s) <= 0):
        raise Damaged("its times do not rise from line to line")
    if np.any(np.linalg.norm(quaternion, axis=1) < 0.5):
        raise Damaged("a rotation is no unit quaternion")
    poses = np.tile(np.eye(4), (len(time_s), 1, 1))
    poses[:, :3, :3] = Rotation.from_quat(quaternion).as_matrix()
    poses[:, :3, 3] = position_m
    return RecordedPath(time_s - time_s[0], poses, form)
