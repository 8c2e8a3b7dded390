"""What every optimizer must do."""

from __future__ import annotations

import json
import math
from typing import Any, ClassVar

import numpy as np

from tacos_framework.contracts import Evaluated
from tacos_framework.testing.component import ComponentConformance
from tacos_framework.variables.design_space import Candidate, Categorical, Continuous, DesignSpace, Integer

MOST_ROUNDS = 1000
"""An optimizer whose settings under test ask for more rounds than this has no end worth waiting for."""


class OptimizerConformance(ComponentConformance):
    """The suite for optimizers; give settings under which at least three rounds are asked, but few."""

    kind: ClassVar[str] = "optimizer"

    def space(self) -> DesignSpace:
        """The design space of the tests."""
        return DesignSpace(
            [
                Continuous("pitch_deg", -30, 30, "deg"),
                Integer("cameras", 1, 8),
                Categorical("lens", ("wide", "normal", "tele")),
            ]
        )

    def make(self, seed: int = 1) -> Any:
        """The optimizer under test."""
        config = self.component.Config(**self.config)
        return self.component(config, space=self.space(), rng=np.random.default_rng(seed))

    def fitness(self, candidate: Candidate) -> float | None:
        """What candidates are worth; some fail."""
        pitch_deg = float(candidate.values["pitch_deg"])
        return None if pitch_deg > 20 else -((pitch_deg - 5) ** 2) + candidate.values["cameras"]

    def round(self, optimizer: Any) -> list[Candidate]:
        """Ask and tell once."""
        asked: list[Candidate] = optimizer.ask()
        optimizer.tell([Evaluated(candidate, self.fitness(candidate)) for candidate in asked])
        return asked

    def rounds(self, optimizer: Any) -> list[list[str]]:
        """Ask and tell until the optimizer stops; the keys of the candidates."""
        history: list[list[str]] = []
        while optimizer.stop() is None:
            assert len(history) < MOST_ROUNDS, f"no stop after {MOST_ROUNDS} rounds"
            history.append([candidate.key for candidate in self.round(optimizer)])
        return history

    def test_it_asks_for_candidates_that_can_be_made(self) -> None:
        space, optimizer = self.space(), self.make()
        while optimizer.stop() is None:
            asked = self.round(optimizer)
            assert isinstance(asked, list)
            assert asked, "ask() gave nothing although stop() gave no reason"
            for candidate in asked:
                assert candidate == space.decode(candidate.genes), "a candidate is not snapped to the space"

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
        assert [c.key for c in optimizer.ask()] == [c.key for c in optimizer.ask()]

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

    def test_it_goes_on_when_every_candidate_fails(self) -> None:
        optimizer = self.make()
        for _ in range(3):
            if optimizer.stop() is not None:
                break
            asked = optimizer.ask()
            assert asked
            optimizer.tell([Evaluated(candidate, None) for candidate in asked])

    def test_it_takes_what_it_is_told_as_it_is(self) -> None:
        optimizer = self.make()
        observed = [Evaluated(candidate, math.pi) for candidate in optimizer.ask()]
        before = list(observed)
        optimizer.tell(observed)
        assert observed == before
