"""Rules for naming one more effect."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tacos_gap.attribution.fits import CLOSE
from tacos_gap.inference.fit import Fitted
from tacos_gap.inference.presence import BY_STATISTICS, share_explained
from tacos_gap.inference.problem import Problem, robust
from tacos_gap.inference.rivals import discrepancy, gain_beyond
from tacos_gap.inference.unknown import block_index, doubt_beside

COMPLEXITY_PENALTY = 6.0
"""Complexity penalty: what an effect must gain in log score on held-out conditions [nat]."""

LEAST_OF_REST = 0.08
"""What it must gain over what is left above the noise floor in the captures it touches: all effects fit a bit
where formulas miss."""

MISFIT = 0.05
"""Coherent share of what an explanation changed in a block by which its formulas may be wrong there: a
further effect must gain more than that."""

RIVAL_SHARE = 0.03
"""Share of what an effect gained that another must promise to be fitted in its place: in place of another
focal length, an error of pose promised a tenth of what it then gained, and most effects a fiftieth."""

LEAST_CHANGE = 0.25
"""Mean square by which an effect must change some statistic of a capture; less is negligible."""


def shows(problem: Problem, base: Fitted, fitted: Fitted) -> bool:
    """True if what a fit changes exceeds the equivalence margin in any statistic of any capture.

    Thousands of pixels find a little of everything in every camera.
    """
    blocks = block_index(problem)
    change = np.bincount(blocks, (robust(fitted.z) - robust(base.z)) ** 2) / np.bincount(blocks)
    return bool(change.max() >= LEAST_CHANGE)


def fits_a_bit(problem: Problem, base: Fitted, fitted: Fitted) -> bool:
    """True if further effects prove nothing, and leave much of what they were added for.

    What formulas miss of a large effect is far above the noise floor, and more of them fit a bit of it each.
    """
    proven = BY_STATISTICS.by(share_explained(problem, fitted.z, base.z))
    return not proven and doubt_beside(problem, fitted.z, base.z) == 1.0


def is_worth_it(problem: Problem, base: Fitted, fitted: Fitted) -> bool:
    """True if a further effect gains more than its penalty, beyond what formulas may miss."""
    allowed = discrepancy(problem, base, MISFIT)
    slots = [slice(slot.start, slot.stop) for slot in problem.slots]
    touched = [slot for slot in slots if not np.array_equal(base.z[slot], fitted.z[slot])]
    return gain_beyond(problem, base, fitted, allowed) > least_gain(problem, base, touched)


def least_gain(problem: Problem, base: Fitted, touched: Sequence[slice] = (slice(None),)) -> float:
    """Least gain of a further effect in log score [nat].

    What brackets leave unexplained says nothing of what flats prove.

    `base`: the explanation that it is added to. `touched`: where the captures that it changes stand in the
    residuals; all by default.
    """
    held_out = base.held_out / problem.own_units(base.names)
    left = np.concatenate([robust(held_out[slot]) ** 2 for slot in (*touched, slice(0))])
    rest = 0.5 * problem.weight * float(np.sum(left) - len(left))  # squares of the noise floor are 1 each
    return max(COMPLEXITY_PENALTY, LEAST_OF_REST * rest)


def gains_in_width(problem: Problem, without_it: NDArray[np.float64], with_it: NDArray[np.float64]) -> bool:
    """True if an effect of luck gains enough where all is counted in units of its own noise floor.

    `without_it`, `with_it`: (K,) residuals held out [noise floor of the effect].
    """
    before, after = (float(np.sum(robust(left) ** 2)) for left in (without_it, with_it))
    least = max(COMPLEXITY_PENALTY, LEAST_OF_REST * 0.5 * problem.weight * (before - len(with_it)))
    return 0.5 * problem.weight * (before - after) > least


def wins_by_width(problem: Problem, better: Fitted, worse: Fitted) -> bool:
    """True if one of two explanations is the better one by the width of an effect of luck alone.

    They are in units of the wider of their noise floors.
    """
    luck = problem.spread.keys() & set(better.names) - set(worse.names)
    return bool(luck) and not gains_in_width(problem, worse.held_out, better.held_out)


def least_of_a_rival(gained: float) -> float:
    return max(0.0, min(RIVAL_SHARE * gained, gained - CLOSE))
