"""The noise of detected points, estimated from the view itself.

Whatever lens and pose, they lie on a smooth image of the board. What is left beside a smooth surface through
them is the noise of detection.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

LEAST_PX = 0.01
"""No corner is found better than this [px]."""

HIGHEST_DEGREE = 8
FREE_SHARE = 0.5
"""Surfaces have at most this degree, and so many coefficients for a point."""


def smooth_residual(
    points_mm: NDArray[np.float64], corners_px: NDArray[np.float64], centre_px: tuple[float, float]
) -> tuple[NDArray[np.float64], float]:
    """Residual that no smooth surface explains, and the noise it shows.

    A homography seen through a radial lens, and beside it the polynomial over the board that leaves the least
    variance for its degrees of freedom. It is fitted again without points that stray.

    - `centre_px`: where about the lens is centred [px].

    Returns: (K, 2) residual [px], and its standard deviation along one axis, by the median of its size [px].
    """
    flat = points_mm[:, :2] - points_mm[:, :2].mean(axis=0)
    flat = flat / np.abs(flat).max()
    left = corners_px - _through_a_lens(flat, corners_px, np.array(centre_px))
    kept = np.ones(len(left), bool)
    best: tuple[float, NDArray[np.float64]] = (np.inf, left)
    for _ in range(2):
        best = min(_surfaces(flat, left, kept), key=lambda found: found[0], default=(np.inf, left))
        size = np.hypot(*best[1].T)
        kept = size <= 6 * max(np.median(size) / 1.18, LEAST_PX)
    spread = best[0] if np.isfinite(best[0]) else float(left.std())
    return best[1], max(spread, LEAST_PX)


def _through_a_lens(
    flat: NDArray[np.float64], corners_px: NDArray[np.float64], centre_px: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(K, 2) the homography and the radial lens that bring points nearest to corners [px].

    The lens is a ratio of powers, as of a fisheye powers alone do not converge.
    """
    size = float(np.abs(corners_px - centre_px).max())
    target = (corners_px - centre_px) / size
    homography, _ = cv2.findHomography(flat, target, 0)
    if homography is None:
        return np.broadcast_to(corners_px.mean(axis=0), corners_px.shape)
    start = np.append(homography.ravel()[:8] / homography[2, 2], np.zeros(4))
    points = np.column_stack([flat, np.ones(len(flat))])

    def seen(theta: NDArray[np.float64]) -> NDArray[np.float64]:
        plain = points @ np.append(theta[:8], 1.0).reshape(3, 3).T
        plain = plain[:, :2] / np.where(np.abs(plain[:, 2:]) < 1e-6, 1e-6, plain[:, 2:])
        square = (plain**2).sum(axis=1, keepdims=True)
        swell, shrink = (1 + square * (a + b * square) for a, b in theta[8:].reshape(2, 2))
        return np.asarray(plain * swell / np.where(np.abs(shrink) < 1e-3, 1e-3, shrink))

    def left(theta: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.append((seen(theta) - target).ravel(), 1e-4 * theta[8:])  # powers above and below compete

    found = least_squares(left, start, method="lm", max_nfev=150)
    return np.asarray(seen(found.x) * size + centre_px)


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
    return np.column_stack(
        [across[:, i] * down[:, j] for i in range(degree + 1) for j in range(degree + 1 - i)]
    )


def steadied(noises_px: Sequence[float]) -> list[float]:
    """Noises of the views of one camera, none far below the middle one: each is but an estimate [px]."""
    middle = float(np.median(noises_px)) if len(noises_px) else 0.0
    return [max(noise, 0.6 * middle, LEAST_PX) for noise in noises_px]
