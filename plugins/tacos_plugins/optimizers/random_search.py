"""Independent uniform draws."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from tacos_framework import Candidate, DesignSpace, Settings, setting
from tacos_plugins.optimizers.draws import Draws


class RandomSearch(Draws):
    """Draws every candidate afresh from the whole design space: the baseline any search must beat.

    >>> from tacos_framework.contracts import Evaluated
    >>> from tacos_framework.variables.design_space import Continuous
    >>> space = DesignSpace([Continuous("pitch_deg", -30, 30, "deg")])
    >>> config = RandomSearch.Config(evaluations=5, batch=2)
    >>> search = RandomSearch(config, space=space, rng=np.random.default_rng(1))
    >>> while not (reason := search.stop()):
    ...     candidates = search.ask()
    ...     search.tell([Evaluated(candidate, -candidate.genes[0] ** 2) for candidate in candidates])
    >>> reason
    'all 5 candidates were evaluated'
    """

    budget: ClassVar[str] = "evaluations"

    class Config(Settings):
        evaluations: int = setting(
            200, help="Candidates drawn in all.", ge=1, also=("budget", "trials", "iterations", "steps")
        )
        batch: int = setting(10, help="Candidates asked at a time; the last batch may be smaller.", ge=1)

    def __init__(self, config: Config, *, space: DesignSpace, rng: np.random.Generator) -> None:
        self.config = config
        self._space = space
        self._rng = rng
        super().__init__(evaluations=config.evaluations, batch=config.batch)

    def state(self) -> dict[str, Any]:
        """Progress, the batch in flight and the generator, as JSON values."""
        return {
            "evaluated": self._evaluated,
            "asked": [list(candidate.genes) for candidate in self._asked],
            "rng": self._rng.bit_generator.state,
        }

    def restore(self, state: dict[str, Any]) -> None:
        self._evaluated = state["evaluated"]
        self._asked = [self._space.decode(genes) for genes in state["asked"]]
        self._rng.bit_generator.state = state["rng"]
        if not self._asked:  # all were drawn that there were to be then
            self._asked = self._next()

    def _draw(self, count: int) -> list[Candidate]:
        return [self._space.sample(self._rng) for _ in range(count)]
