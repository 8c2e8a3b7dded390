"""Hot pixels of the dark: bright ones that stand alone and stay."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tacos_gap.statistics.block import Sample, StatisticBlock
from tacos_gap.statistics.sampled import sampled
from tacos_plugins.effects.darks import ROUNDING_DN, isolated

STEPS = (1.0, 2.0, 4.0, 10.0, 25.0)
"""Heights that pixels are counted above, over the lowest at which noise seldom counts."""

_SPREADS = 5.0
_FEW = 1e-4
"""Share of pixels just above the noise that no task notices; the higher they stand, the fewer."""

_MODEL = 0.2
"""Relative difference between counts that is negligible: no sensor's distribution is the formula's."""


def hot_pixel_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Number of pixels above some heights in every frame of a dark, over what goes unnoticed.

    In files without a pedestal, which clip half of the noise and round off the rest, bright pixels are all
    that there is to see. Heights follow from the simulator's noise, so that its own pixels seldom count. What
    a few pixels are, another specimen of the same sensor does not repeat: the equivalence margin is that of a
    Poisson count. Values are logarithms of 1 + the ratio.
    """
    if sample.capture.kind != "dark":
        return
    above = _above(sample)
    noise_dn = float(np.sqrt(max(sample.capture.noise.thermal_dn2)))
    heights = (ROUNDING_DN + _SPREADS * noise_dn) * np.array(STEPS)
    bright = isolated(above > heights[0])
    alone = above[bright if sample.valid.all() else bright & sample.valid[..., None]]
    counts = np.array([np.count_nonzero(alone > height) for height in heights], float)
    few = 1 + _FEW * above.size / np.array(STEPS)
    yield StatisticBlock(
        "hot_pixels",
        "pixel",
        np.log1p(counts / few),
        [{"above_dn": round(float(height), 1)} for height in heights],
        np.hypot(_MODEL, 1 / np.sqrt(counts + few)),
    )


def _above(sample: Sample) -> NDArray[np.float32]:
    """(H, W, C) the least of the frames above what is expected, and above the middle of all pixels [DN]."""
    above = np.minimum.reduce(sample.as_taken) - sample.reference
    return np.asarray(above - np.median(sampled(above if sample.valid.all() else above[sample.valid])))
