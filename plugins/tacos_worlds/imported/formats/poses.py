"""Recorded trajectories: TUM, EuRoC, KITTI, tables with a line of names, COLMAP and NeRF.

Source: Sturm et al. (2012), TUM RGB-D benchmark: ``time tx ty tz qx qy qz qw``. Burri et al. (2016), EuRoC
MAV: ``time_ns, px, py, pz, qw, qx, qy, qz, ...``. Geiger et al. (2012), KITTI odometry: twelve numbers a
line, the rows of [R | t].
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tacos_files.dates import date_ns
from tacos_framework.files import decoded
from tacos_worlds.imported.formats.camera_poses import colmap_poses, nerf_poses
from tacos_worlds.imported.formats.file_bytes import Unreadable, file_bytes
from tacos_worlds.imported.formats.pose_columns import Columns, has_angles, named_columns, w_is_first

KITTI_RATE_HZ = 10.0
"""KITTI's files hold no times; its cameras took 10 frames a second [Hz]."""

AGENT_FROM_OPTICAL = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
"""Axes of an optical frame (x right, y down, z ahead) in those of an agent (x ahead, y left, z up)."""

Form = Literal["tum", "euroc", "kitti", "colmap", "nerf"]
StampUnit = Literal["s", "ns", "us", "ms"]
"""Of time stamps; ORB-SLAM3 and others write nanoseconds in TUM's layout."""
_SECONDS: dict[StampUnit, float] = {"s": 1.0, "ns": 1e-9, "us": 1e-6, "ms": 1e-3}
_SINCE_1970: dict[StampUnit, float] = {"ns": 1e17, "us": 1e14, "ms": 1e11}
"""Least stamps that count from 1970: such a number of the next larger unit lies 3000 years ahead."""
_SHORTEST_STEP_S, _LONG_STEP_S, _ABSURD_STEP_S = 1e-3, 5.0, 1000.0
"""Poses of one recording follow each other within the first two; beyond the last, the unit is another [s]."""
_LONGEST_S = 86_400.0
_SLOW_M_S, _FAST_M_S = 0.05, 60.0

_LEAST_DECIMALS = 1e-4
"""Of stamps in seconds; less is the rounding of whole nanoseconds [1]."""

_MATRICES = (12, 13, 16, 17)
"""Numbers of a line that holds the rows of [R | t], as KITTI has them, or of 4 x 4; after a stamp or not."""
_UNTIMED = {"kitti": "KITTI's layout", "colmap": "images.txt of COLMAP", "nerf": "transforms.json"}
_DATE = re.compile(r"(?<=\d{4}-\d\d-\d\d) (?=\d\d:)")
"""Between a date and its time of day."""
_INVERSE = re.compile(r"world[-_ ]?(to|2)[-_ ]?cam\w*|\bw2c\b|\bt_?cw\b", re.IGNORECASE)
_UNIT_TOLERANCE = 0.2
"""Of the length of a quaternion: some write two decimals [1]."""
_ROTATION_TOLERANCE = 0.01
"""Files have six digits or more; what is further from a rotation than this is damaged, or mirrored [1]."""


@dataclass(frozen=True, eq=False)
class RecordedPath:
    """Poses over time, as a file has them."""

    time_s: NDArray[np.float64]  # (K,) rising, from 0 [s]
    poses: NDArray[np.float64]  # (K, 4, 4) of a body in the world of the recording [m]
    form: Form  # layout of the file
    unit: StampUnit = "s"  # that its stamps were taken to have
    doubts: tuple[str, ...] = ()  # about the layout


