"""Weights that candidates share: one trains while the last is scored, as if each had been done alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import wraps

import pytest
from toy_plugin import ToyRenderer
from toy_study import LEARNER, merged, toy_recipe

from tacos_framework.simulation import EpisodeSpec, Evaluator, ScoreJob
from tacos_framework.study.pipelined import score_pipelined
from tacos_framework.testing.fingerprint import fingerprint

FOCAL_LENGTHS_MM = (1.0, 0.6, 3.0, 1.5)


class Recorder:
    """An executor that notes which jobs it was given together."""

    def __init__(self):
        self.rounds = []

    def map(self, evaluate, jobs):
        self.rounds.append(["training" if job.training else "scoring" for job in jobs])
        return map(evaluate, jobs)


def jobs_of(evaluate: Evaluator) -> list[ScoreJob]:
    states = evaluate.simulation.initial_states()
    episodes, training = (EpisodeSpec(3, ("design", 0, 0)),), EpisodeSpec(3, ("train", 0, 0))
    return [
        ScoreJob({"focal_length_mm": f, "pitch_deg": 0.0}, episodes, states, training=training)
        for f in FOCAL_LENGTHS_MM
    ]


def one_by_one(evaluate: Evaluator, jobs: list[ScoreJob]):
    """What pipelined scoring has to come to: each job alone, from the states that the last left."""
    states: Mapping = jobs[0].states
    for job in jobs:
        evaluation = evaluate(replace(job, states=states))
        states = {**states, **evaluation.states}
        yield evaluation


def without_times(evaluation):
    return fingerprint(replace(evaluation, seconds={}))


def test_pipelined_scoring_comes_to_what_each_candidate_alone_comes_to(toys):
    evaluate, executor = Evaluator(toy_recipe(**LEARNER), toys), Recorder()
    jobs = jobs_of(evaluate)
    pipelined = list(score_pipelined(jobs, executor, evaluate))
    assert [without_times(e) for e in pipelined] == [without_times(e) for e in one_by_one(evaluate, jobs)]
    assert all("learner, training" in e.seconds and "width" in e.seconds for e in pipelined)


def test_a_candidate_is_scored_while_the_next_one_trains(toys):
    evaluate, executor = Evaluator(toy_recipe(**LEARNER), toys), Recorder()
    list(score_pipelined(jobs_of(evaluate), executor, evaluate))
    both = ["training", "scoring"]
    assert executor.rounds == [["training"], both, both, both, ["scoring"]]


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize(
    ("sections", "trains"),
    [
        ({"constraints": {"hfov_deg": {"max": 100}}}, False),  # refused before it is trained on
        ({"nodes": {"width": {"fail_above_deg": 100}}}, True),  # trained on, then refused by a scorer
    ],
)
def test_pipelined_scoring_goes_on_after_a_candidate_that_fails(toys, sections, trains, workers):
    evaluate = Evaluator(toy_recipe(**merged(LEARNER, sections)), toys)
    executor = TwoWorkers() if workers == 2 else Recorder()
    first, failed, third, _ = score_pipelined(jobs_of(evaluate), executor, evaluate)
    assert failed.failed
    assert failed.fitness is None
    assert bool(failed.states) is trains
    steps = [int(e.states["learner"]["steps"][0]) for e in (first, third)]
    assert steps == [6, 18 if trains else 12]  # six frames a training


class TwoWorkers(Recorder):
    """Two workers that take turns, in each of which jobs find what the worker has."""

    workers = 2

    def map(self, evaluate, jobs):
        self.rounds.append([type(job).__name__ for job in jobs])
        return map(evaluate, jobs)


def test_a_free_worker_renders_for_the_training_to_come_with_the_same_results(toys):
    evaluate, executor = Evaluator(toy_recipe(**LEARNER), toys), TwoWorkers()
    worlds = [EpisodeSpec(3, ("train", 0, i)) for i in (0, 1, 1, 2)]
    jobs = [replace(job, training=world) for job, world in zip(jobs_of(evaluate), worlds, strict=True)]
    pipelined = list(score_pipelined(jobs, executor, evaluate))
    assert [without_times(e) for e in pipelined] == [without_times(e) for e in one_by_one(evaluate, jobs)]
    train, ahead, score = "ScoreJob", "PrepareJob", "ScoreJob"
    assert executor.rounds == [
        [train, ahead],
        [train, ahead],  # the first candidate waits until there are two to score
        [train, ahead, score, score],
        [train, score],
        [score],
    ]


def test_what_is_rendered_ahead_is_not_rendered_again(toys, monkeypatch):
    rendered, capture = [], ToyRenderer.capture

    @wraps(capture)
    def counted(self, episode, **how):
        rendered.append(len(episode))
        return capture(self, episode, **how)

    monkeypatch.setattr(ToyRenderer, "capture", counted)
    evaluate = Evaluator(toy_recipe(**LEARNER), toys)
    pipelined = list(score_pipelined(jobs_of(evaluate), TwoWorkers(), evaluate))
    assert sum(rendered) == sum(evaluation.images for evaluation in pipelined)


def test_a_candidate_is_scored_in_each_world_by_itself(toys):
    evaluate, executor = Evaluator(toy_recipe(**LEARNER), toys), Recorder()
    episodes = tuple(EpisodeSpec(3, ("design", 0, i)) for i in range(3))
    jobs = [replace(job, episodes=episodes) for job in jobs_of(evaluate)[:2]]
    pipelined = list(score_pipelined(jobs, executor, evaluate))
    scoring = ["scoring"] * 3
    assert executor.rounds == [["training"], ["training", *scoring], scoring]
    assert [without_times(e) for e in pipelined] == [without_times(e) for e in one_by_one(evaluate, jobs)]


def test_what_cannot_be_prepared_is_told_where_it_is_needed(toys, caplog):
    evaluate = Evaluator(toy_recipe(**LEARNER), toys)
    first, second, *_ = jobs_of(evaluate)
    worlds = [EpisodeSpec(3, ("train", 0, i)) for i in (0, 1)]
    jobs = [
        replace(first, training=worlds[0]),
        replace(second, training=worlds[1], values={"focal_length_mm": -1.0, "pitch_deg": 0.0}),
    ]
    fine, refused = score_pipelined(jobs, TwoWorkers(), evaluate)
    assert fine.failed is None
    assert refused.failed.startswith("the rig refuses it")
