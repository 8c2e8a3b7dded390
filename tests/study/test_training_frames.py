"""Frames to train on: rendered once as far as memory goes, and the same in each pass."""

from __future__ import annotations

import pytest
from toy_study import LEARNER, merged, toy_recipe

from tacos_framework.simulation import EpisodeSpec, Evaluator, PrepareJob, ScoreJob, training
from tacos_framework.testing.fingerprint import fingerprint

FRAMES, PASSES = 8, 3
BYTES_OF_A_FRAME = 16 * 8 * (3 * 4 + 4 + 4 + 3)  # light, depth, ids, colours

VALUES = {"focal_length_mm": 1.0, "pitch_deg": 0.0}
SPEC = EpisodeSpec(3, ("train", 0, 0))

SETTLING = {"effects": [{"use": "effect.auto-white-balance", "red_first": 3.0, "lag_frames": 4.0}]}
CONTROLLED = {"exposure": {"use": "control.mean-level", "target": 0.9, "lag_frames": 3, "warm_up_frames": 0}}
DAY_AND_DUSK = {
    "scenario": [
        {"name": "day", "illumination_lux": 40},
        {"name": "dusk", "illumination_lux": 10},
    ]
}


def learning(toys, sections=None) -> Evaluator:
    """A study whose learner takes several passes over its frames."""
    train = {"weights": "shared", "epochs": PASSES, "frames": FRAMES}
    learner = merged(LEARNER, {"nodes": {"learner": {"train": train}}})
    return Evaluator(toy_recipe(**{**learner, **(sections or {})}), toys)


def trained(toys, sections=None, *, ahead=False):
    """An evaluation of a candidate that trains in several passes and is scored on nothing."""
    evaluate = learning(toys, sections)
    states = evaluate.simulation.initial_states()
    if ahead:
        evaluate(PrepareJob(VALUES, SPEC))
    return evaluate(ScoreJob(VALUES, (), states, training=SPEC, partial=True))


@pytest.mark.parametrize(("kept_frames", "images"), [(8, 8), (3.5, 8 + 5 + 5), (0, 3 * 8)])
def test_what_fits_is_rendered_once_and_the_rest_in_each_pass(toys, monkeypatch, kept_frames, images):
    everything = trained(toys)
    monkeypatch.setattr(training, "KEPT_BYTES", kept_frames * BYTES_OF_A_FRAME)
    some = trained(toys)
    assert some.images == images
    assert fingerprint(some.states) == fingerprint(everything.states)
    assert int(some.states["learner"]["steps"][0]) == PASSES * FRAMES


@pytest.mark.parametrize("ahead", [False, True])
@pytest.mark.parametrize(
    "sections", [SETTLING, CONTROLLED, {**SETTLING, **DAY_AND_DUSK}], ids=["effect", "control", "scenarios"]
)
def test_a_camera_that_remembers_goes_on_where_the_frames_that_are_kept_end(
    toys, monkeypatch, sections, ahead
):
    """A camera that settles or controls its exposure does not begin anew behind them."""
    everything = trained(toys, sections)
    monkeypatch.setattr(training, "KEPT_BYTES", 3.5 * BYTES_OF_A_FRAME)
    some = trained(toys, sections, ahead=ahead)
    assert fingerprint(some.states) == fingerprint(everything.states)


def test_nothing_is_kept_for_a_single_pass(toys, monkeypatch):
    kept = []
    monkeypatch.setattr(
        training.TrainingFrames, "_keep", lambda frames, turn, batch, draws: kept.append(frames.room_bytes)
    )
    evaluate = Evaluator(toy_recipe(**LEARNER), toys)
    states = evaluate.simulation.initial_states()
    job = ScoreJob(
        {"focal_length_mm": 1.0, "pitch_deg": 0.0},
        (),
        states,
        training=EpisodeSpec(3, ("train", 0, 0)),
        partial=True,
    )
    evaluate(job)
    assert set(kept) == {0}
