"""Recorded trajectories: TUM, EuRoC and KITTI.

Source: Sturm et al. (2012), TUM RGB-D benchmark: ``time tx ty tz qx qy qz qw``. Burri et al. (2016), EuRoC
MAV: ``time_ns, px, py, pz, qw, qx, qy, qz, ...``. Geiger et al. (2012), KITTI odometry: twelve numbers a
line, the rows of [R | t].
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tacos_worlds.imported.formats.file_bytes import Unreadable, file_bytes

KITTI_RATE_HZ = 10.0
"""KITTI's files hold no times; its cameras took 10 frames a second [Hz]."""

AGENT_FROM_OPTICAL = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
"""Axes of an optical frame (x right, y down, z ahead) in those of an agent (x ahead, y left, z up)."""

StampUnit = Literal["s", "ns", "us", "ms"]
"""Of time stamps; ORB-SLAM3 and others write nanoseconds in TUM's layout."""
_SECONDS: dict[StampUnit, float] = {"s": 1.0, "ns": 1e-9, "us": 1e-6, "ms": 1e-3}
_SINCE_1970: dict[StampUnit, float] = {"ns": 1e17, "us": 1e14, "ms": 1e11}
"""Least stamps that count from 1970: such a number of the next larger unit lies 3000 years ahead."""
_SHORTEST_STEP_S, _LONG_STEP_S, _ABSURD_STEP_S = 1e-3, 5.0, 1000.0
"""Poses of one recording follow each other within the first two; beyond the last, the unit is another [s]."""
_LONGEST_S = 86_400.0
_SLOW_M_S, _FAST_M_S = 0.05, 60.0

_ROTATION_TOLERANCE = 0.01
"""Files have six digits or more; what is further from a rotation than this is damaged, or mirrored [1]."""


@dataclass(frozen=True, eq=False)
class RecordedPath:
    """Poses over time, as a file has them."""

    time_s: NDArray[np.float64]  # (K,) rising, from 0 [s]
    poses: NDArray[np.float64]  # (K, 4, 4) of a body in the world of the recording [m]
    form: Literal["tum", "euroc", "kitti"]
    """With unit: the layout of the file, and the unit its stamps were taken to have."""
    unit: StampUnit = "s"


def read_poses(file: Path) -> RecordedPath:
    """Read a file of poses; the format is told by its numbers.

    Raises Unreadable where no line, or some line, is what one of the formats has.
    """
    rows: list[list[float]] = []
    commas, names = False, list[str]()
    for number, line in enumerate(_text(file_bytes(file)).splitlines(), start=1):
        if not rows and (found := _quaternion_columns(line)):
            names = found
            continue
        text = line.split("#", 1)[0].strip()
        if not text:
            continue
        commas = commas or "," in text or ";" in text
        try:
            rows.append([float(word) for word in re.split(r"[\s,;]+", text.strip(",;"))])
        except ValueError as error:
            raise Unreadable(f"line {number} is not a line of numbers: {text[:60]!r}") from error
        if len(rows[-1]) != len(rows[0]):
            raise Unreadable(f"line {number} has {len(rows[-1])} numbers, the first one {len(rows[0])}")
    if not rows:
        raise Unreadable("it holds no poses")
    table = np.array(rows)
    if not np.isfinite(table).all():
        raise Unreadable("it holds numbers that are not finite")
    if table.shape[1] == 12 and not commas:
        poses = np.tile(np.eye(4), (len(table), 1, 1))
        poses[:, :3] = table.reshape(-1, 3, 4)
        _check_rotations(poses[:, :3, :3])
        return RecordedPath(np.arange(len(table)) / KITTI_RATE_HZ, poses, "kitti")
    form: Literal["tum", "euroc"] = "euroc" if commas else "tum"
    if table.shape[1] == 8 or (table.shape[1] > 8 and commas):
        order = names or list("wxyz" if commas else "xyzw")
        quaternion = table[:, [4 + order.index(part) for part in "xyzw"]]
        return _timed(table[:, 0], table[:, 1:4], quaternion, form)
    raise Unreadable(
        f"its lines have {table.shape[1]} numbers: TUM has 8, EuRoC 8 or more with commas, KITTI 12"
    )


def _text(content: bytes) -> str:
    utf_16 = content.startswith((b"\xff\xfe", b"\xfe\xff"))
    return content.decode("utf-16" if utf_16 else "utf-8-sig", "replace")


