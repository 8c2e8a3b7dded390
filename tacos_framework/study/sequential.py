"""The sequential test: paired scenes are added until a comparison is decided, and peeking costs no certainty.

Two cameras see the same scenes; their difference on each is one number. Looking at Student's 95 % interval
after every scene errs in one study of five, not of twenty. So the interval is that of a *confidence
sequence*: in 95 % of studies it holds the true mean after every scene, whenever one looks and for whatever
reason one stops. It is Student's with a normal mixture over the effect size [1]_ [2]_: valid for normal
differences however few, and without a setting that must know their spread.

Differences of scenes are seldom normal: one threshold that one of two cameras overlooks is a tail on one
side. Where the sample is skewed, the end of the interval that this makes too short is moved out by Hall's
transformation [3]_; it is never moved in. What happens once in many scenes and has not happened yet, no test
can know. Error rates by simulation stand in ``docs/explanation/decision.md``.

References
----------
.. [1] T. L. Lai, "On confidence sequences", Ann. Statist. 4, 1976.
.. [2] H. Wang, A. Ramdas, "Anytime-valid t-tests and confidence sequences for Gaussian means with unknown
   variance", Sequential Analysis 44, 2025.
.. [3] P. Hall, "On the removal of skewness by transformation", J. R. Stat. Soc. B 54, 1992.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Verdict = Literal["better", "worse", "equivalent", "undecided"]

GROWTH = 1.5
"""How many times the scenes of a look the next one has: workers have enough to do, and none comes late."""

MIXTURE_SCENES = 1.0
"""The mixture's effect sizes spread by one standard deviation: the weight of a single scene (unit
information, R. E. Kass, L. Wasserman, J. Am. Stat. Assoc. 90, 1995)."""

ALIKE = 1e-12
"""Differences that spread by no more than this share of themselves differ by rounding alone."""


@dataclass(frozen=True)
class PairedInterval:
    """The mean difference of two cameras, and what it decides.

    Parameters
    ----------
    difference
        Mean paired difference [fitness].
    interval
        Lower and upper end; None where there are too few scenes to tell.
    episodes
        How many scenes it is of.
    verdict
        ``better`` or ``worse`` where the interval leaves out zero, ``equivalent`` where all of it lies
        within the margin, which comes first: what does not matter is no advantage.
    margin
        Differences up to this do not matter [fitness].
    """

    difference: float
    interval: tuple[float, float] | None
    episodes: int
    verdict: Verdict
    margin: float = 0.0


def looks(first: int, most: int) -> tuple[int, ...]:
    """The numbers of scenes after which is looked, from `first` to `most`, whatever the number of workers.

    Examples
    --------
    >>> looks(4, 24)
    (4, 6, 9, 14, 21, 24)
    >>> looks(3, 3)
    (3,)
    """
    counts = [first]
    while counts[-1] < most:
        counts.append(min(most, math.ceil(GROWTH * counts[-1])))
    return tuple(counts)


def compared(
    differences: Sequence[float] | NDArray[np.float64], *, error: float, margin: float
) -> PairedInterval:
    """What paired differences decide so far.

    Parameters
    ----------
    differences
        Of each scene seen, one camera's fitness minus the other's.
    error
        Share of studies in which the interval may ever miss the truth; of several products each has its
        part of it.
    margin
        Differences up to this do not matter [fitness].

    Examples
    --------
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
    return PairedInterval(mean, interval, len(seen), verdict, margin)


def confidence_interval(values: NDArray[np.float64], error: float) -> tuple[float, float] | None:
    """The confidence sequence of the mean after these values; None while it is unbounded.

    Parameters
    ----------
    values
        (n,) independent draws, in the order they came.
    error
        Share of sequences that ever leave the truth out.
    """
    n = len(values)
    prior = MIXTURE_SCENES
    ratio = (math.sqrt((n + prior) / prior) / error) ** (2 / n) if n else math.inf
    room = 1 - ratio * prior / (n + prior)
    if n < 3 or room <= 0:
        return None
    mean, spread = float(values.mean()), float(values.std(ddof=1))
    if spread <= ALIKE * float(np.abs(values).max()):  # no spread to go by: a fair coin is as often one-sided
        return (mean, mean) if 2.0 ** (1 - n) <= error else None
    # all means whose mixture likelihood ratio is below 1 / error, as Student's t (Wang and Ramdas, thm. 4.9)
    t = math.sqrt((n - 1) * (ratio - 1) / room)
    skewness = n * float(np.sum(((values - mean) / spread) ** 3)) / ((n - 1) * (n - 2))
    down, up = (max(t, abs(_student_of_skewed(side * t, skewness, n))) for side in (1, -1))
    unit = spread / math.sqrt(n)
    return mean - down * unit, mean + up * unit


def _student_of_skewed(t: float, skewness: float, n: int) -> float:
    """The value of Student's statistic of a skewed sample that Hall's transformation takes to `t` (eq. 2)."""
    if abs(skewness) < 1e-6:
        return t
    third = skewness / math.sqrt(n)
    return (float(np.cbrt(1 + third * (t - third / 6))) - 1) * 3 / third
