"""Names of files: how a photograph was taken, and its kind."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

_TIME = re.compile(
    r"(?<![a-z0-9.,])(?:(?:exp(?:osure)?|shutter|time|tint|et|t)[ =:-]?)?"
    r"(\d+(?:[.,]\d+)?)\s?(us|\u00b5s|\u03bcs|ms|msec|s|sec)(?![a-z0-9])",
    re.IGNORECASE,
)
"""A decimal point or comma; the micro sign, or the Greek letter."""

_PART_OF_FRACTION = re.compile(r"\d[-/\u2044\u2215\u00f7]$")
"""Before a time; dashes, and what stands for a slash, which names of files cannot have."""

_DENOMINATOR = re.compile(r"(\d+(?:[.,]\d+)?)(s|sec)?", re.IGNORECASE)

_LEAST_BARE_DENOMINATOR, _LEAST_LOOSE_DENOMINATOR = 25, 60
"""Less after ``1-`` may number files; less than the other, after ``1_``, may be whole seconds [1]."""

_ON_DIALS = frozenset({60, 80, 100, 125, 160, 200, 250, 320, 400, 500, 640, 800, 1000, 1250, 1600, 2000})
_ON_DIALS |= {2500, 3200, 4000, 5000, 6400, 8000}
"""Denominators on the dials of cameras from which on ``1_250`` may be a time (ISO 516: steps of a third)."""

_MS = {"us": 1e-3, "\u00b5s": 1e-3, "\u03bcs": 1e-3, "ms": 1.0, "msec": 1.0, "s": 1e3, "sec": 1e3}

_NUMBER = r"(\d+(?:[.,]\d+)?)"
_ISO = re.compile(r"(?<![a-z])iso[ =-]?(\d{2,6})(?!\d)", re.IGNORECASE)
_GAIN = re.compile(rf"(?<![a-z0-9.,])(?:gain[ =-]?|g)?{_NUMBER}\s?db(?![a-z])", re.IGNORECASE)
_F_NUMBER = re.compile(r"(?<![a-z0-9])f[ =-]?(\d{1,2}[.,]\d)(?![\d.])", re.IGNORECASE)
"""With its decimal: ``f8`` may well be the eighth frame."""

_OTHERS = re.compile(r"(?<![a-z])(?:iso[ _=-]?\d+|f\d{1,2}[.,]\d)(?!\d)", re.IGNORECASE)
"""Numbers of other settings, which are no part of a fraction."""

_OF_CAPS = frozenset({"dark", "darks", "darkframe", "cap", "capped", "lenscap", "bias", "closed", "covered"})
_OF_WALLS = frozenset(
    {"flat", "flats", "flatfield", "wall", "walls", "white", "grey", "gray", "sphere", "bright"}
)


def settings_in_name(stem: str) -> dict[str, Any]:
    """Settings that the name of a file says, by their names in `Facts`.

    >>> settings_in_name("wall_ISO800_f2.8_1-250s"), settings_in_name("dark_gain12dB_0.5s")
    ({'exposure_ms': 4.0, 'iso': 800.0, 'f_number': 2.8}, {'exposure_ms': 500.0, 'gain_db': 12.0})
    """
    words = stem.replace("_", " ")
    found: dict[str, float | None] = {"exposure_ms": time_in_name_ms(stem)}
    for key, pattern in (("iso", _ISO), ("gain_db", _GAIN), ("f_number", _F_NUMBER)):
        said = pattern.search(words)
        found[key] = float(said[1].replace(",", ".")) if said else None
    return {key: value for key, value in found.items() if value is not None}


def time_in_name_ms(stem: str) -> float | None:
    """The shutter time that the name of a file says; None where it says none, or may mean two [ms].

    >>> time_in_name_ms("dark_20ms"), time_in_name_ms("shelf_1-250s_0"), time_in_name_ms("dark_1_30s")
    (20.0, 4.0, None)
    """
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
    return float(whole[1].replace(",", ".")) * _MS[whole[2].lower()]


def possible_time_ms(stem: str) -> float | None:
    """Shutter time that ``1_250`` may stand for, which only the brightness of several pictures can tell [ms].

    >>> possible_time_ms("shelf_1_250"), possible_time_ms("IMG_1_251"), possible_time_ms("IMG_2_250")
    (4.0, None, None)
    """
    for _, above, joint, below, unit in _fractions(stem):
        if unit is None and joint != "-" and above == "1" and below in _ON_DIALS:
            return 1e3 / below
    return None


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


def kind_in_name(path: Path) -> str | None:
    """The kind, dark or flat, that the words in the name of a file say, or else those of its folder.

    >>> kind_in_name(Path("a/LensCap_01.png")), kind_in_name(Path("flats/3.png")), kind_in_name(Path("a.png"))
    ('dark', 'flat', None)
    """
    return kind_in_words(path.stem) or kind_in_words(path.parent.name)


def kind_in_words(text: str) -> str | None:
    """The kind, dark or flat, that words say; None where they say none, or both."""
    words = set(re.findall(r"[a-z]+", text.lower()))
    kinds = [kind for kind, said in (("dark", _OF_CAPS), ("flat", _OF_WALLS)) if words & said]
    return kinds[0] if len(kinds) == 1 else None
