"""Which column of a table of poses is what, where a line of names says it."""

from __future__ import annotations

import re
from dataclasses import dataclass

_UNITS = {"ns": "ns", "nsec": "ns", "us": "us", "ms": "ms"}
_UNITS |= dict.fromkeys(("s", "sec", "secs", "second", "seconds"), "s")
_METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "km": 1e3, "ft": 0.3048, "in": 0.0254}
_TIME = re.compile(r"(.*[._])?(header\.)?(time_?stamp|stamp|time|t|sec(ond)?s?)([._](ns|us|ms|s|secs?))?")
_NANOSECONDS = re.compile(r"(.*[._])?(nsecs?|nanosec(onds)?)")
_POSITION = re.compile(
    r"(.*position[._]|.*translation[._]|t_?|p_?(?:rs_r_)?|pos_?)?(?P<axis>[xyz])"
    rf"([._]({'|'.join(_METRES)}))?"
)
_ROTATION = re.compile(r"(.*orientation[._]|.*rotation[._]|q_?(?:rs_)?|quat_?|rot_?)[wxyz]")
_OPENVINS = re.compile(r"timestamp\S*\s+q(_\S+)?\s+p(_\S+)?\s+v")
"""States of OpenVINS, whose q from the world to the body by JPL is Hamilton's from the body to the world."""
_XYZ, _QUATERNION = ("x", "y", "z"), ("qx", "qy", "qz", "qw")
_ANGLES = {"roll", "pitch", "yaw"}
_LABEL = re.compile(r"^[^,;:]*:\s+")
"""Before names: ``# format: timestamp tx ty tz qx qy qz qw``."""
_W_FIRST = re.compile(r"\b(q?_?)w\W+\1x\W+\1y\W+\1z\b|\bwxyz\b")
_W_LAST = re.compile(r"\b(q?_?)x\W+\1y\W+\1z\W+\1w\b|\bxyzw\b")


@dataclass(frozen=True)
class Columns:
    """Places of the numbers of a pose in a line."""

    time: int
    position: tuple[int, ...]  # x, y, z
    rotation: tuple[int, ...]  # x, y, z, w
    unit: str = ""  # of stamps, where it is said
    nanoseconds: int | None = None  # beside whole seconds, as ROS has them
    unit_m: tuple[float, ...] = (1.0, 1.0, 1.0)  # what numbers of positions count [m]

    def needed(self) -> tuple[int, ...]:
        rest = () if self.nanoseconds is None else (self.nanoseconds,)
        return (self.time, *self.position, *self.rotation, *rest)


def named_columns(line: str) -> Columns | None:
    """The columns that a line of names tells; None where it is none.

    >>> named_columns("#timestamp [ns], p_RS_R_x [m], p_y [m], p_z [m], q_RS_w, q_RS_x [], q_y, q_z").rotation
    (5, 6, 7, 4)
    >>> named_columns("# timestamp tx ty tz qx qy qz qw").rotation, named_columns("# by ORB")
    ((4, 5, 6, 7), None)
    """
    if _OPENVINS.match(line.lower().strip("#% ")):
        return Columns(0, (5, 6, 7), (1, 2, 3, 4), "s")
    plain = re.sub(r"\s*[\[(]([^\])]*)[\])]", r"[\1]", line.lower().strip().strip("#%").strip())
    plain = _LABEL.sub("", plain)
    cells = [
        cell.strip() for cell in (re.split(r"[,;]", plain) if re.search("[,;]", plain) else plain.split())
    ]
    names = [re.sub(r"\[.*\]", "", cell).strip("\"' _").replace("/", ".") for cell in cells]
    found: dict[str, int] = {}
    for index, name in enumerate(names):
        if _ROTATION.fullmatch(name):
            found.setdefault("q" + name[-1], index)
        elif said := _POSITION.fullmatch(name):
            found.setdefault(said["axis"], index)
        elif _NANOSECONDS.fullmatch(name):
            found.setdefault("ns", index)
        elif _TIME.fullmatch(name) and ("t" not in found or "stamp" in name):
            found["t"] = index
    if not {"t", *_XYZ, *_QUATERNION} <= found.keys():
        return None
    unit = _UNITS.get(_unit_word(cells[found["t"]], names[found["t"]]), "")
    position, rotation = (tuple(found[axis] for axis in axes) for axes in (_XYZ, _QUATERNION))
    unit_m = tuple(_METRES.get(_unit_word(cells[index], names[index]), 1.0) for index in position)
    return Columns(found["t"], position, rotation, unit, found.get("ns") if unit == "s" else None, unit_m)


def _unit_word(cell: str, name: str) -> str:
    """What stands in brackets behind a name, or else its last part."""
    in_brackets = re.search(r"\[(\w+)\]", cell)
    return in_brackets[1] if in_brackets else re.split(r"[._]", name)[-1]


def w_is_first(comments: str) -> bool | None:
    """True where comments tell the order of quaternions w, x, y, z; None where they tell none, or both.

    >>> w_is_first("# time, position, quaternion (w, x, y, z)"), w_is_first("# t x y z qx qy qz qw")
    (True, False)
    """
    first, last = _W_FIRST.search(comments.lower()), _W_LAST.search(comments.lower())
    return None if (first is None) == (last is None) else first is not None


def has_angles(line: str) -> bool:
    """True if a line of names has roll, pitch and yaw, whose order and axes no name tells."""
    return set(re.findall(r"roll|pitch|yaw", line.lower())) == _ANGLES
