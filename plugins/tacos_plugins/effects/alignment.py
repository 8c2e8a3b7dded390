"""The affine map between two pictures of one thing, found from coarse to fine.

A picture out of focus and a sharp one show other edges, and a lens that is focused elsewhere magnifies by a
percent: both agree on what is large first.
"""

from __future__ import annotations

from collections.abc import Iterator
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from tacos_framework import ObservedCapture
from tacos_plugins.effects.mosaic_cells import cell_means, of_pixels

ITERATIONS = 60
PRECISION = 1e-6
LEAST_CORRELATION = 0.5
"""Correlation of the aligned pictures below which they do not show the same."""

FARTHEST_SCALE = 1.5
"""Magnification along any direction up to which a map is taken for another view of the same."""

LEAST_SIDE_PX = 32
"""Shorter side of a picture that can be aligned [px]."""

LEVELS = 4
"""Pictures of a pyramid, each of half the size: an eighth shows what a disc of 12 px leaves."""

_SMOOTHED_PX = 5
"""Window of the smoothing before pictures are compared, which evens out differences of sharpness [px]."""

Picture = NDArray[np.float32]


_ALIGNED: WeakKeyDictionary[ObservedCapture, NDArray[np.float64] | None] = WeakKeyDictionary()


def aligned_with_expected(capture: ObservedCapture) -> NDArray[np.float64] | None:
    """(2, 3) affine map of the expectation's points to the picture's; None where nothing aligns.

    Worked out once per capture.
    """
    if capture not in _ALIGNED:
        _ALIGNED[capture] = _aligned_with_expected(capture)
    return _ALIGNED[capture]


def _aligned_with_expected(capture: ObservedCapture) -> NDArray[np.float64] | None:
    if capture.expected_dn is None:
        return None
    one = len(capture.expected_dn) == 1
    black = np.float32(capture.context.black_level_dn)
    full = np.float32(capture.context.white_level_dn) - black
    mosaic = capture.context.cfa is not None
    expected = capture.expected_dn[0].mean(axis=-1) - black
    real = (capture.real_dn.mean(axis=0) if one else capture.real_dn[0]).mean(axis=-1) - black
    valid = capture.valid
    if mosaic:  # both clip at white, else the brighter colours would be other pictures
        expected, real = (cell_means(np.minimum(image, full)) for image in (expected, real))
        valid = cell_means(valid) == 1
    fixed, moving = (
        np.ascontiguousarray(np.clip(each / full, 0, 1), np.float32) for each in (expected, real)
    )
    found = aligned(fixed, moving, valid)
    return of_pixels(found) if mosaic and found is not None else found


def aligned(
    fixed: Picture, moving: Picture, valid: NDArray[np.bool_] | None = None
) -> NDArray[np.float64] | None:
    """(2, 3) affine map from points of `fixed` to those of `moving`; None where nothing aligns.

    Gains and offsets do not matter. The map begins as a shift of the coarsest pictures.

    `fixed`, `moving`: (H, W) float32 of any unit, of like range. `valid`: (H, W) where `moving` counts;
    everywhere if None.

    Source: Evangelidis & Psarakis 2008, "Parametric image alignment using enhanced correlation coefficient
    maximization", IEEE PAMI 30(10).
    """
    import cv2

    if min(fixed.shape) < LEAST_SIDE_PX:
        return None
    counts = np.ones(moving.shape, np.uint8) if valid is None else valid.astype(np.uint8)
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, ITERATIONS, PRECISION)
    matrix = np.eye(2, 3, dtype=np.float32)
    correlation = -1.0
    coarse_first = list(_pyramid(fixed, moving, counts))[::-1]
    for level, (a, b, mask) in enumerate(coarse_first):
        if level:
            matrix[:, 2] *= 2
        motion = cv2.MOTION_AFFINE if level or len(coarse_first) == 1 else cv2.MOTION_TRANSLATION
        try:
            correlation, found = cv2.findTransformECC(a, b, matrix.copy(), motion, stop, mask, _SMOOTHED_PX)
        except cv2.error:  # it did not converge, or there is nothing to correlate
            correlation = -1.0
            continue
        if np.isfinite(found).all():
            matrix = np.asarray(found, np.float32)
    correlates = np.isfinite(correlation) and correlation > LEAST_CORRELATION
    return np.asarray(matrix, np.float64) if correlates and _is_a_view(matrix) else None


def _is_a_view(matrix: Picture) -> bool:
    """True if an affine map squeezes no direction away: along a single edge any map correlates."""
    squeezed = np.linalg.svd(matrix[:, :2], compute_uv=False)
    return bool(squeezed.max() < FARTHEST_SCALE and squeezed.min() > 1 / FARTHEST_SCALE)


def _pyramid(
    fixed: Picture, moving: Picture, mask: NDArray[np.uint8]
) -> Iterator[tuple[Picture, Picture, NDArray[np.uint8]]]:
    """The pictures and the mask, and the same in half the size again and again."""
    import cv2

    for level in range(LEVELS):
        if level:
            fixed, moving = (np.asarray(cv2.pyrDown(each), np.float32) for each in (fixed, moving))
            mask = np.ascontiguousarray(mask[::2, ::2])
        yield fixed, moving, mask
        if min(fixed.shape) < 2 * LEAST_SIDE_PX:
            return
