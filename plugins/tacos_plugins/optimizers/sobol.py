"""Scrambled Sobol points: random search that leaves no holes."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from tacos_framework import Candidate, DesignSpace, Settings, setting
from tacos_plugins.optimizers.draws import Draws
from tacos_plugins.optimizers.unit_cube import UnitCube


class Sobol(Draws):
    """Fills the design space evenly with a scrambled Sobol sequence, whatever the fitness says.

    In every coordinate and every pair of coordinates the points are spread more evenly than random ones. The
    scrambling is drawn from the seed, so that seeds give independent sequences. Balance is best where
    ``evaluations`` is a power of two.

    Sources: Sobol 1967; Owen 1998, "Scrambling Sobol' and Niederreiter-Xing points". The implementation is
    SciPy's.

    >>> from tacos_framework.variables.design_space import Continuous
    >>> space = DesignSpace([Continuous("pitch_deg", -30, 30, "deg")])
    >>> search = Sobol(Sobol.Config(evaluations=4, batch=4), space=space, rng=np.random.default_rng(1))
    >>> sorted(int(candidate.genes[0] // 15) for candidate in search.ask())
    [-2, -1, 0, 1]
    """

    class Config(Settings):
        evaluations: int = setting(
            256,
            help="Candidates drawn in all.",
            ge=1,
            le=2**30,
            also=("budget", "trials", "iterations", "steps"),
        )
        batch: int = setting(8, help="Candidates asked at a time; the last batch may be smaller.", ge=1)

    def __init__(self, config: Config, *, space: DesignSpace, rng: np.random.Generator) -> None:
        self.config = config
        self._cube = UnitCube(space)
        self._scramble(int(rng.integers(2**63)))
        super().__init__(evaluations=config.evaluations, batch=config.batch)

    def _scramble(self, scrambling: int) -> None:
        from scipy.stats import qmc  # late: checking a recipe with another search needs none

        self._scrambling = scrambling
        self._sequence = qmc.Sobol(max(self._cube.dimension, 1), seed=np.random.default_rng(scrambling))

    def state(self) -> dict[str, Any]:
        """The scrambling and how far the sequence was evaluated, as JSON values."""
        return {"scrambling": self._scrambling, "evaluated": self._evaluated}

    def restore(self, state: dict[str, Any]) -> None:
        self._scramble(state["scrambling"])
        self._begin()
        while self._evaluated < state["evaluated"]:
            self._evaluated += len(self._asked)
            self._asked = self._next()

    def _draw(self, count: int) -> list[Candidate]:
        if count == 0:
            return []
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # that the first batch is no power of two
            points = self._sequence.random(count)
        return [self._cube.candidate(point[: self._cube.dimension]) for point in points]
