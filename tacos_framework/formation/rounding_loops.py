"""Rounding to whole digital numbers, compiled; imported late, as numba takes a while."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_framework.compiled import unaliased

_BLACK = np.float32(0)


@unaliased
def round_and_clip(
    samples_dn: NDArray[np.float32], white_level_dn: np.float32, out: NDArray[np.float32]
) -> None:
    """Fill (N,) with samples rounded, halves to even, and clipped; what is no number stays none [DN]."""
    for i in range(len(samples_dn)):
        whole = np.rint(samples_dn[i])
        whole = _BLACK if whole < _BLACK else whole
        out[i] = white_level_dn if whole > white_level_dn else whole
