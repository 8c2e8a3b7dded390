"""``tacos predict``: files that cannot change unseen, outcomes, and the model error they leave."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from tacos_decision.predictions.outcome import Miss, hold_against, read_outcome, write_outcome
from tacos_decision.predictions.prediction import PredictedValue, Prediction, read_prediction
from tacos_decision.predictions.register import (
    ModelError,
    misses_in,
    model_errors,
    sentence,
    shipped_register,
)
from tacos_decision.predictions.sources import measured_in, prediction_from
from tacos_framework import UserError
from tacos_framework.cli import tacos_main

WHEN = datetime(2026, 11, 27, 12, tzinfo=UTC)
STUDY = {
    "name": "toy",
    "seed": 7,
    "test": {"a": {"task.inliers": 100.0, "fitness": 1.0}, "b": {"task.inliers": 50.0, "fitness": 0.5}},
    "cameras": {
        "a": {"spread": {"task.inliers": 4.0, "fitness": 0.1}},
        "b": {"spread": {"task.inliers": 2.0, "fitness": 0.1}},
    },
}


def predicted(value: float, error: float = 1.0, camera: str = "a") -> PredictedValue:
    return PredictedValue(camera, "task.inliers", value, error, value - 1.645 * error, value + 1.645 * error)


def test_a_study_predicts_its_scores_with_normal_intervals_where_nothing_was_measured() -> None:
    found = prediction_from(STUDY, Path("run"), {}, "", WHEN)
    first = found.values[0]
    assert [value.camera for value in found.values] == ["a", "b"]
    assert (first.low, first.high) == pytest.approx((100 - 1.645 * 4, 100 + 1.645 * 4), rel=1e-3)
    assert found.about == "Scores of toy"


def test_past_misses_widen_new_intervals() -> None:
    misses = [Miss(predicted(100.0), value) for value in (80.0, 120.0, 90.0, 115.0)]
    errors = model_errors(misses)
    assert errors["inliers"].measured == 4
    assert 0.1 < errors["inliers"].relative < 0.2
    plain, wide = (prediction_from(STUDY, Path("run"), each, "", WHEN).values[0] for each in ({}, errors))
    assert wide.low < plain.low
    assert wide.high > plain.high


def test_intervals_with_model_error_hold_nine_in_ten() -> None:
    rng = np.random.default_rng(4)
    held = []
    for _ in range(400):
        truths = 100 * (1 + rng.normal(0, 0.2, 9)) + rng.normal(0, 5, 9)
        errors = model_errors([Miss(predicted(100.0, 5.0), truth) for truth in truths[:8]])
        held.append(abs(truths[8] - 100) <= errors["inliers"].half_width(100.0, 5.0))
    assert 0.85 < np.mean(held) < 0.96


def test_a_changed_prediction_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.prediction.json"
    made = Prediction("about", WHEN.isoformat(), (predicted(10.0),))
    made.write(path)
    assert read_prediction(path) == made
    path.write_text(path.read_text().replace('"value": 10.0', '"value": 12.0'))
    with pytest.raises(UserError, match="changed after it was hashed"):
        read_prediction(path)
    with pytest.raises(UserError, match="there is a prediction already"):
        made.write(path)


def test_an_outcome_says_order_and_coverage_and_is_read_again(tmp_path: Path) -> None:
    made = Prediction("about", WHEN.isoformat(), (predicted(10.0), predicted(20.0, camera="b")))
    outcome = hold_against(made, {("a", "task.inliers"): 10.5, ("b", "task.inliers"): 40.0}, "table.csv")
    assert outcome.coverage == 0.5
    assert outcome.tau == {"task.inliers": 1.0}
    write_outcome(tmp_path / "run.outcome.json", outcome, made, WHEN.isoformat())
    assert read_outcome(tmp_path / "run.outcome.json") == list(outcome.misses)
    assert misses_in([tmp_path]) == list(outcome.misses)
    with pytest.raises(UserError, match="nothing that was predicted"):
        hold_against(made, {("c", "task.inliers"): 1.0}, "table.csv")


def test_a_table_with_faults_names_each_line(tmp_path: Path) -> None:
    table = tmp_path / "measured.csv"
    table.write_text("camera,score,value\na,task.inliers,12\nb,task.inliers,many\nc\n")
    with pytest.raises(UserError) as refused:
        measured_in(table, None)
    assert [fault.where.rpartition(":")[2] for fault in refused.value.faults] == ["3", "4"]
    table.write_text("camera,score,value\na,s,nan\nb,s,inf\nc,s,1\nc,s,2\n")
    with pytest.raises(UserError, match="has c s a second time") as refused:
        measured_in(table, None)
    assert [fault.where.rpartition(":")[2] for fault in refused.value.faults] == ["2", "3", "5"]
    table.write_text("camera,score\n")
    with pytest.raises(UserError, match="lacks the column value"):
        measured_in(table, None)


def test_the_command_predicts_and_measures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = tmp_path / "run"
    run.mkdir()
    (run / "result.json").write_text(json.dumps(STUDY))
    assert tacos_main(["predict", str(run)]) == 0
    assert "commit it before you measure" in capsys.readouterr().out
    table = tmp_path / "measured.csv"
    table.write_text("camera,score,value\na,task.inliers,101\nb,task.inliers,49\n")
    assert tacos_main(["predict", str(tmp_path / "run.prediction.json"), "--measured", str(table)]) == 0
    said = capsys.readouterr().out
    assert "Kendall's tau 1.00" in said
    assert "100% of 2 values inside" in said
    assert (tmp_path / "run.outcome.json").is_file()


@pytest.mark.filterwarnings("error")
def test_measured_values_that_were_not_predicted_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, table = tmp_path / "run.prediction.json", tmp_path / "measured.csv"
    prediction_from(STUDY, Path("run"), {}, "", WHEN).write(path)
    table.write_text("Camera,Score,VALUE\na,task.inliers,101\nb,task.inlier,49\n")
    assert tacos_main(["predict", str(path), "--measured", str(table)]) == 0
    said = capsys.readouterr().out
    assert "b task.inlier was not predicted, and is left out. Did you mean 'b task.inliers'" in said
    assert "one camera has no order" in said


def test_what_is_known_is_said_in_a_sentence() -> None:
    assert (
        sentence(["inliers"], {}) == "No prediction of these scores has been held against a real camera yet."
    )
    assert "inliers by 12% (5 values)" in sentence(["inliers"], {"inliers": ModelError(0.12, 5)})


def test_the_projects_own_register_can_be_read() -> None:
    for path in shipped_register().glob("*.prediction.json"):
        read_prediction(path)
    assert all(np.isfinite(miss.relative) for miss in misses_in([shipped_register()]))
