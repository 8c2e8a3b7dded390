"""Optimizers that ask for what cannot be: each is told what it gave and what was expected."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tacos_framework.contracts import Asked, DesignProblem, Evaluated
from tacos_framework.errors import ContractBroken
from tacos_framework.fitness import Fitness, FitnessTerm
from tacos_framework.plan import ConfiguredComponent
from tacos_framework.settings import Settings
from tacos_framework.study.guarded_optimizer import GuardedOptimizer
from tacos_framework.variables.design_space import Candidate, Continuous, DesignSpace

SPACE = DesignSpace([Continuous("pitch_deg", -30, 30, "deg"), Continuous("focal_length_mm", 1, 5, "mm")])
SOUND = SPACE.decode([3.0, 2.0])
PROBLEM = DesignProblem(
    Fitness((FitnessTerm("width.closeness", 1.0),)), episodes=4, coordinates=dict, broken=lambda _: {}
)


class Unruly:
    """Does as it is told, with no regard for its contract."""

    class Config(Settings):
        """No settings."""

    expected_candidates = None

    def __init__(self, config, *, space, rng):
        self.asked, self.reason, self.kept = [SOUND], None, {}

    def ask(self):
        return self.asked

    def tell(self, evaluated):
        return evaluated[7]

    def stop(self):
        return self.reason

    def state(self):
        return self.kept

    def restore(self, state):
        raise KeyError("generation")


@pytest.fixture
def optimizer():
    part = ConfiguredComponent("optimizer.acme", Unruly, Unruly.Config(), "acme-search")
    return GuardedOptimizer(part, SPACE, np.random.default_rng(1), PROBLEM)


def test_one_that_keeps_to_its_contract_is_left_alone(optimizer):
    assert optimizer.ask() == [Asked(SOUND)]
    assert optimizer.recommend(3) is None
    assert optimizer.choose([Evaluated(SOUND, 1.0)]) is None
    assert optimizer.stop() is None
    assert optimizer.state() == {}
    assert optimizer.expected_candidates is None


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (None, "ask() gives None; expected a list of candidates"),
        (SOUND, "ask() gives a Candidate; expected a list of candidates"),
        ([], "ask() gives no candidates; expected at least one, as stop() gives no reason to end"),
        (
            [SOUND, [3.0, 2.0]],
            "ask() gives [3.0, 2.0] as candidate 2 of 2; expected a Candidate, made by space.decode",
        ),
        (
            [Candidate({"pitch_deg": 3.0}, (3.0,))],
            "ask() gives candidate 1 of 1 with values for pitch_deg; "
            "expected values for pitch_deg, focal_length_mm",
        ),
        (
            [Candidate(SOUND.values, (3.0,))],
            "ask() gives candidate 1 of 1 with the genes (3.0,); "
            "expected its own genes: this design space has 2 genes, not (1,)",
        ),
        (
            [Candidate({"pitch_deg": 99.0, "focal_length_mm": 2.0}, (99.0, 2.0))],
            "ask() gives candidate 1 of 1, {'pitch_deg': 99.0, 'focal_length_mm': 2.0}, which is outside of "
            "the design space; expected a candidate made by space.decode, here "
            "{'pitch_deg': 30.0, 'focal_length_mm': 2.0}",
        ),
    ],
)
def test_what_it_asks_for_must_be_candidates_of_the_space(optimizer, asked, said):
    optimizer._optimizer.asked = asked
    with pytest.raises(ContractBroken) as raised:
        optimizer.ask()
    assert str(raised.value) == f"optimizer.acme of acme-search: {said}"


def test_nothing_may_be_asked_for_once_there_is_a_reason_to_stop(optimizer):
    optimizer._optimizer.asked, optimizer._optimizer.reason = [], "all is known"
    assert optimizer.ask() == []


def test_episodes_may_be_asked_for_in_any_order(optimizer):
    optimizer._optimizer.asked = [SOUND, Asked(SOUND, (np.int64(3), 1)), Asked(SOUND)]
    assert optimizer.ask() == [Asked(SOUND), Asked(SOUND, (1, 3)), Asked(SOUND)]


@pytest.mark.parametrize("episodes", [(), (4,), (-1,), (1, 1), (1.0,), (True,), 2, "0"])
def test_episodes_must_be_some_of_those_there_are(optimizer, episodes):
    optimizer._optimizer.asked = [Asked(SOUND, episodes)]
    with pytest.raises(ContractBroken) as raised:
        optimizer.ask()
    assert str(raised.value) == (
        f"optimizer.acme of acme-search: ask() gives candidate 1 of 1 with the episodes {episodes!r}; "
        "expected one or more of the numbers 0 to 3, each once, or None for all"
    )


@pytest.mark.parametrize("place", [2, -1, 1.0, True, None, "0"])
def test_the_best_finalist_must_be_one_of_them(optimizer, place):
    optimizer._optimizer.choose = lambda finalists: place
    with pytest.raises(ContractBroken) as raised:
        optimizer.choose([Evaluated(SOUND, 1.0), Evaluated(SPACE.decode([4.0, 2.0]), 2.0)])
    assert str(raised.value) == (
        f"optimizer.acme of acme-search: choose() gives {place!r} for 2 finalists; "
        "expected the place of one, from 0 to 1"
    )


def test_a_recommendation_is_of_different_candidates(optimizer):
    optimizer._optimizer.recommend = lambda count: [SOUND, SPACE.decode([4.0, 2.0]), SOUND][:count]
    assert optimizer.recommend(3) == [SOUND, SPACE.decode([4.0, 2.0])]


@pytest.mark.parametrize(
    ("recommended", "said"),
    [
        (SOUND, "recommend() gives a Candidate; expected a list of candidates"),
        ([SOUND] * 3, "recommend(2) gives 3 candidates; expected at most 2"),
        ([(3.0, 2.0)], "recommend() gives (3.0, 2.0) as candidate 1 of 1; expected a Candidate"),
        (
            [Candidate({"pitch_deg": 3.0}, (3.0,))],
            "gives candidate 1 of 1 with values for pitch_deg; ",
        ),
    ],
)
def test_what_it_recommends_must_be_candidates_of_the_space(optimizer, recommended, said):
    optimizer._optimizer.recommend = lambda _: recommended
    with pytest.raises(ContractBroken, match=re.escape(said)):
        optimizer.recommend(2)


class Curious(Unruly):
    """Asks what the problem is."""

    def __init__(self, config, *, space, rng, problem):
        super().__init__(config, space=space, rng=rng)
        self.problem = problem


def test_one_that_asks_for_the_problem_is_given_it():
    part = ConfiguredComponent("optimizer.acme", Curious, Curious.Config(), "acme-search")
    assert GuardedOptimizer(part, SPACE, np.random.default_rng(1), PROBLEM)._optimizer.problem is PROBLEM


@pytest.mark.parametrize(
    ("attribute", "value", "call", "said"),
    [
        ("reason", True, "stop", "stop() gives True; expected a reason in a sentence, or None to go on"),
        ("reason", "", "stop", "stop() gives ''; expected a reason in a sentence, or None to go on"),
        ("kept", None, "state", "state() gives None; expected a dict of JSON values"),
        ("kept", {"best": float("nan")}, "state", "state() gives what JSON cannot hold"),
        ("kept", {"rng": np.int64(3)}, "state", "Object of type int64 is not JSON serializable"),
    ],
)
def test_reasons_and_states_must_be_what_they_are_for(optimizer, attribute, value, call, said):
    setattr(optimizer._optimizer, attribute, value)
    with pytest.raises(ContractBroken) as raised:
        getattr(optimizer, call)()
    assert str(raised.value).startswith("optimizer.acme of acme-search: ")
    assert said in str(raised.value)


@pytest.mark.parametrize(("call", "error"), [("tell", IndexError), ("restore", KeyError)])
def test_what_it_raises_passes_with_its_name(optimizer, call, error):
    with pytest.raises(error) as raised:
        getattr(optimizer, call)([])
    assert raised.value.__notes__ == [f"in optimizer.acme of acme-search, {call}"]
