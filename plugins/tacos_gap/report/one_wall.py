"""Sentence on walls taken one way up, which cannot tell the shading of a lens from that of a lamp."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tacos_gap.answer.findings import Diagnosis
from tacos_gap.captures import RealCapture
from tacos_gap.hypotheses.effect_names import effect_words
from tacos_gap.report.words import listed

_SHADING = frozenset({"vignetting", "illumination-gradient", "lens-shading-correction"})
_TURNED = 0.01
"""Difference of two walls' shading over the level from which on camera or lamp were turned in between."""


def of_one_wall(diagnosis: Diagnosis, captures: Sequence[RealCapture]) -> list[str]:
    """The sentence that says so and what to do, where such a shading is named; empty else."""
    named = {cause.effect for cause in diagnosis.causes} | set(diagnosis.cause_set)
    walls = [capture for capture in captures if capture.kind == "flat"]
    if not named & _SHADING or not walls:
        return []
    shadings = [_shading(capture) for capture in walls]
    if any(float(np.abs(other - shadings[0]).max()) > _TURNED for other in shadings[1:]):
        return []
    names = listed([effect_words(name) for name in sorted(named & _SHADING)])
    return [
        f"{names[:1].upper()}{names[1:]}: walls taken one way up cannot tell the lens from the lamp. Take "
        f"the wall again with the camera turned by 90 degrees: what turns with it is the lens."
    ]


def _shading(capture: RealCapture) -> NDArray[np.float64]:
    """(6, 8) level of large parts of a wall over their mean, above the pedestal."""
    above = capture.real_dn.mean(axis=(0, 3)) - np.float32(capture.context.black_level_dn)
    rows, columns = np.array_split(np.arange(above.shape[0]), 6), np.array_split(np.arange(above.shape[1]), 8)
    parts = np.array([[np.median(above[np.ix_(r, c)]) for c in columns] for r in rows], np.float64)
    return parts / max(float(parts.mean()), 1e-6)
