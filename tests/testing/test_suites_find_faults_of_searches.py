"""Faults of optimizers and executors: in what is asked, recommended, resumed and handed on."""

from __future__ import annotations

import numpy as np

from tacos_framework.contracts import Asked
from tacos_framework.errors import UserError
from tacos_framework.testing import ExecutorConformance, OptimizerConformance
from tacos_plugins.executors.local import LocalExecutor
from tacos_plugins.optimizers.random_search import RandomSearch
from tests.testing.applied_suite import faults_are_found, sound_ones_pass


class RestlessSearch(RandomSearch):
    def ask(self):
        return self._next()


class LiveSearch(RandomSearch):
    """Hands out the very list it goes on to fill."""

    def tell(self, evaluated):
        self.__dict__.setdefault("observed", []).append(len(evaluated))
        super().tell(evaluated)

    def state(self):
        return {**super().state(), "observed": self.__dict__.setdefault("observed", [])}


class UnderstatedSearch(RandomSearch):
    expected_candidates = 5


class RecommendingSearch(RandomSearch):
    """Recommends, and has candidates scored on one episode each, as the contract allows."""

    episodes = (2,)

    def __init__(self, config, *, space, rng, problem):
        super().__init__(config, space=space, rng=rng)
        self.problem = problem

    def ask(self):
        return [Asked(candidate, self.episodes) for candidate in super().ask()]

    def recommend(self, count):
        rng = np.random.default_rng(1)
        drawn = [self._space.sample(rng) for _ in range(20 * count)]
        return [candidate for candidate in drawn if not self.problem.broken(candidate)][:count]


class OverreachingSearch(RecommendingSearch):
    episodes = (2, 3)


class LawlessSearch(RecommendingSearch):
    """Recommends what breaks a constraint."""

    def recommend(self, count):
        return [self._space.decode([-30, 4, 1])]


class RestlessAdviser(RecommendingSearch):
    """Draws what it recommends with the generator it asks with."""

    def recommend(self, count):
        return [self._space.decode([self._rng.uniform(0, 20), 4, 1])]


class StrictSearch(RandomSearch):
    """Cannot bear a broken constraint."""

    def tell(self, evaluated):
        assert not any(result.broken for result in evaluated)
        super().tell(evaluated)


class SpreadSearch(RandomSearch):
    """Divides by the spread of the fitness."""

    def tell(self, evaluated):
        values = [result.fitness for result in evaluated if result.fitness is not None]
        assert len(values) < 2 or np.ptp(values) > 0
        super().tell(evaluated)


class FirstFaultExecutor(LocalExecutor):
    """Keeps of an error only its first fault."""

    def map(self, evaluate, jobs):
        try:
            yield from super().map(evaluate, jobs)
        except UserError as error:
            raise UserError(error.faults[0]) from None


class StickyExecutor(LocalExecutor):
    """Goes on with the first function it was given."""

    function = None

    def map(self, evaluate, jobs):
        self.function = self.function or evaluate
        return super().map(self.function, jobs)


FAULTS = [
    (OptimizerConformance, RestlessSearch, "test_it_asks_the_same_until_it_is_told"),
    (OptimizerConformance, LiveSearch, "test_a_state_once_taken_does_not_change"),
    (OptimizerConformance, UnderstatedSearch, "test_it_asks_for_no_more_than_it_expects"),
    (OptimizerConformance, OverreachingSearch, "test_it_asks_for_candidates_that_can_be_made"),
    (OptimizerConformance, LawlessSearch, "test_it_recommends_candidates_that_can_be_made"),
    (OptimizerConformance, RestlessAdviser, "test_a_recommendation_changes_nothing"),
    (
        OptimizerConformance,
        StrictSearch,
        "test_it_goes_on_when_it_is_told_of_every_candidate[that it breaks a constraint]",
    ),
    (
        OptimizerConformance,
        SpreadSearch,
        "test_it_goes_on_when_it_is_told_of_every_candidate[the same fitness]",
    ),
    (ExecutorConformance, FirstFaultExecutor, "test_errors_keep_what_they_carry"),
    (ExecutorConformance, StickyExecutor, "test_functions_may_change_between_calls"),
]
SOUND = [
    (OptimizerConformance, RecommendingSearch),
]


test_a_fault_is_found = faults_are_found(FAULTS)
test_sound_components_pass_what_the_faulty_ones_fail = sound_ones_pass(SOUND, FAULTS)
