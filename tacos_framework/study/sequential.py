"""The sequential test: paired scenes are added until a comparison is decided, and looking costs no certainty.

Two cameras see the same scenes; their difference on each is one number. Looking at Student's 95 % interval
again and again errs far more often than in one study of twenty. So there are a few looks, fixed beforehand,
and each may spend its part of the error [1]_ [2]_: little at first, most at the last. At a look the interval
is Student's at the look's own part; that all of them hold follows from adding up the parts.

One threshold that one of two cameras overlooks is a tail on one side. Where the sample is skewed, the end
of the interval that this makes too short is moved out by Hall's transformation [3]_, and never in. Error
rates by simulation stand in ``docs/explanation/decision.md``.

References
----------
.. [1] K. K. G. Lan, D. L. DeMets, "Discrete sequential boundaries for clinical trials", Biometrika 70, 1983.
.. [2] K. Kim, D. L. DeMets, "Design and analysis of group sequential tests based on the type I error spending
   rate function", Biometrika 74, 1987.
.. [3] P. Hall, "On the removal of skewness by transformation", J. R. Stat. Soc. B 54, 1992.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

Verdict = Literal["better", "worse", "equivalent", "undecided"]

GROWTH = 1.5
"""Growth of the scenes from look to look: workers have enough to do, and none comes late."""

SPENDING_POWER = 3
"""Until a look, this power of the share of scenes seen is the share of the error that is spent [2]_."""

ALIKE = 1e-12
"""Differences that spread by no more than this share of themselves differ by rounding alone."""


@dataclass(frozen=True)
class PairedInterval:
    """The mean difference of two cameras, and what it decides."""

    difference: float
    """Mean paired difference [fitness]."""
    interval: tuple[float, float] | None
    """Lower and upper end; None where there are too few scenes to tell."""
    episodes: int
    verdict: Verdict
    """``better`` or ``worse`` where the interval leaves out zero, ``equivalent`` where all of it lies within
    the margin, which comes first: what does not matter is no advantage.
    """
    margin: float = 0.0
    """Differences up to this do not matter [fitness]."""
    of_scenes: tuple[float, ...] = ()
    """The difference on each scene, where it is a sum over scenes."""

    def quantiles(self, shares: NDArray[np.float64]) -> NDArray[np.float64] | None:
        """(n,) values that the true difference is below with (n,) probabilities, by the same statistic.

        One look by itself: no error is shared with other looks and products. None below three scenes.
        """
        return mean_quantiles(np.asarray(self.of_scenes), shares)


def looks(first: int, most: int) -> tuple[int, ...]:
    """The numbers of scenes after which is looked, from `first` to `most`, whatever the number of workers.

    >>> looks(4, 24)
    (4, 6, 9, 14, 21, 24)
    >>> looks(3, 3)
    (3,)
    """
    counts = [first]
    while counts[-1] < most:
        counts.append(min(most, math.ceil(GROWTH * counts[-1])))
    return tuple(counts)


def error_at(count: int, counts: Sequence[int], error: float) -> float:
    """The part of the error that the look after `count` scenes may spend, of all `counts` with looks.

    Between two looks the earlier one is meant; the parts of all add up to `error`.

    >>> [round(error_at(count, (12, 24), 0.05), 4) for count in (12, 24)]
    [0.0063, 0.0438]
    """
    passed = [each for each in counts if each <= count] or [counts[0]]
    before = passed[-2] if len(passed) > 1 else 0
    return error * float(
        (passed[-1] / counts[-1]) ** SPENDING_POWER - (before / counts[-1]) ** SPENDING_POWER
    )


def compared(
    differences: Sequence[float] | NDArray[np.float64], *, error: float, margin: float
) -> PairedInterval:
    """Decision of paired differences so far.

    - `differences`: of each scene seen, one camera's fitness minus the other's.
    - `error`: share of studies in which this interval may miss the truth: what the look may spend, of which
      each of several products has its part.
    - `margin`: differences up to this do not matter [fitness].

    >>> compared([0.5, 0.6, 0.4, 0.5, 0.6, 0.5], error=0.05, margin=0.01).verdict
    'better'
    >>> compared([0.5, 0.6], error=0.05, margin=0.01).verdict
    'undecided'
    """
    seen = np.asarray(differences, dtype=np.float64)
    mean = float(seen.mean()) if len(seen) else 0.0
    interval = confidence_interval(seen, error)
    verdict: Verdict = "undecided"
    if interval is not None:
        low, high = interval
        if -margin <= low and high <= margin:
            verdict = "equivalent"
        elif low > 0 or high < 0:
            verdict = "better" if low > 0 else "worse"
    return PairedInterval(mean, interval, len(seen), verdict, margin, tuple(seen.tolist()))


def confidence_interval(values: NDArray[np.float64], error: float) -> tuple[float, float] | None:
    """Student's interval of the mean of (n,) draws, widened for skew; None below three.

    `error` is the share of samples whose interval leaves the truth out.
    """
    ends = mean_quantiles(values, np.array([error / 2, 1 - error / 2]))
    if ends is None or (ends[0] == ends[1] and 2.0 ** (1 - len(values)) > error):
        return None  # no spread to go by: a fair coin is as often one-sided
    return float(ends[0]), float(ends[1])


def mean_quantiles(values: NDArray[np.float64], shares: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Quantiles of the mean of (n,) draws at (m,) shares: Student's, moved out for skew; None below three."""
    n = len(values)
    if n < 3:
        return None
    mean, spread = float(values.mean()), float(values.std(ddof=1))
    if spread <= ALIKE * float(np.abs(values).max()):
        return np.full(len(shares), mean)
    skewness = n * float(np.sum(((values - mean) / spread) ** 3)) / ((n - 1) * (n - 2))
    t = stdtrit(n - 1, shares)
    unskewed = -_student_of_skewed(-t, skewness, n)
    away = np.where(t < 0, np.minimum(t, unskewed), np.maximum(t, unskewed))
    return np.asarray(mean + away * spread / math.sqrt(n))


def _student_of_skewed(t: NDArray[np.float64], skewness: float, n: int) -> NDArray[np.float64]:
    """Values of Student's statistic of a skewed sample that Hall's transformation takes to `t` (eq. 2)."""
    if abs(skewness) < 1e-6:
        return t
    third = skewness / math.sqrt(n)
    return np.asarray((np.cbrt(1 + third * (t - third / 6)) - 1) * 3 / third)
