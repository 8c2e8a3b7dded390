"""Scales on which a score is modelled: there its noise is even, and its range has no ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tacos_framework.contracts import ScoreScale

Array = NDArray[np.float64]

SHARE_MARGIN = 0.02
"""How far shares of 0 and 1 are drawn inside before their logit is taken, which is then +-3.9.

Shares of a scene are counts of few (three thresholds, twenty objects): 0 stands for fewer than one in some
tens.
"""


class Transform(Protocol):
    """From a score to the scale of its model and back."""

    @property
    def smallest_spread(self) -> float:
        """Standard deviation that observed values are taken to have at least, on the scale of the model."""
        ...

    def forward(self, scores: Array) -> Array:
        """The scores on the scale of the model."""
        ...

    def expected(self, mean: Array, variance: float) -> Array:
        """The mean score where the model's value is Gaussian, of this mean and variance."""
        ...


@dataclass(frozen=True)
class Identity:
    """Any number, as it is."""

    smallest_spread: float = 1e-9

    def forward(self, scores: Array) -> Array:
        """The scores."""
        return scores

    def expected(self, mean: Array, variance: float) -> Array:
        """The mean."""
        return mean


@dataclass(frozen=True)
class SquareRoot:
    """The root of a count, whose noise is then even: a Poisson count's has a standard deviation of 1/2.

    References
    ----------
    Bartlett 1936, "The square root transformation in analysis of variance".
    """

    smallest_spread: float = 0.1

    def forward(self, scores: Array) -> Array:
        """Roots; below zero, where no count is, zero."""
        return np.sqrt(np.maximum(scores, 0.0))

    def expected(self, mean: Array, variance: float) -> Array:
        """E[z^2] = mean^2 + variance; roots below zero count as zero."""
        return np.maximum(mean, 0.0) ** 2 + variance


@dataclass(frozen=True)
class Logit:
    """The logit of a share between 0 and 1, drawn `SHARE_MARGIN` inside.

    References
    ----------
    MacKay 1992, "The evidence framework applied to classification networks", eq. (10): the mean of a logistic
    function of a Gaussian value.
    """

    smallest_spread: float = 0.1

    def forward(self, scores: Array) -> Array:
        """Logits of the shares."""
        from scipy.special import logit  # late: checking a recipe predicts nothing

        inside = SHARE_MARGIN + (1 - 2 * SHARE_MARGIN) * np.clip(scores, 0.0, 1.0)
        return np.asarray(logit(inside), dtype=np.float64)

    def expected(self, mean: Array, variance: float) -> Array:
        """The mean share, between 0 and 1."""
        from scipy.special import expit  # late: as above

        inside = expit(mean / np.sqrt(1 + np.pi * variance / 8))
        return np.clip((inside - SHARE_MARGIN) / (1 - 2 * SHARE_MARGIN), 0.0, 1.0)


TRANSFORMS: dict[ScoreScale, Transform] = {"real": Identity(), "count": SquareRoot(), "share": Logit()}
"""The transform of each kind of score."""
