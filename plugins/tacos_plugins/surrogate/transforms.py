"""Scales on which a score is modelled: there its noise is even, and its range has no ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tacos_framework import ScoreScale

Array = NDArray[np.float64]

SHARE_MARGIN = 0.02
"""Distance by which shares of 0 and 1 are drawn inside before their logit is taken, which is then +-3.9.

Shares of a scene are counts of few (three thresholds, twenty objects): 0 stands for fewer than one in some
tens.
"""


MOST_COUNTED = 12
"""Shares of more than so many are taken to be without noise of counting: it shows by itself."""


class Transform(Protocol):
    """From a score to the scale of its model and back."""

    @property
    def smallest_spread(self) -> float:
        """Standard deviation that observed values are taken to have at least, on the scale of the model."""
        ...

    def forward(self, scores: Array) -> Array:
        """The scores on the scale of the model."""
        ...

    def counting_noise(self, scores: Array) -> float:
        """Standard deviation that scores have there because few are counted, whether it shows or not."""
        ...

    def expected(self, mean: Array, variance: float) -> Array:
        """The mean score where the model's value is Gaussian, of this mean and variance."""
        ...


@dataclass(frozen=True)
class Identity:
    """Any number, as it is."""

    smallest_spread: float = 1e-9

    def forward(self, scores: Array) -> Array:
        return scores

    def counting_noise(self, scores: Array) -> float:
        """None that is known."""
        return 0.0

    def expected(self, mean: Array, variance: float) -> Array:
        return mean


@dataclass(frozen=True)
class SquareRoot:
    """The root of a count, whose noise is then even: a Poisson count's has a standard deviation of 1/2.

    Source: Bartlett 1936, "The square root transformation in analysis of variance".
    """

    smallest_spread: float = 0.1

    def forward(self, scores: Array) -> Array:
        """Roots; below zero, where no count is, zero."""
        return np.sqrt(np.maximum(scores, 0.0))

    def counting_noise(self, scores: Array) -> float:
        """None that is known: counts are means over frames."""
        return 0.0

    def expected(self, mean: Array, variance: float) -> Array:
        """E[z^2] = mean^2 + variance; roots below zero count as zero."""
        return np.maximum(mean, 0.0) ** 2 + variance


@dataclass(frozen=True)
class Logit:
    """The logit of a share between 0 and 1, drawn `SHARE_MARGIN` inside.

    Source: MacKay 1992, "The evidence framework applied to classification networks", eq. (10): the mean of a
    logistic function of a Gaussian value.
    """

    smallest_spread: float = 0.1

    def forward(self, scores: Array) -> Array:
        from scipy.special import logit  # late: checking a recipe predicts nothing

        inside = SHARE_MARGIN + (1 - 2 * SHARE_MARGIN) * np.clip(scores, 0.0, 1.0)
        return np.asarray(logit(inside), dtype=np.float64)

    def counting_noise(self, scores: Array) -> float:
        """Of shares of few, that of the logit of a binomial share of one half, where it is least.

        One scene whose two thresholds were both seen tells little of the camera that sees nine of ten, and
        many such scenes are all alike: without it they would pass for the proof that all are always seen.
        """
        count = counted(scores)
        return 0.0 if count is None else float(2 / np.sqrt(count))

    def expected(self, mean: Array, variance: float) -> Array:
        from scipy.special import expit  # late: as above

        inside = expit(mean / np.sqrt(1 + np.pi * variance / 8))
        return np.clip((inside - SHARE_MARGIN) / (1 - 2 * SHARE_MARGIN), 0.0, 1.0)


def counted(shares: Array) -> int | None:
    """Of how many, at least, these are shares; None where of many, or of no whole number.

    >>> counted(np.array([0.0, 1.0, 0.5, 1.0])), counted(np.array([1 / 3, 0.5])), counted(np.array([0.273]))
    (2, 6, None)
    """
    for count in range(1, MOST_COUNTED + 1):
        if np.allclose(shares * count, np.round(shares * count), atol=1e-6):
            return count
    return None


TRANSFORMS: dict[ScoreScale, Transform] = {"real": Identity(), "count": SquareRoot(), "share": Logit()}
"""The transform of each kind of score."""
