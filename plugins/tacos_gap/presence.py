"""Whether an effect is there, whatever else is: judged by the captures that show it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_gap.problem import Problem, robust
from tacos_gap.unknown import Unexplained

LEAST_EVIDENCE = 0.25
"""Share of all evidence for an effect that captures of one kind must hold to prove it by themselves."""

LEAST_CAPTURES = 2
"""So many of them: one is fitted, another one foretold."""


def support(problem: Problem, with_it: NDArray[np.float64], without: NDArray[np.float64]) -> dict[str, float]:
    """What each capture gains by an effect, as a fall of its sum of robust squares; captures that lose, 0.

    Parameters
    ----------
    problem
        The evidence.
    with_it, without
        (K,) residuals of the explanation with the effect and without it [noise floor].
    """
    gain = robust(without) ** 2 - robust(with_it) ** 2
    found: dict[str, float] = {}
    for slot in problem.slots:
        if slot.stop > slot.start:
            name = problem.labels[slot.start].capture
            found[name] = found.get(name, 0.0) + float(gain[slot.start : slot.stop].sum())
    return {name: max(value, 0.0) for name, value in found.items()}


def completeness_where_it_shows(problem: Problem, gains: dict[str, float], left: Unexplained) -> float:
    """Probability that nothing unknown shows where an effect does.

    Captures count by what they gain. Those of one kind are enough where they hold a good part of it: what
    flats prove, scenes that nothing explains do not disprove.
    """
    total = sum(gains.values())
    if total <= 0:
        return 1.0 - left.probability
    kinds = {label.capture: label.kind for label in problem.labels}
    complete = {name: 1.0 - left.by_capture.get(name, left.probability) for name in gains}
    everywhere = sum(gain * complete[name] for name, gain in gains.items()) / total
    alone = []
    for kind in dict.fromkeys(kinds.values()):
        own = {name: gain for name, gain in gains.items() if kinds[name] == kind and gain > 0}
        evidence = sum(own.values())
        if len(own) >= LEAST_CAPTURES and evidence >= LEAST_EVIDENCE * total:
            alone.append(sum(gain * complete[name] for name, gain in own.items()) / evidence)
    return max([everywhere, *alone])
