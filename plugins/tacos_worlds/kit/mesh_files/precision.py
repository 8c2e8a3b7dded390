"""Positions that a file has already rounded."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

_COARSE = 2e-4
"""Steps larger than this share of the whole bend walls and tables [1]."""


def rounding_note(vertices: NDArray[np.float64], *, single: bool = False) -> Iterator[str]:
    """What is lost where positions far from the origin went through single precision.

    - `single`: whether they are known to have. Else they look so where all along the farthest axis are such
      numbers, but for the decimals they were written with, and not all of them are whole.
    """
    if not len(vertices) or not np.isfinite(vertices).all():
        return
    along = vertices[:, int(np.argmax(np.abs(vertices).max(axis=0)))]
    step = float(np.spacing(np.float32(np.abs(along).max())))
    if step < _COARSE * float(np.ptp(vertices, axis=0).max()):
        return
    off, whole = np.abs(along.astype(np.float32) - along), np.abs(along - along.round())
    if single or (off.max() < step / 20 and whole.max() > step / 20):
        yield (
            f"its positions, up to {np.abs(along).max():.3g} from the origin, look rounded to {step:.2g} by "
            "single precision: export them with an origin near the model, or in double precision"
        )
