"""What optimizers are told, checked before they learn from it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tacos_framework.contracts import Evaluated
from tacos_framework.variables.design_space import Candidate


def check_told(evaluated: Sequence[Evaluated], asked: Sequence[Candidate]) -> None:
    """Refuse results that are not those of the candidates asked, or that have no rank.

    Raises
    ------
    ValueError
        When a fitness is NaN or infinite, or the candidates are not those asked, in their order.
    """
    for result in evaluated:
        if result.fitness is not None and not math.isfinite(result.fitness):
            raise ValueError(f"the fitness of candidate {result.candidate.key} is not a finite number")
    if [result.candidate for result in evaluated] != list(asked):
        raise ValueError("tell takes the results of the candidates last asked, in their order")
