"""Conformance suite of optimizers."""

from __future__ import annotations

import json
import math
from typing import Any, ClassVar

import numpy as np
import pytest

from tacos_framework.contracts import Asked, DesignProblem, Evaluated, OptimizerBase, optional
from tacos_framework.fitness import Fitness, FitnessTerm, standard_errors
from tacos_framework.study.guarded_optimizer import takes_problem
from tacos_framework.testing.component import ComponentConformance
from tacos_framework.variables.design_space import Candidate, Categorical, Continuous, DesignSpace, Integer

MOST_ROUNDS = 1000
"""An optimizer whose settings under test ask for more rounds than this has no end worth waiting for."""

EPISODES, FRAMES = 3, 8
"""Of the study that the optimizer under test is told of: episodes, and images of each."""

RECOMMENDED = 3
"""Candidates that are to be recommended."""


UNUSUAL: dict[str, dict[str, Any]] = {
    "that it fails": {"fitness": None, "failed": "it cannot be judged"},
    "that it breaks a constraint": {"fitness": None, "failed": "too wide", "broken": {"hfov_deg": 3.0}},
    "the same fitness": {"fitness": 0.0, "episodes": {i: {"task.score": 0.0} for i in range(EPISODES)}},
    "that no episode gives the score": {"fitness": None, "failed": "no score", "episodes": {0: {}}},
}
"""The results of every candidate there is."""


