"""Exposure times in the names of image files."""

from __future__ import annotations

import re
from collections.abc import Iterator

_TIME = re.compile(
    r"(?<![a-z0-9.,])(?:(?:exp(?:osure)?|shutter|time|tint|et|t)[ =:-]?)?"
    r"(\d+(?:[.,p]\d+)?)\s?(ns|us|\u00b5s|\u03bcs|ms|msec|s|sec)(?![a-z0-9])",
    re.IGNORECASE,
)
"""A decimal point or comma, or ``2p5ms``; the micro sign, or the Greek letter."""

_WITHOUT_UNIT = re.compile(
    r"(?<![a-z])(?:exp(?:osure)?(?: ?time)?|shutter|integration(?: ?time)?|tint)[ =:-]?"
    r"(\d+(?:[.,]\d+)?)(?![a-z0-9.,]|\s?(?:ns|us|ms|msec|s|sec)(?![a-z]))",
    re.IGNORECASE,
)

_THOUSANDS = re.compile(r"[1-9]\d{0,2},\d{3}")
"""``8,000us`` is eight milliseconds to some, eight microseconds to others."""

_DECIMAL = re.compile(r"^(\d+)_(\d+(?:ns|us|ms|s)_\d+)$", re.IGNORECASE)
"""A decimal point written as a line, before the number of the frame: ``0_5ms_3``."""

_PART_OF_FRACTION = re.compile(r"\d[-/\u2044\u2215\u00f7]$")
"""Before a time; dashes, and what stands for a slash, which names of files cannot have."""

_DENOMINATOR = re.compile(r"(\d+(?:[.,]\d+)?)(s|sec)?", re.IGNORECASE)

_LEAST_BARE_DENOMINATOR, _LEAST_LOOSE_DENOMINATOR = 25, 60
"""Less after ``1-`` may number files; less than the other, after ``1_``, may be whole seconds [1]."""

_ON_DIALS = frozenset({60, 80, 100, 125, 160, 200, 250, 320, 400, 500, 640, 800, 1000, 1250, 1600, 2000})
_ON_DIALS |= {2500, 3200, 4000, 5000, 6400, 8000}
"""Denominators on the dials of cameras from which on ``1_250`` may be a time (ISO 516: steps of a third)."""

_MS = {"ns": 1e-6, "us": 1e-3, "\u00b5s": 1e-3, "\u03bcs": 1e-3, "ms": 1.0, "msec": 1.0, "s": 1e3, "sec": 1e3}

_OTHERS = re.compile(r"(?<![a-z])(?:iso[ _=-]?\d+|f\d{1,2}[.,]\d)(?!\d)", re.IGNORECASE)
"""Numbers of other settings, which are no part of a fraction."""


def time_in_name_ms(stem: str) -> float | None:
    """The shutter time that the name of a file says; None where it says none, or may mean two [ms].

    >>> [time_in_name_ms(stem) for stem in ("dark_20ms", "shelf_1-250s_0", "0_5ms_3", "dark_1_30s")]
    [20.0, 4.0, 0.5, None]
    """
    stem = _DECIMAL.sub(r"\1.\2", stem)
    for before, above, joint, below, unit in _fractions(stem):
        dash = joint == "-"
        if unit is None and (not dash or before == "-" or above != "1" or below < _LEAST_BARE_DENOMINATOR):
            continue  # numbers of files, or a date
        if above != "1" and not dash:
            continue  # the number of a file, then a time
        if above != "1" or not below or (not dash and below < _LEAST_LOOSE_DENOMINATOR):
            return None
        return 1e3 / below
    stem = stem.replace("_", " ")
    if (whole := _TIME.search(stem)) is None or _PART_OF_FRACTION.search(stem[: whole.start()]):
        return None
    if _THOUSANDS.fullmatch(whole[1]):
        return None
    return float(re.sub("[,pP]", ".", whole[1])) * _MS[whole[2].lower()] or None


def possible_time_ms(stem: str) -> float | None:
    """Shutter time that ``1_250`` may stand for, which only the brightness of several pictures can tell [ms].

    >>> possible_time_ms("shelf_1_250"), possible_time_ms("IMG_1_251"), possible_time_ms("IMG_2_250")
    (4.0, None, None)
    """
    for _, above, joint, below, unit in _fractions(stem):
        if unit is None and joint != "-" and above == "1" and below in _ON_DIALS:
            return 1e3 / below
    return None


def time_without_unit(stem: str) -> float | None:
    """The number that a name calls an exposure time without saying what it counts.

    >>> time_without_unit("ExposureTime5000_Gain4"), time_without_unit("exp_0.25"), time_without_unit("5")
    (5000.0, 0.25, None)
    """
    found = _WITHOUT_UNIT.search(stem.replace("_", " "))
    return float(found[1].replace(",", ".")) if found else None


def _fractions(stem: str) -> Iterator[tuple[str, str, str, float, str | None]]:
    """Numbers side by side: what stands before, above, between and below, and the unit; 1-250s, 1_250.

    A slash cannot stand in a name.
    """
    stem = re.sub("[\u2044\u2215\u00f7]", "-", stem)
    joined = re.sub(r"(?<=\d) (?=s(?:ec)?(?![a-z0-9]))", "", _OTHERS.sub("x", stem), flags=re.IGNORECASE)
    parts = ["", *re.split(r"([-_ ()\[\]+=;])", joined)]
    for before, above, joint, below in zip(parts[::2], parts[1::2], parts[2::2], parts[3::2], strict=False):
        found = _DENOMINATOR.fullmatch(below)
        if above.isdecimal() and joint in "-_ " and found is not None:
            yield before, above, joint, float(found[1].replace(",", ".")), found[2]
