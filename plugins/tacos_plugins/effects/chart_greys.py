"""Exponent of the curve between light and code, by the grey patches of a chart alone.

Whatever the colour of the light, and a veil of it over all patches, the codes of greys of reflectance r are
``(a + b r)^gamma`` in each channel; no colour matrix changes them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tacos_framework import ObservedCapture
from tacos_plugins.effects.closed_forms import Measured

_EXPONENTS = np.geomspace(0.2, 4.0, 121)
_GREY = 0.12
"""Spread of a patch's channels over their mean, white taken as 1, up to which it is a grey: those of
ColorCheckers have up to 0.09, their colours above 0.3."""

_FEWEST = 5
_USABLE = (0.01, 0.97)
"""Codes over full scale that are neither lost in rounding nor clipped."""

_CLEARLY = 0.5
"""Misfit with a curve over that without up to which greys lie on a curve. Gloss, dirt and age of a chart
bend a linear camera's: a real one's came to 0.8."""

_Channels = Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]]


def exponent_of(capture: ObservedCapture) -> Measured | None:
    """The exponent of a chart's greys; None where a straight line fits them nearly as well."""
    channels = _greys(capture)
    if min((len(codes) for _, codes in channels), default=0) < _FEWEST:
        return None
    misfits = np.array([_misfit(channels, exponent) for exponent in _EXPONENTS])
    best = int(np.argmin(misfits))
    freedom = sum(len(codes) - 2 for _, codes in channels) - 1
    if misfits[best] > _CLEARLY**2 * _misfit(channels, 1.0):
        return None
    as_good = _EXPONENTS[misfits <= misfits[best] * (1 + 1 / freedom)]
    step = float(_EXPONENTS[best] * np.log(_EXPONENTS[1] / _EXPONENTS[0]))
    return Measured(float(_EXPONENTS[best]), max(float(np.ptp(as_good)) / 2, step))


def _greys(capture: ObservedCapture) -> _Channels:
    """Light and code of the greys over full scale, channel by channel; none of a chart without colour."""
    if capture.patches is None or capture.real_dn.shape[-1] != 3:
        return ()
    boxes, colours_dn = capture.patches
    black, white = capture.context.black_level_dn, capture.context.white_level_dn
    light = (colours_dn - black) / (white - black)
    shares = light / light[light.sum(axis=1).argmax()]
    grey = np.ptp(shares, axis=1) <= _GREY * shares.mean(axis=1)
    mean = capture.real_dn.mean(axis=0)
    seen = [np.median(mean[y : y + h, x : x + w], axis=(0, 1)) for x, y, w, h in boxes[grey].tolist()]
    codes = (np.array(seen, np.float64).reshape(-1, 3) - black) / (white - black)
    usable = (codes > _USABLE[0]) & (codes < _USABLE[1])
    return [(light[grey][use, c], codes[use, c]) for c, use in enumerate(usable.T)]


def _misfit(channels: _Channels, exponent: float) -> float:
    """Sum of squares of what the best veils and lights leave, each relative to its code."""
    total = 0.0
    for light, codes in channels:
        straight = codes ** (1 / exponent)
        weight = exponent / straight
        line = np.polyfit(light, straight, 1, w=weight)
        total += float(np.sum((weight * (np.polyval(line, light) - straight)) ** 2))
    return total
