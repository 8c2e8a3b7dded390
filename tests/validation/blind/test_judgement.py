"""Answers on real cameras against what is known of them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tacos_framework.errors import UserError
from tacos_validation.blind.judgement import KnownTruth, judged, read_known
from tacos_validation.blind.limits import TimeIsUp, time_limit
from tacos_validation.blind.real_folders import real_folders


def answer(*causes: tuple[str, float], verdict: str = "explained", cause_set: tuple[str, ...] = ()) -> Any:
    named = [{"effect": name, "present": sure, "parameters": {}} for name, sure in causes]
    return {"verdict": verdict, "causes": named, "cause_set": list(cause_set)}


SATURATED = KnownTruth(("saturation",), ("quantisation",), ("tone-curve",))


@pytest.mark.parametrize(
    ("given", "outcome"),
    [
        (answer(("saturation", 0.9)), "right"),
        (answer(("saturation", 0.9), ("quantisation", 0.8)), "right"),
        (answer(("saturation", 0.9), ("jpeg", 0.4)), "right"),
        (answer(("saturation", 0.9), ("jpeg", 0.6)), "wrong beside"),
        (answer(("quantisation", 0.9), ("saturation", 0.8)), "wrong"),
        (answer(("tone-curve", 0.6), cause_set=("tone-curve", "saturation")), "right"),
        (answer(("tone-curve", 0.6), cause_set=("tone-curve",)), "wrong"),
        (answer(("jpeg", 0.4), verdict="unknown"), "unknown"),
        (answer(verdict="no_gap"), "unknown"),
        ({"error": "no answer within 600 s"}, "no answer"),
    ],
)
def test_outcomes(given: Any, outcome: str) -> None:
    assert judged(SATURATED, given).outcome == outcome


def test_silence_is_right_where_no_gap_was_expected() -> None:
    quiet = KnownTruth(("row-noise",), expect_verdict=("no_gap",))
    assert judged(quiet, answer(verdict="no_gap")).outcome == "right"
    assert judged(quiet, answer(verdict="unknown")).outcome == "unknown"


def test_what_is_negligible_counts_for_nothing() -> None:
    known = KnownTruth(("row-noise",), expect_verdict=("no_gap",), negligible={"flicker": {"depth": 0.004}})
    for depth, outcome in ((0.003, "unknown"), (0.01, "wrong")):
        found = answer(("flicker", 0.9))
        found["causes"][0]["parameters"] = {"depth": {"value": depth}}
        assert judged(known, found).outcome == outcome


def test_older_answers_are_judged_by_their_probability() -> None:
    found = answer(("saturation", 0.9))
    found["causes"][0]["probability"] = found["causes"][0].pop("present")
    assert judged(SATURATED, found).outcome == "right"


def captures(folder: Path) -> None:
    folder.mkdir(parents=True)
    (folder / "captures.yaml").write_text("tacos_captures: 1")


@pytest.mark.parametrize("beside", [True, False])
def test_folders_are_told_by_one_file_or_by_one_each(beside: bool, tmp_path: Path) -> None:
    captures(tmp_path / "phone")
    known = {"accept": ["jpeg"], "also": ["denoise"], "why": "it says so in the file"}
    if beside:
        (tmp_path / "truth.json").write_text(json.dumps({"phone": known}))
    else:
        (tmp_path / "phone" / "truth.json").write_text(json.dumps(known))
    (case,) = real_folders(tmp_path, ("jpeg", "denoise"))
    assert case.known == KnownTruth(("jpeg",), ("denoise",))
    case.write(tmp_path / "out")
    assert [file.name for file in (tmp_path / "out" / "captures").iterdir()] == ["captures.yaml"]


def test_faults_of_all_truths_come_at_once(tmp_path: Path) -> None:
    captures(tmp_path / "phone")
    truths = {"phone": {"accept": ["jpg"]}, "gone": {"accept": []}, "mute": {}}
    (tmp_path / "truth.json").write_text(json.dumps(truths))
    with pytest.raises(UserError) as raised:
        read_known(tmp_path, ("jpeg",))
    text = str(raised.value)
    assert "accept of 'phone' holds jpg" in text
    assert "there is no gone/captures.yaml" in text
    assert "'mute' does not say what to accept" in text


def test_a_folder_without_any_truth_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"no truth\.json"):
        read_known(tmp_path, ())


def test_time_limits_stop_what_guards_against_errors() -> None:
    def guarded() -> None:
        try:
            while True:
                pass
        except Exception:  # noqa: BLE001 - as a guard of components does
            pytest.fail("the limit was swallowed")

    with pytest.raises(TimeIsUp), time_limit(0.05):
        guarded()
    with time_limit(None):
        pass