class OptimizerConformance(ComponentConformance):
    """The suite for optimizers; give settings under which at least three rounds are asked, but few."""

    kind: ClassVar[str] = "optimizer"

    def space(self) -> DesignSpace:
        return DesignSpace(
            [
                Continuous("pitch_deg", -30, 30, "deg"),
                Integer("cameras", 1, 8),
                Categorical("lens", ("wide", "normal", "tele")),
            ]
        )

    def problem(self) -> DesignProblem:
        return DesignProblem(
            Fitness((FitnessTerm("task.score", 1.0),)),
            episodes=EPISODES,
            coordinates=lambda candidate: {
                "pitch_deg": float(candidate.values["pitch_deg"]),
                "log2_cameras": math.log2(candidate.values["cameras"]),
                "lens": candidate.genes[2],
            },
            broken=self.broken,
            depends_on={"task.score": ("pitch_deg", "log2_cameras")},
        )

    def make(self, seed: int = 1) -> Any:
        supplied: dict[str, Any] = {"space": self.space(), "rng": np.random.default_rng(seed)}
        if takes_problem(self.component):
            supplied["problem"] = self.problem()
        return self.component(self.component.Config(**self.config), **supplied)

    def fitness(self, candidate: Candidate) -> float | None:
        """Fitness of candidates; some fail."""
        pitch_deg = float(candidate.values["pitch_deg"])
        return None if pitch_deg > 20 else -((pitch_deg - 5) ** 2) + candidate.values["cameras"]

    def broken(self, candidate: Candidate) -> dict[str, float]:
        """The constraint that some candidates break, and by how much."""
        beyond_deg = -25 - float(candidate.values["pitch_deg"])
        return {"pitch_deg": beyond_deg} if beyond_deg > 0 else {}

    def evaluated(self, asked: Candidate | Asked) -> Evaluated:
        """The evaluation that a study would report for a candidate."""
        candidate, episodes = _parts(asked)
        if broken := self.broken(candidate):
            return Evaluated(candidate, None, failed="pitch_deg is below -25", broken=broken)
        fitness = self.fitness(candidate)
        if fitness is None:
            return Evaluated(candidate, None, failed="it cannot be judged", images=FRAMES)
        scores = {number: {"task.score": fitness + number} for number in episodes or range(EPISODES)}
        values = [score["task.score"] for score in scores.values()]
        return Evaluated(
            candidate,
            math.fsum(values) / len(values),
            episodes=scores,
            standard_errors=standard_errors(list(scores.values())),
            images=FRAMES * len(scores),
        )

    def round(self, optimizer: Any) -> list[Candidate | Asked]:
        """Ask and tell once."""
        asked: list[Candidate | Asked] = optimizer.ask()
        optimizer.tell([self.evaluated(each) for each in asked])
        return asked

    def rounds(self, optimizer: Any) -> list[list[str]]:
        """Ask and tell until the optimizer stops; the keys of the candidates, and episodes where it said."""
        history: list[list[str]] = []
        while optimizer.stop() is None:
            assert len(history) < MOST_ROUNDS, f"no stop after {MOST_ROUNDS} rounds"
            history.append([_name(each) for each in self.round(optimizer)])
        return history

    def test_it_asks_for_candidates_that_can_be_made(self) -> None:
        space, optimizer = self.space(), self.make()
        while optimizer.stop() is None:
            asked = self.round(optimizer)
            assert isinstance(asked, list)
            assert asked, "ask() gave nothing although stop() gave no reason"
            for each in asked:
                candidate, episodes = _parts(each)
                assert candidate == space.decode(candidate.genes), "a candidate is not snapped to the space"
                assert episodes is None or _are_some(episodes), (
                    f"{episodes} are not some of {EPISODES} episodes"
                )

    def test_it_says_why_it_stops(self) -> None:
        optimizer = self.make()
        self.rounds(optimizer)
        reason = optimizer.stop()
        assert isinstance(reason, str)
        assert reason.strip()

    def test_equal_generators_ask_for_equal_candidates(self) -> None:
        assert self.rounds(self.make()) == self.rounds(self.make())

    def test_different_generators_ask_for_different_candidates(self) -> None:
        assert self.rounds(self.make(seed=1)) != self.rounds(self.make(seed=2))

    def test_resumed_after_any_round_it_goes_on_as_if_never_stopped(self) -> None:
        unbroken = self.rounds(self.make())
        for done in range(len(unbroken) + 1):
            first = self.make()
            for _ in range(done):
                self.round(first)
            kept = json.loads(json.dumps(first.state(), allow_nan=False))
            second = self.make(seed=99)
            second.restore(kept)
            assert self.rounds(second) == unbroken[done:], f"differs when resumed after round {done}"

    def test_a_state_taken_before_the_results_are_told_asks_again(self) -> None:
        unbroken = self.rounds(self.make())
        first = self.make()
        self.round(first)
        first.ask()
        second = self.make(seed=99)
        second.restore(json.loads(json.dumps(first.state())))
        assert self.rounds(second) == unbroken[1:]

    def test_it_asks_the_same_until_it_is_told(self) -> None:
        optimizer = self.make()
        assert [_name(each) for each in optimizer.ask()] == [_name(each) for each in optimizer.ask()]

    def test_a_state_once_taken_does_not_change(self) -> None:
        optimizer = self.make()
        while optimizer.stop() is None:
            state = optimizer.state()
            kept = json.dumps(state)
            self.round(optimizer)
            assert json.dumps(state) == kept, "state() hands out what the optimizer goes on to change"

    def test_it_asks_for_no_more_than_it_expects(self) -> None:
        optimizer = self.make()
        expected = optimizer.expected_candidates
        if expected is None:
            return
        asked = sum(len(keys) for keys in self.rounds(optimizer))
        assert asked <= expected, f"{asked} candidates were asked, {expected} expected"

    @pytest.mark.parametrize("told", UNUSUAL, ids=list(UNUSUAL))
    def test_it_goes_on_when_it_is_told_of_every_candidate(self, told: str) -> None:
        optimizer = self.make()
        for _ in range(3):
            if optimizer.stop() is not None:
                break
            asked = optimizer.ask()
            assert asked
            optimizer.tell([Evaluated(_parts(each)[0], **UNUSUAL[told]) for each in asked])

    def test_it_takes_what_it_is_told_as_it_is(self) -> None:
        optimizer = self.make()
        observed = [Evaluated(_parts(each)[0], math.pi) for each in optimizer.ask()]
        before = list(observed)
        optimizer.tell(observed)
        assert observed == before

    def test_it_recommends_candidates_that_can_be_made(self) -> None:
        space, optimizer = self.space(), self.make()
        if not callable(optional(optimizer, OptimizerBase, "recommend")):
            return
        self.rounds(optimizer)
        recommended = optimizer.recommend(RECOMMENDED)
        assert 1 <= len(recommended) <= RECOMMENDED, f"{len(recommended)} were given for {RECOMMENDED}"
        for candidate in recommended:
            assert candidate == space.decode(candidate.genes), "a candidate is not snapped to the space"
            assert not self.broken(candidate), "a candidate breaks a constraint"
        assert len({candidate.key for candidate in recommended}) == len(recommended), (
            "a candidate comes twice"
        )

    def test_a_recommendation_changes_nothing(self) -> None:
        asking, optimizer = self.make(), self.make()
        if not callable(optional(optimizer, OptimizerBase, "recommend")):
            return
        while asking.stop() is None:
            first = [candidate.key for candidate in optimizer.recommend(RECOMMENDED)]
            assert [candidate.key for candidate in optimizer.recommend(RECOMMENDED)] == first
            asked = [_name(each) for each in self.round(optimizer)]
            assert asked == [_name(each) for each in self.round(asking)], (
                "it asks for others once it recommends"
            )

    def test_its_notes_are_sentences(self) -> None:
        notes = optional(self.component, OptimizerBase, "notes")
        if not callable(notes):
            return
        for note in notes(self.component.Config(**self.config), self.space()):
            assert isinstance(note, str), f"a note is {note!r}"
            assert note.strip(), "a note is empty"

    def test_of_finalists_it_chooses_one_that_is_there(self) -> None:
        optimizer = self.make()
        if not callable(optional(optimizer, OptimizerBase, "choose")):
            return
        asked = [each for _ in range(2) if optimizer.stop() is None for each in self.round(optimizer)]
        finalists = [self.evaluated(_parts(each)[0]) for each in asked]
        scored = [finalist for finalist in finalists if finalist.fitness is not None]
        before = json.dumps(optimizer.state())
        for some in (scored[:1], scored[:RECOMMENDED]):
            assert optimizer.choose(some) in range(len(some)), "it chooses none of the finalists"
        assert json.dumps(optimizer.state()) == before, "choose() changes what the optimizer knows"


def _parts(asked: Candidate | Asked) -> tuple[Candidate, tuple[int, ...] | None]:
    """A candidate, and the episodes it is to be scored on."""
    return (asked.candidate, asked.episodes) if isinstance(asked, Asked) else (asked, None)


def _name(asked: Candidate | Asked) -> str:
    """The request as text: the same for no other candidate or episodes."""
    candidate, episodes = _parts(asked)
    return candidate.key if episodes is None else f"{candidate.key} on {sorted(episodes)}"


def _are_some(episodes: tuple[int, ...]) -> bool:
    return 0 < len(set(episodes)) == len(episodes) and set(episodes) <= set(range(EPISODES))
