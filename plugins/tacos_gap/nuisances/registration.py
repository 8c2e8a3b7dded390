"""How a picture is shifted, turned and magnified against its expectation, from the pictures themselves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures import RealCapture
from tacos_gap.nuisances.freedom import Freedom
from tacos_gap.nuisances.mosaic import cell_means, of_pixels

ITERATIONS = 40
PRECISION = 1e-5
LEAST_CORRELATION = 0.5
"""Correlation of the aligned pictures below which they do not show the same."""

_SMOOTHED_PX = 5
"""Window of the smoothing before pictures are compared, which evens out differences of sharpness [px]."""


def registered(capture: RealCapture, freedoms: Sequence[Freedom]) -> NDArray[np.float64]:
    """(F,) nuisances of pose that align the expectation with the mean frame best, the others 0.

    The enhanced correlation coefficient does not mind gains and offsets. An affine map is fitted, so that
    what shears the picture turns no one's camera. All are 0 where no alignment is found.

    References
    ----------
    Evangelidis & Psarakis 2008, "Parametric image alignment using enhanced correlation coefficient
    maximization", IEEE PAMI 30(10).
    """
    nu = np.zeros(len(freedoms))
    names = [freedom.name for freedom in freedoms]
    if "shift_x_px" not in names:
        return nu
    matrix = _aligned(capture)
    if matrix is None:
        return nu
    centre = np.asarray(capture.geometry.centre_px, float)
    linear = matrix[:, :2]
    shift = linear @ centre + matrix[:, 2] - centre
    found = {
        "shift_x_px": shift[0],
        "shift_y_px": shift[1],
        "rotation_deg": np.degrees((linear[1, 0] - linear[0, 1]) / 2),
        "scale": (linear[0, 0] + linear[1, 1]) / 2 - 1,
    }
    for name, value in found.items():
        nu[names.index(name)] = value / freedoms[names.index(name)].sigma
    return nu


def _aligned(capture: RealCapture) -> NDArray[np.float64] | None:
    """(2, 3) affine map of the expectation's points to the picture's."""
    import cv2

    assert capture.expected_dn is not None
    one = len(capture.expected_dn) == 1
    black = np.float32(capture.context.black_level_dn)
    mosaic = capture.context.cfa is not None
    expected = capture.expected_dn[0].mean(axis=-1) - black
    real = (capture.real_dn.mean(axis=0) if one else capture.real_dn[0]).mean(axis=-1) - black
    full = np.float32(capture.context.white_level_dn) - black
    mask = capture.valid.astype(np.uint8)
    if mosaic:  # both clip at white, else the brighter colours would be other pictures
        expected, real = (cell_means(np.minimum(image, full)) for image in (expected, real))
        mask = (cell_means(mask) == 1).astype(np.uint8)
    pair = [np.ascontiguousarray(np.clip(image / full, 0, 1), np.float32) for image in (expected, real)]
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, ITERATIONS, PRECISION)
    start = np.eye(2, 3, dtype=np.float32)
    try:
        correlation, matrix = cv2.findTransformECC(
            pair[0], pair[1], start, cv2.MOTION_AFFINE, stop, mask, _SMOOTHED_PX
        )
    except cv2.error:  # it did not converge, or there is nothing to correlate
        return None
    if not (np.isfinite(matrix).all() and correlation > LEAST_CORRELATION):
        return None
    found = np.asarray(matrix, np.float64)
    return of_pixels(found) if mosaic else found
