"""One picture laid over another: an affine map found from coarse to fine.

A blurred picture aligns badly with a sharp one, since what both show are different edges. So a hypothesis is
laid over the real frames *after* its effects, when both are as sharp as each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

ITERATIONS = 60
PRECISION = 1e-6
LEAST_CORRELATION = 0.5
"""Correlation of the aligned pictures below which they do not show the same."""

LEAST_SIDE_PX = 32
"""Shorter side of a picture that can be aligned [px]."""

BORDER_PX = 4
"""Rim that is not compared: there a picture is what interpolation makes of its edge [px]."""

_LEVELS = 3
_SMOOTHED_PX = 5


@dataclass(frozen=True, eq=False)
class Overlay:
    """A picture in the pixels of another.

    Parameters
    ----------
    image
        (H, W) float32 the moved picture.
    inside
        (H, W) bool where it is known.
    """

    image: NDArray[np.float32]
    inside: NDArray[np.bool_]


def laid_over(picture: NDArray[np.float32], onto: NDArray[np.float32]) -> Overlay | None:
    """The picture moved by the affine map that correlates it best with another; None where nothing does.

    Gains and offsets do not matter.

    Parameters
    ----------
    picture, onto
        (H, W) float32 of any unit.

    References
    ----------
    Evangelidis & Psarakis 2008, "Parametric image alignment using enhanced correlation coefficient
    maximization", IEEE PAMI 30(10).
    """
    import cv2

    matrix = _aligned(_unit(onto), _unit(picture)) if min(onto.shape) >= LEAST_SIDE_PX else None
    if matrix is None:
        return None
    size = picture.shape[::-1]
    back = cv2.WARP_INVERSE_MAP
    moved = cv2.warpAffine(
        picture, matrix, size, flags=cv2.INTER_LANCZOS4 | back, borderMode=cv2.BORDER_REPLICATE
    )
    rim = np.zeros(picture.shape, np.float32)
    rim[BORDER_PX:-BORDER_PX, BORDER_PX:-BORDER_PX] = 1
    seen = cv2.warpAffine(rim, matrix, size, flags=cv2.INTER_NEAREST | back)
    return Overlay(np.asarray(moved, np.float32), np.asarray((seen > 0) & (rim > 0)))


def _unit(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Over its range, as the alignment counts its convergence."""
    low, high = float(image.min()), float(image.max())
    return np.ascontiguousarray((image - low) / max(high - low, 1e-6), np.float32)


def _aligned(fixed: NDArray[np.float32], moving: NDArray[np.float32]) -> NDArray[np.float32] | None:
    """(2, 3) affine map from points of `fixed` to those of `moving`; shifts first, on coarser pictures."""
    import cv2

    pyramid = [(fixed, moving)]
    while len(pyramid) < _LEVELS and min(pyramid[-1][0].shape) >= 2 * LEAST_SIDE_PX:
        first, second = (cv2.pyrDown(each) for each in pyramid[-1])
        pyramid.append((np.asarray(first, np.float32), np.asarray(second, np.float32)))
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, ITERATIONS, PRECISION)
    matrix = np.eye(2, 3, dtype=np.float32)
    correlation = -1.0
    for level, (a, b) in enumerate(reversed(pyramid)):
        if level:
            matrix[:, 2] *= 2
        everywhere = np.ones(b.shape, np.uint8)
        motion = cv2.MOTION_AFFINE if level == len(pyramid) - 1 else cv2.MOTION_TRANSLATION
        try:
            correlation, found = cv2.findTransformECC(
                a, b, matrix.copy(), motion, stop, everywhere, _SMOOTHED_PX
            )
        except cv2.error:  # it did not converge, or there is nothing to correlate
            continue
        if np.isfinite(found).all():
            matrix = np.asarray(found, np.float32)
    return matrix if np.isfinite(correlation) and correlation > LEAST_CORRELATION else None