def _quaternion_columns(line: str) -> list[str]:
    """The order of a quaternion after the stamp and the position, where a line of names tells it.

    >>> _quaternion_columns("#timestamp [ns], p_RS_R_x [m], p_y [m], p_z [m], q_RS_w [], q_RS_x [], q_y, q_z")
    ['w', 'x', 'y', 'z']
    >>> _quaternion_columns("# timestamp tx ty tz qx qy qz qw"), _quaternion_columns("# by ORB")
    (['x', 'y', 'z', 'w'], [])
    """
    plain = re.sub(r"\[[^\]]*\]|#", " ", line.lower())
    names = re.split(r"[\s,;]+", plain.strip(" \t,;\r\n"))
    order = [name[-1] for name in names[4:8] if re.fullmatch(r"q.*[xyzw]", name)]
    return order if sorted(order) == list("wxyz") else []


def _check_rotations(matrices: NDArray[np.float64]) -> None:
    bounded = np.clip(matrices, -2.0, 2.0)  # what is beyond is no rotation either way, and may not overflow
    off = np.abs(np.swapaxes(bounded, 1, 2) @ bounded - np.eye(3)).max(axis=(1, 2)) > _ROTATION_TOLERANCE
    if len(wrong := np.flatnonzero(off | (np.linalg.det(bounded) < 0))):
        raise Unreadable(f"pose {wrong[0] + 1} has a matrix that is no rotation")


def _timed(
    stamp: NDArray[np.float64],
    position_m: NDArray[np.float64],
    quaternion: NDArray[np.float64],
    form: Literal["tum", "euroc"],
) -> RecordedPath:
    unit = stamp_unit(stamp, form)
    time_s = (stamp - stamp[0]) * _SECONDS[unit]
    if len(falls := np.flatnonzero(np.diff(time_s) <= 0)):
        raise Unreadable(f"its times do not rise from line to line: see pose {falls[0] + 2}")
    if len(wrong := np.flatnonzero(np.linalg.norm(quaternion, axis=1) < 0.5)):
        raise Unreadable(f"pose {wrong[0] + 1} has a rotation that is no unit quaternion")
    poses = np.tile(np.eye(4), (len(time_s), 1, 1))
    poses[:, :3, :3] = Rotation.from_quat(quaternion).as_matrix()
    poses[:, :3, 3] = position_m
    if time_s[-1] > _LONGEST_S:
        far_m = float(np.linalg.norm(np.diff(position_m, axis=0), axis=1).sum())
        raise Unreadable(
            f"it spans {time_s[-1]:.3g} s and walks {far_m:.3g} m in them, with stamps taken as {unit}: "
            f"give stamps in seconds, over no more than {_LONGEST_S:.0f} s"
        )
    return RecordedPath(time_s, poses, form, unit)


def stamp_unit(stamp: NDArray[np.float64], form: Literal["tum", "euroc"]) -> StampUnit:
    """The unit of stamps: that of the layout, unless their size says that it can be none of it.

    >>> stamp_unit(np.array([1.4e18, 1.40000000005e18]), "tum"), stamp_unit(np.array([0.0, 0.05]), "tum")
    ('ns', 's')
    """
    for unit, since_1970 in _SINCE_1970.items():
        if since_1970 <= stamp[0] < 1000 * since_1970:
            return unit
    usual: StampUnit = "s" if form == "tum" else "ns"
    step = float(np.median(np.diff(stamp))) if len(stamp) > 1 else 1 / _SECONDS[usual]
    if _SHORTEST_STEP_S <= step * _SECONDS[usual] < _ABSURD_STEP_S:
        return usual
    for unit, seconds in _SECONDS.items():
        if _SHORTEST_STEP_S <= step * seconds < _LONG_STEP_S:
            return unit
    return usual


def doubt_of_time(path: RecordedPath) -> str | None:
    """Why the times of a path are hardly in seconds, or whose they are; None where nothing is doubtful."""
    if path.form == "kitti":
        return f"KITTI's layout holds no times: {KITTI_RATE_HZ:g} poses a second are taken"
    if len(path.time_s) < 3:
        return None
    if (np.diff(path.time_s) == 1.0).all():
        return "stamps rise by just 1: numbers of frames? TUM has seconds"
    step_s, far_m = float(np.median(np.diff(path.time_s))), path.poses[1:, :3, 3] - path.poses[:-1, :3, 3]
    speed_m_s = float(np.linalg.norm(far_m, axis=1).sum()) / float(path.time_s[-1])
    said = f"it walks {speed_m_s:.3g} m/s, with a pose each {step_s:.3g} s"
    if step_s >= _LONG_STEP_S and speed_m_s < _SLOW_M_S:
        return f"{said}: stamps in milliseconds? TUM has seconds"
    if speed_m_s > _FAST_M_S:
        return f"{said}: positions in centimetres or millimetres, or stamps in another unit?"
    return None
