"""Environment of the policy: cameras that are changed step by step, as points of a unit cube."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


class Designers:
    """Cameras side by side, each changed a number of times and then begun anew.

    - `steps`: changes of one camera before the next one begins.
    - `step_size`: how far an action of 1 moves a gene, relative to its range [1].
    - `rng`: draws where cameras begin.
    """

    def __init__(
        self, count: int, dimension: int, steps: int, step_size: float, rng: np.random.Generator
    ) -> None:
        self._steps = steps
        self._step_size = step_size
        self._rng = rng
        self.points = rng.random((count, dimension))
        self.step = 0

    def observe(self, points: NDArray[np.float64] | None = None) -> NDArray[np.float32]:
        """(count, genes) what the policy sees of the cameras as they are, or at other points: -1..1."""
        return (2 * (self.points if points is None else points) - 1).astype(np.float32)

    def moved(self, actions: NDArray[np.float32]) -> NDArray[np.float64]:
        """(count, genes) points after (count, genes) actions in -1..1; beyond the cube there is nothing."""
        return np.clip(self.points + self._step_size * np.clip(actions, -1, 1).astype(np.float64), 0, 1)

    def advance(self, points: NDArray[np.float64]) -> bool:
        """Go to points; True where that ends the cameras' time and new ones have begun."""
        self.step += 1
        over = self.step == self._steps
        if over:
            self.step = 0
        self.points = self._rng.random(points.shape) if over else points
        return over

    def state(self) -> dict[str, Any]:
        """As JSON values, the generator left out."""
        return {"points": self.points.tolist(), "step": self.step}

    def restore(self, state: dict[str, Any]) -> None:
        self.points = np.array(state["points"])
        self.step = state["step"]


class RewardScale:
    """Running mean and spread of what was observed, so that rewards are of the order of one.

    Welford's update; see Knuth, The Art of Computer Programming, vol. 2, 4.2.2.

    >>> scale = RewardScale()
    >>> for fitness in (1.0, 2.0, 3.0):
    ...     scale.learn(fitness)
    >>> round(scale.scaled(3.0), 3), scale.worst
    (1.0, 1.0)
    """

    _MOST = 10.0  # as usual where rewards are normalised; an outlier must not undo what was learnt

    def __init__(self) -> None:
        self.count, self.mean, self.squares = 0, 0.0, 0.0
        self.worst: float | None = None

    def learn(self, fitness: float) -> None:
        self.count += 1
        away = fitness - self.mean
        self.mean += away / self.count
        self.squares += away * (fitness - self.mean)
        self.worst = fitness if self.worst is None else min(self.worst, fitness)

    @property
    def spread(self) -> float:
        """Standard deviation; 1 while there is none."""
        variance = self.squares / (self.count - 1) if self.count > 1 else 0.0
        return float(np.sqrt(variance)) or 1.0

    def scaled(self, fitness: float) -> float:
        return float(np.clip((fitness - self.mean) / self.spread, -self._MOST, self._MOST))

    def state(self) -> dict[str, Any]:
        return {"count": self.count, "mean": self.mean, "squares": self.squares, "worst": self.worst}

    def restore(self, state: dict[str, Any]) -> None:
        self.count, self.mean, self.squares = state["count"], state["mean"], state["squares"]
        self.worst = state["worst"]
