"""Predictions measured so far, and the model error that they show for each kind of score."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.stats import t

from tacos_decision.predictions.outcome import SUFFIX, Miss, read_outcome
from tacos_framework import shipped_folder

COVERAGE = 0.9
"""Share of measured values that the intervals of predictions are to hold."""


@dataclass(frozen=True)
class ModelError:
    """How far predictions of a kind of score have missed, beyond their own standard error."""

    relative: float
    """Standard deviation of the model error, as a share of the value [1]."""
    measured: int
    """Number of measured values behind it."""

    def half_width(self, value: float, error: float) -> float:
        """Half of the 90 % interval of a new prediction, by Student's t with one degree for each value."""
        spread = math.hypot(error, self.relative * abs(value))
        return float(t.ppf((1 + COVERAGE) / 2, max(self.measured, 1)) * spread)


NEVER_MEASURED = ModelError(0.0, 10**6)
"""Of a kind that no prediction was measured of: the simulation's own error alone, as a normal interval."""


def shipped_register() -> Path:
    """Folder of the project's own predictions."""
    return shipped_folder("catalogs") / "predictions"


def misses_in(folders: Iterable[Path]) -> list[Miss]:
    """All values of folders that were predicted and measured."""
    files = (path for folder in folders for path in sorted(folder.glob(f"*{SUFFIX}")))
    return [miss for path in files for miss in read_outcome(path)]


def model_errors(misses: Sequence[Miss]) -> dict[str, ModelError]:
    """The model error of each kind of score.

    The mean square of what was missed less that of the predictions' own standard errors, each relative to
    the larger of the two values, so that a value of zero on either side counts as missed by all of it.
    """
    kinds: dict[str, list[Miss]] = {}
    for miss in misses:
        kinds.setdefault(miss.kind, []).append(miss)
    return {kind: _error_of(own) for kind, own in kinds.items()}


def _error_of(misses: Sequence[Miss]) -> ModelError:
    missed = np.array([miss.relative for miss in misses])
    own = np.array([miss.own_error for miss in misses])
    return ModelError(math.sqrt(max(float(np.mean(missed**2 - own**2)), 0.0)), len(misses))


def sentence(kinds: Iterable[str], errors: Mapping[str, ModelError]) -> str:
    """What predictions of these kinds of scores were worth so far, in a sentence."""
    known = [
        f"{kind} by {errors[kind].relative:.0%} ({errors[kind].measured} values)"
        for kind in kinds
        if kind in errors
    ]
    if not known:
        return "No prediction of these scores has been held against a real camera yet."
    return f"Beyond their own intervals, predictions have missed real cameras so far in {', '.join(known)}."
