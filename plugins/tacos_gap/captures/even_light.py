"""Flats whose expectation is a mean of a few noisy files: the even light behind it.

As it stands its noise goes through whatever a hypothesis does to files, where a codec or a denoiser takes it
for detail; the real files hold none of it. A flat shows no detail, so that its light is known far better than
any of its pixels.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.capture import RealCapture
from tacos_gap.captures.targets.wall import shading

TILE_PX = 16
"""Side of the tiles whose means tell whether the light is as smooth as believed [px]."""

WITHIN = 0.002
"""Relative deviation of tiles from smooth light that is negligible, half of the margin of a level."""

BEYOND_NOISE = 2.0
"""Variance of tiles, over that of the stated noise and what is negligible, above which there is structure."""

SHARED = 4.0
"""Standard deviations of a correlation from which on the expectation holds the camera's own pattern: then it
is the mean of the real camera's files, and its pattern is expected."""


def with_even_light(capture: RealCapture) -> RealCapture:
    """The flat with smooth light for an expectation, where it is the mean of a few noisy files of that.

    Itself where that is not so: of other kinds, of a mosaic, where nobody stated noise of the expectation,
    and where it holds more than smooth light and that noise.
    """
    expected = capture.expected_dn
    if capture.kind != "flat" or not capture.expected_frames or expected is None or len(expected) > 1:
        return capture
    if capture.context.cfa is not None or not capture.valid.all() or min(capture.valid.shape) < 4 * TILE_PX:
        return capture
    smooth = _smooth(expected[0])
    own, real = expected[0] - smooth, capture.real_dn.mean(axis=0)
    if _is_structured(own, smooth, capture) or _share_a_pattern(own, real - _smooth(real)):
        return capture
    return replace(capture, expected_dn=smooth[None], expected_frames=0)


def _smooth(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """(H, W, C) the smooth part of an image, channel by channel [DN]."""
    planes = [shading(plane, has_defects=False) for plane in np.moveaxis(image, -1, 0)]
    return np.stack(planes, axis=-1)


def _is_structured(own: NDArray[np.float32], smooth: NDArray[np.float32], capture: RealCapture) -> bool:
    """True if tiles part from smooth light by more than noise."""
    signal = smooth.mean(axis=(0, 1)) - np.float32(capture.context.black_level_dn)
    noise = capture.noise.variance_dn2(signal) / (capture.expected_frames * TILE_PX**2)
    allowed = BEYOND_NOISE * (noise + (WITHIN * signal) ** 2)
    rows, columns = (side // TILE_PX for side in own.shape[:2])
    tiles = own[: rows * TILE_PX, : columns * TILE_PX].reshape(rows, TILE_PX, columns, TILE_PX, -1)
    return bool((tiles.mean(axis=(1, 3)).var(axis=(0, 1)) > allowed).any())


def _share_a_pattern(own: NDArray[np.float32], real: NDArray[np.float32]) -> bool:
    """True if (H, W, C) deviations from smooth light are correlated, pixel by pixel."""
    norm = float(np.linalg.norm(own) * np.linalg.norm(real))
    correlation = float(np.vdot(own, real)) / norm if norm else 0.0
    return correlation * np.sqrt(own.size) > SHARED
