"""Which column of a table of poses is what, where a line of names says it."""

from __future__ import annotations

import re
from dataclasses import dataclass

_UNITS = {"ns": "ns", "nsec": "ns", "us": "us", "ms": "ms", "s": "s", "sec": "s", "secs": "s"}
_TIME = re.compile(r"(.*[._])?(header\.)?(time_?stamp|stamp|time|t|secs?)([._](ns|us|ms|s|secs?))?")
_NANOSECONDS = re.compile(r"(.*[._])?(nsecs?|nanosec(onds)?)")
_POSITION = re.compile(r"(.*position[._]|.*translation[._]|t_?|p_?(?:rs_r_)?|pos_?)?[xyz]")
_ROTATION = re.compile(r"(.*orientation[._]|.*rotation[._]|q_?(?:rs_)?|quat_?|rot_?)[wxyz]")
_OPENVINS = re.compile(r"timestamp\S*\s+q(_\S+)?\s+p(_\S+)?\s+v")
"""States of OpenVINS, whose q from the world to the body by JPL is Hamilton's from the body to the world."""
_XYZ, _QUATERNION = ("x", "y", "z"), ("qx", "qy", "qz", "qw")
_ANGLES = {"roll", "pitch", "yaw"}


@dataclass(frozen=True)
class Columns:
    """Places of the numbers of a pose in a line."""

    time: int
    position: tuple[int, ...]  # x, y, z
    rotation: tuple[int, ...]  # x, y, z, w
    unit: str = ""  # of stamps, where it is said
    nanoseconds: int | None = None  # beside whole seconds, as ROS has them

    def needed(self) -> tuple[int, ...]:
        rest = () if self.nanoseconds is None else (self.nanoseconds,)
        return (self.time, *self.position, *self.rotation, *rest)


def named_columns(line: str) -> Columns | None:
    """The columns that a line of names tells; None where it is none.

    >>> named_columns("#timestamp [ns], p_RS_R_x [m], p_y [m], p_z [m], q_RS_w [], q_RS_x [], q_y, q_z")
    Columns(time=0, position=(1, 2, 3), rotation=(5, 6, 7, 4), unit='ns', nanoseconds=None)
    >>> named_columns("# timestamp tx ty tz qx qy qz qw").rotation, named_columns("# by ORB")
    ((4, 5, 6, 7), None)
    """
    if _OPENVINS.match(line.lower().strip("#% ")):
        return Columns(0, (5, 6, 7), (1, 2, 3, 4), "s")
    plain = re.sub(r"\s*[\[(]([^\])]*)[\])]", r"[\1]", line.lower().strip().strip("#%").strip())
    cells = [
        cell.strip() for cell in (re.split(r"[,;]", plain) if re.search("[,;]", plain) else plain.split())
    ]
    names = [re.sub(r"\[.*\]", "", cell).strip("\"' _").replace("/", ".") for cell in cells]
    found: dict[str, int] = {}
    for index, name in enumerate(names):
        if _ROTATION.fullmatch(name):
            found.setdefault("q" + name[-1], index)
        elif _POSITION.fullmatch(name):
            found.setdefault(name[-1], index)
        elif _NANOSECONDS.fullmatch(name):
            found.setdefault("ns", index)
        elif _TIME.fullmatch(name) and ("t" not in found or "stamp" in name):
            found["t"] = index
    if not {"t", *_XYZ, *_QUATERNION} <= found.keys():
        return None
    stated = re.search(r"\[(\w+)\]", cells[found["t"]]) or re.search(r"[._]([a-z]+)$", names[found["t"]])
    unit = _UNITS.get(stated[1], "") if stated else ""
    position, rotation = (tuple(found[axis] for axis in axes) for axes in (_XYZ, _QUATERNION))
    return Columns(found["t"], position, rotation, unit, found.get("ns") if unit == "s" else None)


def has_angles(line: str) -> bool:
    """True if a line of names has roll, pitch and yaw, whose order and axes no name tells."""
    return set(re.findall(r"roll|pitch|yaw", line.lower())) == _ANGLES
