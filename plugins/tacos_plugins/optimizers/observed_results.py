"""Results handed to an optimizer, validated before it learns from them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tacos_framework import Candidate, Evaluated


def validate_results(evaluated: Sequence[Evaluated], asked: Sequence[Candidate]) -> None:
    """Refuse results that are not those of the candidates asked, or that have no rank.

    Raises `ValueError` when a fitness is NaN or infinite, or the candidates are not those asked, in their
    order.
    """
    for result in evaluated:
        if result.fitness is not None and not math.isfinite(result.fitness):
            raise ValueError(f"the fitness of candidate {result.candidate.key} is not a finite number")
    if [result.candidate for result in evaluated] != list(asked):
        raise ValueError("tell takes the results of the candidates last asked, in their order")
