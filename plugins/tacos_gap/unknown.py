"""Whether what is left after the best explanation is more than the simulator differs from itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_gap.evidence import ReplicateResiduals
from tacos_gap.problem import Problem, floor_rms, robust

TOLERATED = 0.05
CERTAIN = 0.15
"""Shares of the gap left: up to the first nothing is unknown, from the second on something certainly is."""

SIGNIFICANT = 0.06
"""p-value below which something is left: no replicate of a hypothesis, of sixteen, is as extreme."""

SLACK = 1.25
"""What a right model of a real camera may leave: its formulas are not the camera's own [noise floor]."""


@dataclass(frozen=True)
class Unexplained:
    """What is left.

    Parameters
    ----------
    probability
        Of an effect outside the catalogue.
    p_value
        Conformal: the share of the simulator's own replicates as extreme.
    gap
        What is left [noise floor].
    share
        What is left above the noise floor, over what there was.
    where
        Statistic that holds most of it; None where nothing is left.
    """

    probability: float
    p_value: float
    gap: float
    share: float
    where: str | None

    @property
    def is_significant(self) -> bool:
        """Whether anything is left to explain."""
        return self.p_value < SIGNIFICANT


def unexplained(problem: Problem, residuals: ReplicateResiduals) -> Unexplained:
    """Test residuals against the noise floor of the hypothesis they are left by.

    The statistic is the largest over blocks (a capture and a statistic) of their mean squared residual, each
    over its largest among the replicates' quantiles, so that an effect that shows in one place only is seen.
    """
    z = residuals.z
    # what there was, too, in units of the hypothesis: a noisier one must not seem to explain by that alone
    null = problem.null * problem.scale / residuals.scale
    size = floor_rms(residuals.replicates)
    gap, before = _rms(z) / size, _rms(null) / size
    blocks = block_index(problem)
    sizes = np.bincount(blocks)
    own = np.bincount(blocks, robust(z) ** 2) / sizes
    floor = np.stack([np.bincount(blocks, robust(f) ** 2) / sizes for f in residuals.replicates])
    typical = floor.mean(axis=0) + 2 * floor.std(axis=0) + 0.5
    largest = float((own / typical).max()) if len(own) else 0.0
    replicates = (floor / typical).max(axis=1)
    p_value = float((1 + np.sum(replicates >= largest / SLACK**2)) / (1 + len(replicates)))
    share = max(gap - SLACK, 0.0) / max(before - 1.0, 1e-9) if before > SLACK else 0.0
    doubt = float(np.clip((share - TOLERATED) / (CERTAIN - TOLERATED), 0.0, 1.0))
    probability = doubt * (1 - p_value) if p_value < SIGNIFICANT else 0.0
    worst = int(np.argmax(own * sizes)) if len(own) else 0
    where = block_names(problem)[worst][1] if probability > 0.1 else None
    return Unexplained(round(probability, 3), p_value, gap, round(share, 4), where)


def _rms(z: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(robust(z) ** 2)))


def block_names(problem: Problem) -> list[tuple[str, str]]:
    """Capture and statistic of each block."""
    return list(dict.fromkeys((label.capture, label.statistic) for label in problem.labels))


def block_index(problem: Problem) -> NDArray[np.int64]:
    """(K,) the block of each number."""
    order = {name: i for i, name in enumerate(block_names(problem))}
    return np.array([order[label.capture, label.statistic] for label in problem.labels], np.int64)