def read_poses(file: Path) -> RecordedPath:
    """Read a file of poses; the format is told by its names or its numbers.

    Raises Unreadable where no line, or some line, is what one of the formats has.
    """
    text, _ = decoded(file_bytes(file))
    if text.lstrip().startswith("{"):
        return _untimed(nerf_poses(text), "nerf")
    lines = text.splitlines()
    if (found := colmap_poses(lines)) is not None:
        return _untimed(found, "colmap")
    table, columns, commas = _table(lines)
    wide = table.shape[1]
    comments = "\n".join(line for line in lines if line.lstrip().startswith("#"))
    doubts = []
    if inverse := _INVERSE.search(comments):
        doubts.append(f"a comment says {inverse[0]!r}: if that is of its poses, invert them")
    if columns is None and wide in _MATRICES and (path := _of_matrices(table, commas)):
        return replace(path, doubts=tuple(doubts))
    form: Form = "euroc" if commas else "tum"
    if columns is None and (wide == 8 or (wide > 8 and commas)):
        form = "euroc" if commas and not _has_decimals(table[:, 0]) else "tum"  # EuRoC counts nanoseconds
        told = w_is_first(comments)
        w_first = form == "euroc" if told is None else told
        columns = Columns(0, (1, 2, 3), (5, 6, 7, 4) if w_first else (4, 5, 6, 7))
        if commas and told is None and (form == "tum") == (wide > 8):
            place = "first, as in EuRoC" if w_first else "last, as in TUM"
            doubts.append(f"lines of {wide} numbers, with commas and no names: w is taken to be {place}")
    if columns is None:
        raise Unreadable(
            f"its lines have {wide} numbers: TUM has 8, EuRoC 8 or more with commas, KITTI 12; "
            "others need a line of names such as time, x, y, z, qx, qy, qz, qw"
        )
    quaternion = table[:, columns.rotation]
    off = np.abs(np.linalg.norm(quaternion, axis=1) - 1) > _UNIT_TOLERANCE
    if off.any():
        raise Unreadable(f"pose {np.argmax(off) + 1} has a rotation that is no unit quaternion")
    poses = np.tile(np.eye(4), (len(table), 1, 1))
    poses[:, :3, :3] = Rotation.from_quat(quaternion).as_matrix()
    poses[:, :3, 3] = table[:, columns.position] * columns.unit_m
    stated = next((unit for unit in _SECONDS if unit == columns.unit), None)
    stamp = table[:, columns.time]
    if columns.nanoseconds is not None:
        stamp = stamp - stamp[0] + table[:, columns.nanoseconds] * 1e-9
    return replace(_timed(stamp, poses, form, stated), doubts=tuple(doubts))


def _of_matrices(table: NDArray[np.float64], commas: bool) -> RecordedPath | None:
    """The path of a table of matrices; None where commas part numbers that are none, as wide as EuRoC's."""
    begin = table.shape[1] % 4
    matrices = np.tile(np.eye(4), (len(table), 1, 1))
    matrices[:, :3] = table[:, begin:][:, :12].reshape(-1, 3, 4)
    if commas and np.median(_no_rotations(matrices[:, :3, :3])):
        return None
    return _timed(table[:, 0], matrices, "tum") if begin else _untimed(matrices, "kitti")


def _table(lines: Sequence[str]) -> tuple[NDArray[np.float64], Columns | None, bool]:
    """The numbers of all lines, the columns that a line of names tells, and whether commas part them.

    Cells that hold no numbers, such as names of frames, are 0 where names tell which columns are needed.
    """
    rows: list[list[float]] = []
    commas, columns = False, None
    for number, line in enumerate(lines, start=1):
        if not rows and (found := named_columns(line)):
            columns = found
            continue
        if not rows and has_angles(line):
            raise Unreadable("it has roll, pitch and yaw, whose order no name tells: give qx, qy, qz, qw")
        text = _DATE.sub("T", line.split("#", 1)[0].strip())
        if not text:
            continue
        if ";" in text:  # decimal commas, as programs write them in many countries
            text = text.replace(",", ".")
        commas = commas or "," in text or ";" in text
        words = re.split(r"\s*[,;]\s*" if columns and commas else r"[\s,;]+", text.strip(",;"))
        try:
            rows.append(
                [_number(word, columns is None or k in columns.needed()) for k, word in enumerate(words)]
            )
        except ValueError as error:
            what = "numbers" if rows else "numbers, nor of names such as time, x, y, z, qx, qy, qz, qw"
            raise Unreadable(f"line {number} is not a line of {what}: {text[:60]!r}") from error
        if columns and len(words) <= max(columns.needed()):
            raise Unreadable(f"line {number} has {len(words)} numbers, its line of names more: {text[:60]!r}")
        if len(rows[-1]) != len(rows[0]):
            raise Unreadable(f"line {number} has {len(rows[-1])} numbers, the first one {len(rows[0])}")
    if not rows:
        raise Unreadable("it holds no poses")
    table = np.array(rows)
    used = table if columns is None else table[:, columns.needed()]
    if len(lost := np.flatnonzero(~np.isfinite(used).all(axis=1))):
        raise Unreadable(f"pose {lost[0] + 1} holds numbers that are not finite: leave out what was lost")
    return table, columns, commas


