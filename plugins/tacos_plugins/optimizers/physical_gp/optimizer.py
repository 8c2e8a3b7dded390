"""`optimizer.physical-gp`: few images, where the rig says what images depend on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, ClassVar

import numpy as np

from tacos_framework import (
    Asked,
    Candidate,
    DesignProblem,
    DesignSpace,
    Evaluated,
    Settings,
    in_one_thread,
    setting,
)
from tacos_plugins.optimizers.observed_results import validate_results
from tacos_plugins.optimizers.physical_gp.episodes import next_episodes
from tacos_plugins.optimizers.physical_gp.history import Trial, scored_episodes
from tacos_plugins.optimizers.physical_gp.model import Fitted, SearchModel
from tacos_plugins.optimizers.physical_gp.pool import Genes, Located, Pool
from tacos_plugins.optimizers.physical_gp.proposals import might_be_best, proposed, recommended
from tacos_plugins.optimizers.physical_gp.starts import spread_out
from tacos_plugins.optimizers.short_searches import spread_only
from tacos_plugins.surrogate.candidates import FeasibleCandidates

QUIET_ROUNDS = 3
"""So many rounds in a row the gain to be expected is small before the search is called finished."""

_ASKING, _RECOMMENDING, _REFILLING = range(3)


class PhysicalGp:
    """A Gaussian process of each score, and the candidate of most expected improvement.

    The rig says what images depend on (fields of view, pitch, pixels), so what one sensor teaches holds for
    the next; each score has a process of its own, and the fitness is their known sum. Candidates are scored
    on few scenes, by turns, and scenes are random effects: wide before deep. A first round is spread over all
    there is; from then on each candidate is the one of largest expected improvement over the best posterior
    mean there is, tried or not, among all parts of all catalogs that keep the constraints. Every few rounds
    one is taken for what it might be.

    What failed is not asked again, and what is near it seldom. Where no rig or task says anything of the
    problem, candidates are compared by their variables and their fitness.

    Sources: Jones et al. 1998, "Efficient global optimization of expensive black-box functions"; Astudillo
    and Frazier 2019, "Bayesian optimization of composite functions" (a process for each part of a known sum).

    >>> from tacos_framework.variables.design_space import Continuous
    >>> space = DesignSpace([Continuous("baseline_m", 0.01, 3, "m")])
    >>> config = PhysicalGp.Config(evaluations=14)
    >>> search = PhysicalGp(config, space=space, rng=np.random.default_rng(1))
    >>> while not (reason := search.stop()):
    ...     search.tell([Evaluated(c, -abs(c.values["baseline_m"] - 1.6)) for c in search.ask()])
    >>> best, = search.recommend(1)
    >>> reason, bool(abs(best.values["baseline_m"] - 1.6) < 0.1)
    ('all 14 candidates were evaluated', True)
    """

    budget: ClassVar[str] = "evaluations"

    class Config(Settings):
        evaluations: int = setting(
            40, help="Candidates evaluated in all.", ge=1, also=("budget", "trials", "iterations", "steps")
        )
        per_round: int = setting(
            2, help="Candidates asked at a time after the first round; one for each worker.", ge=1
        )
        starts: int = setting(
            8,
            help="Candidates of the first round, spread over the design space; two for each variable and two "
            "more are enough where that is fewer.",
            ge=1,
        )
        episodes_per_candidate: int = setting(
            1, help="Episodes a candidate is scored on, by turns; the study may have fewer.", ge=1
        )
        global_every: int = setting(
            3,
            help=(
                "Every so many rounds one candidate is taken for what it might be, against getting stuck; "
                "0 for never."
            ),
            ge=0,
        )
        until_gain_below: float | None = setting(
            None,
            help=(
                "Stop early, once for three rounds no candidate is expected to gain more than this share of "
                "the best fitness."
            ),
            gt=0,
        )

    def __init__(
        self,
        config: Config,
        *,
        space: DesignSpace,
        rng: np.random.Generator,
        problem: DesignProblem | None = None,
    ) -> None:
        self.config = config
        self._rng = rng
        self._problem = problem
        self._starts = _first_round(config, space)
        self._feasible = FeasibleCandidates.of(space, problem)
        self._pool = Pool(self._feasible, int(rng.integers(2**32)))
        self._trials: list[Trial] = []
        self._fitted: Fitted | None = None
        self._rounds = self._quiet_rounds = 0
        self._next_round()

    @classmethod
    def notes(cls, config: Config, space: DesignSpace) -> Iterator[str]:
        """That nothing is learnt, where all evaluations belong to the first round."""
        starts = _first_round(config, space)
        if config.evaluations <= starts:
            yield spread_only(config.evaluations, starts)

    def _next_round(self) -> None:
        self._round_seed = int(self._rng.integers(2**32))
        self._asked: list[Candidate | Asked] = []
        self._gain = np.inf

    @property
    def expected_candidates(self) -> int:
        return self.config.evaluations

    @in_one_thread
    def ask(self) -> list[Candidate | Asked]:
        """The next round; the same one until it is evaluated."""
        if not self._asked and self.stop() is None:
            chosen = self._next_candidates()
            self._asked = [self._with_episodes(candidate, turn) for turn, candidate in enumerate(chosen)]
        return list(self._asked)

    def tell(self, evaluated: Sequence[Evaluated]) -> None:
        """Take in the results of the round.

        Raises `ValueError` when a fitness is NaN or infinite, or the results are not those of the candidates
        asked.
        """
        validate_results(evaluated, [a.candidate if isinstance(a, Asked) else a for a in self._asked])
        self._trials.extend(Trial.of(result, self._rounds) for result in evaluated)
        is_quiet = self._gain < (self.config.until_gain_below or 0.0)
        self._quiet_rounds = self._quiet_rounds + 1 if is_quiet else 0
        self._rounds += 1
        self._next_round()

    def stop(self) -> str | None:
        """A reason once all evaluations are observed, or there is nothing worth asking any more."""
        if len(self._trials) >= self.config.evaluations:
            return f"all {self.config.evaluations} candidates were evaluated"
        if self._quiet_rounds >= QUIET_ROUNDS:
            share = f"{100 * (self.config.until_gain_below or 0.0):g} %"
            return f"no candidate is expected to gain {share} of the fitness, for {QUIET_ROUNDS} rounds now"
        if not len(self._pool.everywhere):
            constraint = self._feasible.most_broken(200, np.random.default_rng(self._pool.seed))
            return f"no candidate was found that keeps all constraints; most break that on {constraint}"
        if not self._asked and not len(self._left()):
            return f"all {len(self._pool.everywhere)} candidates there are were evaluated"
        return None

    @in_one_thread
    def recommend(self, count: int) -> list[Candidate]:
        """The candidates of highest mean fitness, tried or not, the best first, and not all alike.

        None where all failed; where all are equal, the first that were tried.
        """
        tried = self._tried()
        if not len(tried):
            return []
        model = self._model()
        if model.grey_box.degenerate is not None:
            return list(tried.candidates[:count])
        return recommended(model, self._pool, tried, count, self._generator(_RECOMMENDING))

    @in_one_thread
    def choose(self, finalists: Sequence[Evaluated]) -> int:
        """The finalist of highest mean fitness, by all trials and by how the finalists did on fresh scenes.

        A few scenes tell less of a camera than all its neighbours do; the model weighs both. The first where
        all are equal.
        """
        fresh = [Trial.of(result, self._rounds, scenes="final ") for result in finalists]
        grey_box = self._model(fresh).grey_box
        if grey_box.degenerate is not None:
            return 0
        where = [self._pool.coordinates(trial.genes) for trial in fresh]
        return int(np.argmax(grey_box.posterior(where).mean))

    def state(self) -> dict[str, Any]:
        """The observations, the last fit, and seeds, as JSON values."""
        return {
            "trials": [trial.as_json() for trial in self._trials],
            "rounds": self._rounds,
            "quiet_rounds": self._quiet_rounds,
            "fitted": None if self._fitted is None else self._fitted.as_json(),
            "pool_seed": self._pool.seed,
            "round_seed": self._round_seed,
            "rng": self._rng.bit_generator.state,
        }

    def restore(self, state: dict[str, Any]) -> None:
        self._trials = [Trial.from_json(trial) for trial in state["trials"]]
        self._rounds, self._quiet_rounds = state["rounds"], state["quiet_rounds"]
        self._fitted = None if state["fitted"] is None else Fitted.from_json(state["fitted"])
        self._pool = Pool(self._feasible, state["pool_seed"])
        self._next_round()
        self._round_seed = state["round_seed"]
        self._rng.bit_generator.state = state["rng"]

    def _generator(self, purpose: int) -> np.random.Generator:
        """A generator for one purpose in this round, the same however often it is asked for."""
        return np.random.default_rng([self._round_seed, purpose])

    def _next_candidates(self) -> list[Candidate]:
        count = self.config.per_round if self._trials else self._starts
        count = min(count, self.config.evaluations - len(self._trials))
        tried, rng = self._tried(), self._generator(_ASKING)
        model = self._model() if len(tried) else None
        if model is None or model.grey_box.degenerate is not None:
            left = self._left()
            return list(left.take(spread_out(left.rows, count, rng)).candidates)
        closed = self._closed()
        proposal = proposed(model, self._pool, tried, closed, count, rng)
        self._gain, chosen = proposal.gain, list(proposal.candidates)
        if self.config.global_every and self._rounds % self.config.global_every == 0:
            taken = {*closed, *(candidate.genes for candidate in chosen)}
            if (other := might_be_best(model, self._pool, taken, rng)) is not None:
                chosen[-1] = other
        return chosen

    def _model(self, more: Sequence[Trial] = ()) -> SearchModel:
        """The model of all trials, and more; without more, its hyperparameters are kept for the next."""
        trials = [*self._trials, *more]
        coordinates = [self._pool.coordinates(trial.genes) for trial in trials]
        model = SearchModel.of(trials, coordinates, self._problem, self._pool.system, self._fitted)
        if not more:
            self._fitted = model.fitted
        return model

    def _tried(self) -> Located:
        """The candidates that could be evaluated."""
        return self._pool.at(trial.genes for trial in self._trials if not trial.failed)

    def _left(self) -> Located:
        """Candidates that may be asked; none only where there are no others."""
        closed = self._closed()
        left = self._pool.everywhere.without(closed)
        return left if len(left) else self._pool.others(self._generator(_REFILLING)).without(closed)

    def _closed(self) -> set[Genes]:
        """Genes of candidates that failed, or that another evaluation would tell nothing new of."""
        done = scored_episodes(self._trials, self._problem)
        episodes = 0 if self._problem is None else self._problem.episodes
        return {genes for genes, scored in done.items() if scored is None or len(scored) >= episodes}

    def _with_episodes(self, candidate: Candidate, turn: int) -> Candidate | Asked:
        """The candidate with the episodes whose turn it is."""
        count = self.config.episodes_per_candidate
        if self._problem is None or count >= self._problem.episodes:
            return candidate
        first = (len(self._trials) + turn) * count
        done = scored_episodes(self._trials, self._problem).get(candidate.genes) or set()
        return Asked(candidate, next_episodes(count, first, self._problem.episodes, self._pool.seed, done))


def _first_round(config: PhysicalGp.Config, space: DesignSpace) -> int:
    return min(config.starts, 2 * len(space.variables) + 2)
