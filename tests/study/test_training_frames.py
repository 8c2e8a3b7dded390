"""Frames to train on: rendered once as far as memory goes, and the same in each pass."""

from __future__ import annotations

import pytest
from toy_study import LEARNER, merged, toy_recipe

from tacos_framework.simulation import EpisodeSpec, Evaluator, ScoreJob, training
from tacos_framework.testing.fingerprint import fingerprint

FRAMES, PASSES = 8, 3


def trained(toys):
    """An evaluation of a candidate that trains in several passes and is scored on nothing."""
    train = {"weights": "shared", "epochs": PASSES, "frames": FRAMES}
    recipe = toy_recipe(**merged(LEARNER, {"nodes": {"learner": {"train": train}}}))
    evaluate = Evaluator(recipe, toys)
    states = evaluate.simulation.initial_states()
    spec = EpisodeSpec(3, ("train", 0, 0))
    values = {"focal_length_mm": 1.0, "pitch_deg": 0.0}
    return evaluate(ScoreJob(values, (), states, training=spec, partial=True))


@pytest.mark.parametrize(("kept_frames", "images"), [(8, 8), (3.5, 8 + 5 + 5), (0, 3 * 8)])
def test_what_fits_is_rendered_once_and_the_rest_in_each_pass(toys, monkeypatch, kept_frames, images):
    everything = trained(toys)
    bytes_of_a_frame = 16 * 8 * (3 * 4 + 4 + 4 + 3)  # light, depth, ids, colours
    monkeypatch.setattr(training, "KEPT_BYTES", kept_frames * bytes_of_a_frame)
    some = trained(toys)
    assert some.images == images
    assert fingerprint(some.states) == fingerprint(everything.states)
    assert int(some.states["learner"]["steps"][0]) == PASSES * FRAMES


def test_nothing_is_kept_for_a_single_pass(toys, monkeypatch):
    kept = []
    monkeypatch.setattr(
        training.TrainingFrames, "_keep", lambda frames, turn, batch: kept.append(frames.room_bytes)
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