def _has_decimals(stamp: NDArray[np.float64]) -> bool:
    return bool(np.abs(stamp - np.rint(stamp)).max() > _LEAST_DECIMALS)


def _number(word: str, needed: bool) -> float:
    try:
        return float(word)
    except ValueError:
        if not needed:
            return 0.0
        if (since_1970_ns := date_ns(word)) is None:
            raise
        return since_1970_ns * 1e-9


def _untimed(poses: NDArray[np.float64], form: Form) -> RecordedPath:
    if not len(poses):
        raise Unreadable("it holds no poses")
    _check_rotations(poses[:, :3, :3])
    return RecordedPath(np.arange(len(poses)) / KITTI_RATE_HZ, poses, form)


def _check_rotations(matrices: NDArray[np.float64]) -> None:
    if len(wrong := np.flatnonzero(_no_rotations(matrices))):
        raise Unreadable(f"pose {wrong[0] + 1} has a matrix that is no rotation")


def _no_rotations(matrices: NDArray[np.float64]) -> NDArray[np.bool_]:
    bounded = np.clip(matrices, -2.0, 2.0)  # what is beyond is no rotation either way, and may not overflow
    off = np.abs(np.swapaxes(bounded, 1, 2) @ bounded - np.eye(3)).max(axis=(1, 2)) > _ROTATION_TOLERANCE
    return np.asarray(off | (np.linalg.det(bounded) < 0))


def _timed(
    stamp: NDArray[np.float64], poses: NDArray[np.float64], form: Form, stated: StampUnit | None = None
) -> RecordedPath:
    unit = stated or stamp_unit(stamp, form)
    time_s = (stamp - stamp[0]) * _SECONDS[unit]
    if len(falls := np.flatnonzero(np.diff(time_s) <= 0)):
        raise Unreadable(f"its times do not rise from line to line: see pose {falls[0] + 2}")
    _check_rotations(poses[:, :3, :3])
    position_m = poses[:, :3, 3]
    if time_s[-1] > _LONGEST_S:
        far_m = float(np.linalg.norm(np.diff(position_m, axis=0), axis=1).sum())
        raise Unreadable(
            f"it spans {time_s[-1]:.3g} s and walks {far_m:.3g} m in them, with stamps taken as {unit}: "
            f"give stamps in seconds, over no more than {_LONGEST_S:.0f} s"
        )
    return RecordedPath(time_s, poses, form, unit)


def stamp_unit(stamp: NDArray[np.float64], form: Form) -> StampUnit:
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
    """Doubts about the times of a path; None where there are none."""
    if path.form in _UNTIMED and path.form != "kitti":
        what = f"{_UNTIMED[path.form]} holds neither times nor a unit"
        return f"{what}: {KITTI_RATE_HZ:g} poses a second, by number or as in the file, and metres, are taken"
    if path.form == "kitti":
        return f"{_UNTIMED[path.form]} holds no times: {KITTI_RATE_HZ:g} poses a second are taken"
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
