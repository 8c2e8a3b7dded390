"""Names of effects in sentences."""

from __future__ import annotations

_ABBREVIATIONS = frozenset({"CFA", "DSNU", "HDR", "ISP", "JPEG", "LED", "MTF", "PRNU", "PSF"})
"""Words of the field that are written in capitals."""


def effect_words(name: str) -> str:
    """An effect as it stands in a sentence: ``lens-distortion`` becomes ``lens distortion``."""
    return " ".join(w.upper() if w.upper() in _ABBREVIATIONS else w for w in name.split("-"))
