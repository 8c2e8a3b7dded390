"""Names of files: how a photograph was taken, and its kind."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from tacos_files.exposure_names import time_in_name_ms

_NUMBER = r"(\d+(?:[.,]\d+)?)"
_ISO = re.compile(r"(?<![a-z])iso[ =-]?(\d{2,6})(?!\d)", re.IGNORECASE)
_GAIN = re.compile(rf"(?<![a-z0-9.,])(?:gain[ =-]?|g)?{_NUMBER}\s?db(?![a-z])", re.IGNORECASE)
_F_NUMBER = re.compile(r"(?<![a-z0-9])f[ =-]?(\d{1,2}[.,]\d)(?![\d.])", re.IGNORECASE)
"""With its decimal: ``f8`` may well be the eighth frame."""

_OF_ONE_CAMERA = re.compile(r"(?<![a-z])(left|right|l|r|cam(?:era)?[ _-]?\d+)(?![a-z])", re.IGNORECASE)

_OF_CAPS = frozenset({"dark", "darks", "darkframe", "cap", "capped", "lenscap", "bias", "closed", "covered"})
_OF_WALLS = frozenset(
    {"flat", "flats", "flatfield", "wall", "walls", "white", "grey", "gray", "sphere", "bright"}
)


def settings_in_name(path: Path) -> dict[str, Any]:
    """Settings that the name of a file says, or else that of its folder, by their names in `Facts`.

    >>> settings_in_name(Path("wall_ISO800_f2.8_4ms.png")), settings_in_name(Path("20ms/dark_gain12dB.png"))
    ({'exposure_ms': 4.0, 'iso': 800.0, 'f_number': 2.8}, {'exposure_ms': 20.0, 'gain_db': 12.0})
    """
    return _settings_in_words(path.parent.name) | _settings_in_words(path.stem)


def _settings_in_words(stem: str) -> dict[str, Any]:
    words = stem.replace("_", " ")
    found: dict[str, float | None] = {"exposure_ms": time_in_name_ms(stem)}
    for key, pattern in (("iso", _ISO), ("gain_db", _GAIN), ("f_number", _F_NUMBER)):
        said = pattern.search(words)
        found[key] = float(said[1].replace(",", ".")) if said else None
    return {key: value for key, value in found.items() if value is not None}


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


def of_several_cameras(paths: Iterable[Path]) -> list[tuple[str, str]]:
    """Pairs of files whose names, or folders, differ only in the camera that they name.

    >>> of_several_cameras([Path("a/left01.png"), Path("a/right01.png"), Path("a/right02.png")])
    [('a/left01.png', 'a/right01.png')]
    """
    first: dict[str, str] = {}
    pairs = []
    for path in paths:
        name = f"{path.parent.name}/{path.name}"
        if (of_any := _OF_ONE_CAMERA.sub("", name)) == name:
            continue
        if (twin := first.setdefault(of_any, name)) != name:
            pairs.append((twin, name))
    return pairs
