"""A prediction beside what was measured."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.stats import kendalltau

from tacos_decision.predictions.prediction import PredictedValue, Prediction
from tacos_framework import Fault, UserError, did_you_mean
from tacos_framework.files import read_json
from tacos_framework.store import replace_file

SUFFIX = ".outcome.json"

Measured = Mapping[tuple[str, str], float]
"""(camera, score) -> what was measured."""


@dataclass(frozen=True)
class Miss:
    """A predicted value beside the measured one."""

    predicted: PredictedValue
    measured: float

    @property
    def kind(self) -> str:
        return self.predicted.kind

    @property
    def inside(self) -> bool:
        """True if the interval holds the measured value."""
        return self.predicted.low <= self.measured <= self.predicted.high

    @property
    def relative(self) -> float:
        """Measured less predicted, as a share of the larger [1]."""
        return (self.measured - self.predicted.value) / self._scale

    @property
    def own_error(self) -> float:
        """Standard error of the prediction, on the same scale [1]."""
        return self.predicted.error / self._scale

    @property
    def _scale(self) -> float:
        return max(abs(self.measured), abs(self.predicted.value)) or 1.0


@dataclass(frozen=True)
class Outcome:
    """All values of a prediction that were measured."""

    misses: tuple[Miss, ...]

    @property
    def coverage(self) -> float:
        """Share of measured values inside their interval [1]."""
        return float(np.mean([miss.inside for miss in self.misses]))

    @property
    def tau(self) -> dict[str, float | None]:
        """For each score, Kendall's tau-b of the predicted order of the cameras with the measured one."""
        found: dict[str, float | None] = {}
        for score in dict.fromkeys(miss.predicted.score for miss in self.misses):
            own = [miss for miss in self.misses if miss.predicted.score == score]
            found[score] = None
            if len(own) > 1:
                tau = kendalltau([m.predicted.value for m in own], [m.measured for m in own]).statistic
                found[score] = None if np.isnan(tau) else float(tau)
        return found


def hold_against(prediction: Prediction, measured: Measured, where: str) -> Outcome:
    """A prediction beside measured values.

    Raises `UserError` when nothing that was predicted is among them.
    """
    found = [
        Miss(v, measured[v.camera, v.score]) for v in prediction.values if (v.camera, v.score) in measured
    ]
    if not found:
        expected = ", ".join(sorted({f"{value.camera} {value.score}" for value in prediction.values})[:4])
        raise UserError(Fault(where, "holds nothing that was predicted", f"values of {expected}, ..."))
    return Outcome(tuple(found))


def not_predicted(prediction: Prediction, measured: Measured) -> list[str]:
    """A sentence for each measured value that was not predicted, with the names that may be meant."""
    known = {f"{value.camera} {value.score}" for value in prediction.values}
    names = (f"{camera} {score}" for camera, score in measured)
    return [
        f"{name} was not predicted, and is left out. {did_you_mean(name, known)}"
        for name in names
        if name not in known
    ]


def write_outcome(path: Path, outcome: Outcome, prediction: Prediction, when: str) -> None:
    """Write what was measured beside a prediction."""
    data = {
        "prediction_sha256": prediction.digest,
        "measured_at": when,
        "tau": outcome.tau,
        "coverage": outcome.coverage,
        "values": [
            {**vars(miss.predicted), "measured": miss.measured, "inside": miss.inside}
            for miss in outcome.misses
        ],
    }
    replace_file(path, (json.dumps(data, indent=1, ensure_ascii=False) + "\n").encode())


def read_outcome(path: Path) -> list[Miss]:
    """The values of an outcome.

    Raises `UserError` when the file cannot be read.
    """
    try:
        return [
            Miss(
                PredictedValue(*(value[name] for name in PredictedValue.__annotations__)),
                float(value["measured"]),
            )
            for value in read_json(path)["values"]
        ]
    except (KeyError, TypeError, ValueError) as error:
        raise UserError(Fault(str(path), "it is no outcome", "a file that tacos predict wrote")) from error
