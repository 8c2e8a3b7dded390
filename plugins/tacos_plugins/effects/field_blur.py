"""Blur of another width at each pixel."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.effects.blur import blur

_STEP = 1.15  # from each width to the next
_SHARP = 1e-3
"""Variance over the largest below which a pixel is as good as sharp."""


def blur_over_field(
    light: NDArray[np.floating],
    width_px: NDArray[np.float64],
    kernel_of_width: Callable[[float], NDArray[np.float64]],
) -> NDArray[np.floating]:
    """Light blurred by a kernel of another width at each pixel.

    A mixture of two blurs a step apart stands in for those between them, with the right variance.

    - `light`: (N, H, W, C) float32 or float64.
    - `width_px`: (H, W) widths, never negative, such that variances grow with their squares [px].
    - `kernel_of_width`: the kernel of a width, see :func:`tacos_plugins.effects.blur.blur`.

    Returns: same shape and dtype.
    """
    blurred = np.zeros_like(light)
    for width, share in _shares(width_px**2):
        rows, columns = _extent(share.max(axis=1)), _extent(share.max(axis=0))
        part = share[rows, columns].astype(light.dtype)[..., None]
        if width == 0.0:
            blurred[:, rows, columns] += part * light[:, rows, columns]
            continue
        kernel = kernel_of_width(width)
        reach = len(kernel) // 2
        wider, higher = _padded(columns, reach, share.shape[1]), _padded(rows, reach, share.shape[0])
        spread = blur(light[:, higher.around, wider.around], kernel)
        blurred[:, rows, columns] += part * spread[:, higher.inside, wider.inside]
    return blurred


def _shares(variance: NDArray[np.float64]) -> Iterator[tuple[float, NDArray[np.float64]]]:
    """Widths that are mixed, and the (H, W) share of each in every pixel; those of a pixel come to 1."""
    least, most = float(variance.min()), float(variance.max())
    sharp = least < most * _SHARP
    least = max(least, most * _SHARP)
    count = max(2, math.ceil(math.log(most / least) / (2 * math.log(_STEP))) + 1)
    steps = np.geomspace(least, most, count) if most > least else np.array([most])
    steps = np.concatenate([[0.0], steps]) if sharp else steps
    for i, step in enumerate(steps):
        height = np.zeros(len(steps))
        height[i] = 1.0
        share = np.interp(variance, steps, height)
        if share.any():
            yield math.sqrt(step), share


def _extent(share: NDArray[np.float64]) -> slice:
    """From the first place that has a share to the last."""
    places = np.flatnonzero(share)
    return slice(int(places[0]), int(places[-1]) + 1)


class _Padded(NamedTuple):
    around: slice  # a part of an axis and what lies around it
    inside: slice  # the part within that


def _padded(part: slice, reach: int, size: int) -> _Padded:
    start, stop = max(part.start - reach, 0), min(part.stop + reach, size)
    return _Padded(slice(start, stop), slice(part.start - start, part.stop - start))
