"""The surrogate as the search keeps it: fitted anew as observations come in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import DesignProblem
from tacos_plugins.optimizers.physical_gp.history import (
    TIME,
    Trial,
    fitness_alone,
    observations,
    scores_known,
)
from tacos_plugins.optimizers.physical_gp.viability import Viability
from tacos_plugins.surrogate.coordinates import CoordinateSystem
from tacos_plugins.surrogate.grey_box import GreyBox
from tacos_plugins.surrogate.kernel import Hyperparameters

Array = NDArray[np.float64]

REFIT = 1.15
"""Hyperparameters are fitted anew once there are so many times the observations of the last fit.

They change little with one observation more, and a fit takes ten times as long as a prediction.
"""


@dataclass(frozen=True)
class Fitted:
    """Hyperparameters of each score, and the number of trials they were fitted to."""

    trials: int
    hyperparameters: Mapping[str, Hyperparameters]

    def as_json(self) -> dict[str, Any]:
        found = {name: asdict(h) for name, h in self.hyperparameters.items()}
        return {"trials": self.trials, "hyperparameters": found}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Fitted:
        """Undoes :meth:`as_json`."""
        found = {
            name: Hyperparameters(**{**h, "length_scales": tuple(h["length_scales"])})
            for name, h in data["hyperparameters"].items()
        }
        return cls(data["trials"], found)


@dataclass(frozen=True, eq=False)
class SearchModel:
    """The model after some trials."""

    grey_box: GreyBox
    viability: Viability
    fitted: Fitted

    @classmethod
    def of(
        cls,
        trials: Sequence[Trial],
        coordinates: Sequence[Mapping[str, float]],
        problem: DesignProblem | None,
        system: CoordinateSystem,
        before: Fitted | None,
    ) -> SearchModel:
        """The model of these trials.

        `system`: coordinates and ranges of all candidates.
        """
        by_score = problem is not None and scores_known(trials)
        seen = [
            observation
            for trial, where in zip(trials, coordinates, strict=True)
            for observation in observations(trial, where, problem, by_score)
        ]
        drift = TIME if problem is not None and problem.weights_learn else None
        last_round = max((trial.round for trial in trials), default=0)
        kept = before is not None and len(trials) < REFIT * before.trials
        grey_box = GreyBox.fit(
            seen,
            problem.fitness if problem is not None and by_score else fitness_alone(),
            problem.scales if problem is not None else {},
            problem.depends_on if problem is not None else {},
            drift=drift,
            system=system.with_range(TIME, 0.0, max(last_round, 1.0)) if drift else system,
            start=before.hyperparameters if before is not None else None,
            fixed=kept,
        )
        fitted = Fitted(before.trials if kept and before else len(trials), grey_box.hyperparameters)
        succeeded = np.array([not trial.failed for trial in trials], dtype=bool)
        return cls(grey_box, Viability.fit(system.rows(coordinates), succeeded), fitted)
