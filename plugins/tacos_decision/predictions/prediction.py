"""A prediction: values with 90 % intervals, dated and hashed, as a file."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from tacos_framework import Fault, UserError
from tacos_framework.files import read_json
from tacos_framework.store import replace_file

SUFFIX = ".prediction.json"


@dataclass(frozen=True)
class PredictedValue:
    """A score of a camera with its 90 % interval."""

    camera: str
    score: str
    """``node.score``; its last part is the kind of score."""
    value: float
    error: float
    """Standard error by what the simulation itself leaves open, such as the choice of scenes."""
    low: float
    high: float
    """Ends of the interval, the model error of the register in it."""

    @property
    def kind(self) -> str:
        """The kind of score, which shares its model error: ``inliers`` of ``features.inliers``."""
        return self.score.rpartition(".")[2]


@dataclass(frozen=True)
class Prediction:
    about: str
    """What is to be measured, in a sentence."""
    made: str
    """Time of the prediction, ISO 8601 with its offset."""
    values: tuple[PredictedValue, ...]
    origin: Mapping[str, Any] = field(default_factory=dict)
    """Recipe, seed and version it follows from."""
    model_error: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """For each kind of score its model error and the number of measured values behind it; empty for kinds
    that were never measured."""

    @property
    def digest(self) -> str:
        """SHA-256 of the content: a prediction that was changed later has another."""
        return hashlib.sha256(json.dumps(asdict(self), sort_keys=True).encode()).hexdigest()

    def write(self, path: Path) -> None:
        """Write the file; an earlier prediction is never overwritten.

        Raises `UserError` when the file is there already.
        """
        if path.exists():
            raise UserError(
                Fault(str(path), "there is a prediction already", "a new name", "Choose another --out.")
            )
        path.parent.mkdir(parents=True, exist_ok=True)
        text = json.dumps({**asdict(self), "sha256": self.digest}, indent=1, ensure_ascii=False)
        replace_file(path, f"{text}\n".encode())


def read_prediction(path: Path) -> Prediction:
    """A prediction from its file.

    Raises `UserError` when it cannot be read, or was changed since it was made.
    """
    data = read_json(path)
    try:
        values = tuple(PredictedValue(**value) for value in data["values"])
        found = Prediction(data["about"], data["made"], values, data["origin"], data["model_error"])
    except (KeyError, TypeError) as error:
        expected = "a file that tacos predict wrote"
        raise UserError(Fault(str(path), "it is no prediction", expected)) from error
    if data.get("sha256") != found.digest:
        raise UserError(
            Fault(
                str(path),
                "its content was changed after it was hashed",
                f"content of SHA-256 {data.get('sha256')}",
                "Take it from the history of your files as it was.",
            )
        )
    return found
