"""CMA-ES: a Gaussian that learns the shape of the landscape."""

from __future__ import annotations

import math
import warnings
from collections.abc import Collection, Iterator, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from tacos_framework import Candidate, DesignSpace, Evaluated, Settings, setting
from tacos_plugins.optimizers.observed_results import validate_results
from tacos_plugins.optimizers.restarts import Descent, Restarts
from tacos_plugins.optimizers.short_searches import spread_only
from tacos_plugins.optimizers.unit_cube import UnitCube

NARROW = 0.003
"""Standard deviation of all continuous genes, relative to their range, below which a descent is over."""

BARREN_GENERATIONS = 25
"""Generations in a row without a candidate that is new, after which the space counts as exhausted."""


class CmaEs:
    """Covariance matrix adaptation, restarted whenever it has converged, on snapped candidates.

    It begins with ``initial`` candidates spread over the space; the first descent starts at the best of them.
    Each descent draws ``population`` points around its mean, ranks them by fitness, and moves and reshapes
    its Gaussian accordingly. Candidates that failed rank last. When a descent has converged, the next one
    starts elsewhere (``restarts``).

    The strategy lives in a unit cube (one axis per gene) and learns from the points it drew, not the snapped
    ones, as is usual for mixed-integer CMA-ES. So that integers, choices and catalog parts do not stall once
    the Gaussian fits between two of them, its standard deviation along their genes never falls below
    ``margin`` times the distance to the next value. Points of a generation that snap to the same candidate
    are asked once. A candidate of an earlier generation is asked again only when it is drawn again; a study
    whose episodes stay the same answers that from its cache. Budgets count different candidates.

    Sources: Hansen 2016, "The CMA Evolution Strategy: A Tutorial"; Auger and Hansen 2005, "A restart CMA
    evolution strategy with increasing population size" (ipop); Hansen 2009, "Benchmarking a BI-population
    CMA-ES" (bipop); Hamano et al. 2022, "CMA-ES with Margin", for the lower bound on discrete genes, here in
    the simpler form of a least standard deviation. The implementation is pycma.

    >>> from tacos_framework.variables.design_space import Continuous
    >>> space = DesignSpace([Continuous("hfov_deg", 50, 120, "deg"), Continuous("baseline_m", 0.01, 3, "m")])
    >>> search = CmaEs(CmaEs.Config(evaluations=80), space=space, rng=np.random.default_rng(1))
    >>> best = -np.inf
    >>> while not (reason := search.stop()):
    ...     observed = [Evaluated(c, -abs(c.values["baseline_m"] - 1.6)) for c in search.ask()]
    ...     best = max(best, *(result.fitness for result in observed))
    ...     search.tell(observed)
    >>> reason, bool(best > -0.01)
    ('80 different candidates were evaluated', True)

    `state` keeps the fitness observed so far and the generator's first state; `restore` tells it all again,
    which takes milliseconds per generation and is exact.
    """

    class Config(Settings):
        evaluations: int = setting(
            200,
            help="Different candidates evaluated in all.",
            ge=1,
            also=("budget", "trials", "iterations", "steps"),
        )
        initial: int = setting(
            12, help="Candidates spread over the space before the first descent; 0 starts anywhere.", ge=0
        )
        population: int | None = setting(
            None, help="Points per generation; none is 4 + 3 ln(genes), rounded down, which is 8 for 5 genes."
        )
        sigma: float = setting(
            0.2, help="First standard deviation, relative to the range of each gene.", gt=0, le=1
        )
        restarts: Literal["bipop", "ipop", "none"] = setting(
            "bipop",
            help=(
                "After convergence: 'ipop' starts anywhere with twice the population, 'bipop' alternates "
                "that with small populations and small steps, 'none' stops."
            ),
        )
        margin: float = setting(
            0.5,
            help=(
                "Least standard deviation along a gene of an integer, choice or catalog, relative to the "
                "distance between its values."
            ),
            ge=0,
        )

        @model_validator(mode="after")
        def _fits_together(self) -> CmaEs.Config:
            if self.population is not None and self.population < 3:
                raise ValueError(f"a population of {self.population} cannot be ranked; give 3 or more")
            return self

    def __init__(self, config: Config, *, space: DesignSpace, rng: np.random.Generator) -> None:
        self.config = config
        self._cube = UnitCube(space)
        self._axes = max(self._cube.dimension, 2)  # pycma cannot do with one; what is left over does nothing
        self._has_continuous = bool(np.any(self._cube.spacing() == 0))
        self._rng = rng
        self._begin()

    def _begin(self) -> None:
        self._first_rng_state = self._rng.bit_generator.state
        self._observed: list[list[float | None]] = []
        self._seen: set[str] = set()
        self._barren = 0
        self._worst: float | None = None
        self._converged = False
        population = self.config.population or 4 + int(3 * math.log(self._axes))
        self._restarts = Restarts(self.config.restarts, population, self.config.sigma, self._rng)
        self._strategy: Any = None
        self._draw_initial()

    @classmethod
    def notes(cls, config: Config, space: DesignSpace) -> Iterator[str]:
        """That nothing is learnt, where all evaluations are spread over the space."""
        if config.evaluations <= config.initial:
            yield spread_only(config.evaluations, config.initial)

    @property
    def expected_candidates(self) -> int | None:
        """The evaluations; None where candidates are snapped, as repeated ones come on top."""
        return None if np.any(self._cube.spacing() > 0) else self.config.evaluations

    def ask(self) -> list[Candidate]:
        """The different candidates of the generation; the same ones until they are evaluated."""
        return list(self._asked)

    def tell(self, evaluated: Sequence[Evaluated]) -> None:
        """Take in the fitness, learn from it, and draw the next generation.

        Raises `ValueError` when a fitness is NaN or infinite, or the results are not those of the candidates
        asked.
        """
        validate_results(evaluated, self._asked)
        self._take([result.fitness for result in evaluated])

    def stop(self) -> str | None:
        """A reason once the evaluations are spent, nothing new is found, or the only descent is over."""
        if len(self._seen) >= self.config.evaluations:
            return f"{len(self._seen)} different candidates were evaluated"
        if self._barren >= BARREN_GENERATIONS:
            return f"no new candidate was found in {self._barren} generations"
        if self._converged:
            return "the search has converged, and restarts are off"
        return None

    def state(self) -> dict[str, Any]:
        """The observations so far, and the generator before the first draw, as JSON values."""
        return {
            "rng": self._first_rng_state,
            "observed": [list(fitness) for fitness in self._observed],
            "asked": [list(candidate.genes) for candidate in self._asked],
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from a `state`.

        Raises `ValueError` when telling it all again leads to other candidates, as after a change of pycma or
        settings.
        """
        self._rng.bit_generator.state = state["rng"]
        self._begin()
        for fitness in state["observed"]:
            self._take(fitness)
        if [list(candidate.genes) for candidate in self._asked] != state["asked"]:
            raise ValueError(
                "optimizer.cma-es came to other candidates than the run to resume; "
                "were settings or pycma changed?"
            )

    # one generation ---------------------------------------------------------------------------------------

    def _take(self, fitness: Sequence[float | None]) -> None:
        self._observed.append(list(fitness))
        known = dict(zip((candidate.key for candidate in self._asked), fitness, strict=True))
        self._barren = 0 if known.keys() - self._seen else self._barren + 1
        self._seen |= known.keys()
        finite = [value for value in fitness if value is not None]
        self._worst = min([*finite, *([] if self._worst is None else [self._worst])], default=None)
        if self.stop() is not None:
            return  # a last generation may be cut short, and there is nothing left to learn for
        drawn = [known[candidate.key] for candidate in self._drawn]
        if self._strategy is None:
            self._restart(self._best_point(drawn))
        elif not finite:
            self._restart(None)  # nothing to rank: look elsewhere
        else:
            self._learn(drawn)
        if self.stop() is None:
            self._draw()

    def _best_point(self, drawn: Sequence[float | None]) -> NDArray[np.float64] | None:
        scored = [(value, -i) for i, value in enumerate(drawn) if value is not None]
        return self._points[-max(scored)[1]] if scored else None

    def _learn(self, drawn: Sequence[float | None]) -> None:
        assert self._worst is not None
        # pycma minimises; what failed ranks behind everything, whatever the fitness is measured in
        losses = [-self._worst + 1.0 + abs(self._worst) if value is None else -value for value in drawn]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # pycma warns of flat fitness, which snapping makes common
            self._strategy.tell(self._points, losses)
            over = bool(self._strategy.stop()) or self._is_narrow()
        if over and not self._restarts.again:
            self._converged = True
        elif over:
            self._restart(None)

    def _is_narrow(self) -> bool:
        """True if going on finds nothing else: genes at their margin or at a point, or nothing new."""
        if not self._has_continuous:
            return self._barren >= BARREN_GENERATIONS // 5
        widths = self._strategy.stds[: self._cube.dimension]
        least = self._least_width()[: self._cube.dimension]
        return bool(np.all(widths <= np.maximum(NARROW, 1.5 * least)))

    def _least_width(self) -> NDArray[np.float64]:
        """(axes,) least standard deviations; none for axes without a gene."""
        widths = np.zeros(self._axes)
        widths[: self._cube.dimension] = self.config.margin * self._cube.spacing()
        return widths

    # drawing ----------------------------------------------------------------------------------------------

    def _draw_initial(self) -> None:
        count = min(self.config.initial, self.config.evaluations)
        if count:
            self._choose(_spread(count, self._axes, self._rng))
        else:
            self._restart(None)
            self._draw()

    def _restart(self, start: NDArray[np.float64] | None) -> None:
        """Begin the next descent, anywhere unless `start` says where."""
        import cma

        descent: Descent = self._restarts.next(len(self._seen))
        start = self._rng.random(self._axes) if start is None else start
        options = {
            "bounds": [0.0, 1.0],
            "popsize": descent.population,
            "minstd": self._least_width(),
            "randn": lambda *shape: self._rng.standard_normal(shape),
            "seed": np.nan,  # touch no global generator
            "verbose": -9,
            "verb_log": 0,
            "verb_disp": 0,
            "CMA_diagonal": False,
        }
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self._strategy = cma.CMAEvolutionStrategy(start, descent.sigma, options)

    def _draw(self) -> None:
        self._choose([np.asarray(point) for point in self._strategy.ask()])

    def _choose(self, points: list[NDArray[np.float64]]) -> None:
        self._points = points
        self._drawn = [self._cube.candidate(point[: self._cube.dimension]) for point in points]
        self._asked = self._affordable(dict.fromkeys(self._drawn))

    def _affordable(self, candidates: Collection[Candidate]) -> list[Candidate]:
        """Those that were seen before, and of the others as many as the evaluations still allow."""
        left = self.config.evaluations - len(self._seen)
        new = [candidate for candidate in candidates if candidate.key not in self._seen]
        too_many = {candidate.key for candidate in new[left:]}
        return [candidate for candidate in candidates if candidate.key not in too_many]


def _spread(count: int, dimension: int, rng: np.random.Generator) -> list[NDArray[np.float64]]:
    """Points of a Latin hypercube: each range cut into `count` parts, one point in every part."""
    parts = np.array([rng.permutation(count) for _ in range(dimension)]).T
    return list((parts + rng.random((count, dimension))) / count)
