"""The noise of detected points, estimated from the view itself.

Whatever lens and pose, they lie on a smooth image of the board. What is left beside a smooth surface through
them is the noise of detection.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

LEAST_PX = 0.01
"""No corner is found better than this [px]."""

HIGHEST_DEGREE = 8
FREE_SHARE = 0.5
"""Surfaces have at most this degree, and so many coefficients for a point."""


def smooth_residual(
    points_mm: NDArray[np.float64], corners_px: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float]:
    """What no smooth surface explains, and the noise it tells.

    A homography, and beside it the polynomial over the board that leaves the least variance for its degrees
    of freedom. It is fitted again without points that stray.

    Parameters
    ----------
    points_mm
        (K, 3) points of the board [mm].
    corners_px
        (K, 2) where they are seen [px].

    Returns
    -------
    (K, 2) residual [px], and its standard deviation along one axis, by the median of its size [px].
    """
    flat = points_mm[:, :2] - points_mm[:, :2].mean(axis=0)
    flat = flat / np.abs(flat).max()
    homography, _ = cv2.findHomography(flat, corners_px, 0)
    if homography is None:
        return np.zeros_like(corners_px), LEAST_PX
    seen = cv2.perspectiveTransform(flat[None], homography)[0]
    left = corners_px - seen
    kept = np.ones(len(left), bool)
    best: tuple[float, NDArray[np.float64]] = (np.inf, left)
    for _ in range(2):
        best = min(_surfaces(flat, left, kept), key=lambda found: found[0], default=(np.inf, left))
        size = np.hypot(*best[1].T)
        kept = size <= 6 * max(np.median(size) / 1.18, LEAST_PX)
    spread = best[0] if np.isfinite(best[0]) else float(left.std())
    return best[1], max(spread, LEAST_PX)


def _surfaces(
    flat: NDArray[np.float64], left: NDArray[np.float64], kept: NDArray[np.bool_]
) -> Iterator[tuple[float, NDArray[np.float64]]]:
    """For each degree that the points allow, the standard deviation about the surface, and the residual."""
    for degree in range(2, HIGHEST_DEGREE + 1):
        terms = _terms(flat, degree)
        freedom = int(kept.sum()) - terms.shape[1]
        if terms.shape[1] > FREE_SHARE * kept.sum():
            return
        residual = left - terms @ np.linalg.lstsq(terms[kept], left[kept], rcond=None)[0]
        yield float(np.sqrt((residual[kept] ** 2).sum() / (2 * freedom))), residual


def _terms(flat: NDArray[np.float64], degree: int) -> NDArray[np.float64]:
    """(K, P) products of Legendre polynomials up to a total degree."""
    across = np.polynomial.legendre.legvander(flat[:, 0], degree)
    down = np.polynomial.legendre.legvander(flat[:, 1], degree)
    return np.column_stack([across[:, i] * down[:, j] for i in range(degree + 1) for j in range(degree + 1 - i)])


def steadied(noises_px: Sequence[float]) -> list[float]:
    """Noises of the views of one camera, none far below the middle one: each is but an estimate [px]."""
    middle = float(np.median(noises_px)) if len(noises_px) else 0.0
    return [max(noise, 0.6 * middle, LEAST_PX) for noise in noises_px]
