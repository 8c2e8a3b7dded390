"""Plain arrays for effects on samples, and what goes with them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.values import ImageContext, ImageGeometry

BLACK_DN = 16.0
WHITE_DN = 255.0


def geometry_of(signal: NDArray[Any], **changes: Any) -> ImageGeometry:
    """A sensor just as large as the image, its principal point in the middle."""
    height, width = signal.shape[1:3]
    middle = ((width - 1) / 2, (height - 1) / 2)
    return ImageGeometry(width, height, focal_length_px=500, centre_px=middle, pixel_um=3, **changes)


def context(**changes: Any) -> ImageContext:
    """8 bits with a pedestal of 16 DN."""
    return ImageContext(**{"black_level_dn": BLACK_DN, "white_level_dn": WHITE_DN, **changes})


def make(effect: type[Any], **settings: Any) -> Any:
    """An effect with settings."""
    return effect(effect.Config(**settings))


def run(
    effect: Any, signal: NDArray[Any], *, seed: int = 0, binning: float = 1.0, **circumstances: Any
) -> NDArray[Any]:
    """The samples with an effect."""
    return effect.on_array(
        signal,
        geometry=geometry_of(signal, binning=binning),
        context=context(**circumstances),
        rng=np.random.default_rng(seed),
    )


def moments(effect: Any, mean: Any, variance: Any, signal: NDArray[Any], *, binning: float = 1.0) -> Any:
    """The moments after an effect, for images of the size of `signal`."""
    return effect.moments(
        np.asarray(mean, np.float64),
        np.asarray(variance, np.float64),
        geometry=geometry_of(signal, binning=binning),
        context=context(),
    )


def flats(
    mean_dn: Any = 100.0,
    sigma_dn: float = 3.0,
    *,
    frames: int = 4,
    height: int = 60,
    width: int = 80,
    channels: int = 3,
    seed: int = 11,
) -> NDArray[np.float64]:
    """(N, H, W, C) frames of an even card with white Gaussian noise."""
    noise = np.random.default_rng(seed).standard_normal((frames, height, width, channels))
    return mean_dn + sigma_dn * noise


def neighbour_correlation(frames: NDArray[Any]) -> float:
    """Correlation of the noise of pixels beside each other in a row."""
    noise = frames - frames.mean()
    return float((noise[:, :, 1:] * noise[:, :, :-1]).mean() / noise.var())
