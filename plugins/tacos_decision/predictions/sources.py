"""Predictions and measurements from results folders, and measurements from tables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

from tacos_decision.predictions.outcome import Measured
from tacos_decision.predictions.prediction import PredictedValue, Prediction
from tacos_decision.predictions.register import NEVER_MEASURED, ModelError
from tacos_framework import Fault, UserError
from tacos_framework.files import finite_number, read_rows

_NORMAL_90 = 1.645
"""Half of a 90 % interval in standard errors."""

_COLUMNS = ("camera", "score", "value")

Estimate = tuple[str, str, float, float]
"""Camera, score, value, standard error."""


def prediction_from(
    result: Mapping[str, Any], folder: Path, errors: Mapping[str, ModelError], about: str, when: datetime
) -> Prediction:
    """The prediction of a study's test, or of a recording replayed from one exposure.

    Raises `UserError` when the results predict nothing.
    """
    estimates = [*_of_test(result), *_of_replay(result)]
    if not estimates:
        expected = "a study with a test on unseen scenes, or a replay with measure=false"
        raise UserError(Fault(str(folder), "its results predict nothing", expected))
    values = []
    for camera, score, value, error in estimates:
        half = errors.get(score.rpartition(".")[2], NEVER_MEASURED).half_width(value, error)
        values.append(PredictedValue(camera, score, value, error, value - half, value + half))
    kinds = dict.fromkeys(value.kind for value in values)
    return Prediction(
        about or f"Scores of {result['name']}",
        when.isoformat(timespec="seconds"),
        tuple(values),
        {key: result[key] for key in ("name", "seed", "tacos") if key in result},
        {kind: vars(errors[kind]) for kind in kinds if kind in errors},
    )


def measured_in(path: Path, result: Mapping[str, Any] | None) -> Measured:
    """Measured values: of a replayed recording's results, or of a table ``camera,score,value``.

    Raises `UserError` when the table lacks a column, holds what is no number, or has two lines for one score.
    """
    if result is not None:
        name = f"replay.{result.get('score', 'inliers')}"
        return {(f"{ms} ms", name): float(real["inliers"]) for ms, real in result.get("real", {}).items()}
    headings, rows = read_rows(path)
    if missing := [name for name in _COLUMNS if name not in headings]:
        raise UserError(Fault(f"{path}:1", f"lacks the column {missing[0]}", "columns camera, score, value"))
    faults: list[Fault] = []
    found: dict[tuple[str, str], float] = {}
    for number, row in rows:
        where = f"{path}:{number}"
        value = finite_number(row.get("value", ""))
        key = row.get("camera", ""), row.get("score", "")
        if value is None or not all(key):
            faults.append(
                Fault(where, f"holds {','.join(row.values())!r}", "a camera, a score and a finite number")
            )
        elif key in found:
            what = f"has {' '.join(key)} a second time"
            faults.append(Fault(where, what, "one line for each score", "Write the mean of repeats."))
        else:
            found[key] = value
    if faults:
        raise UserError(faults)
    return found


def _of_test(result: Mapping[str, Any]) -> Iterator[Estimate]:
    cameras = result.get("cameras", {})
    for camera, scores in result.get("test", {}).items():
        spread = cameras.get(camera, {}).get("spread", {})
        for score, value in scores.items():
            if score != "fitness" and score in spread:
                yield camera, score, float(value), float(spread[score])


def _of_replay(result: Mapping[str, Any]) -> Iterator[Estimate]:
    """Exposures that are not refused; of several sources, the one that answers for most of them."""
    sources: Mapping[str, Any] = result.get("sources", {})
    answered = {name: _answered(found["exposures"]) for name, found in sources.items()}
    best = max(answered.values(), key=len, default=[])
    for each in best:
        low, high = each["interval"]
        error = (high - low) / 2 / _NORMAL_90
        yield f"{each['ms']:g} ms", f"replay.{result.get('score', 'inliers')}", each["predicted"], error


def _answered(exposures: Iterable[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    return [each for each in exposures if each["refused"] is None and each["interval"]]
