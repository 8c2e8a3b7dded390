"""The rest after the best explanation, against how far the simulator differs from itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from tacos_gap.evidence import ReplicateResiduals
from tacos_gap.inference.problem import LEAST_FLOOR, Problem, floor_rms
from tacos_gap.inference.significance import BlockTest, block_test, discoveries

TOLERATED = 0.02
CERTAIN = 0.1
"""Shares of the squared gap left: up to the first nothing is unknown, from the second on something certainly
is."""

LARGE_REST = (2.5, 5.0)
"""What is left [noise floor]: up to the first nothing need be said of it, from the second on something is
named as left, however large a share of a very large gap was explained."""

MOST_OF_ONE = 0.9
"""Share of the squared gap that one statistic counts for at most where others differ, too: one that hardly
varies, as of darks without a pedestal, says little of what else there is."""

SIGNIFICANT = 0.05
"""p-value of the most extreme statistic below which something is left."""

NAMED = 0.1
"""Score above which the statistic that holds most of what is left is named."""

_TESTS = 2
"""Of blocks, and of statistics over all captures: the p-value of one is multiplied for the other."""

SLACK = 1.25
"""What a right model of a real camera may leave: its formulas are not the camera's own [noise floor]."""

IN_PART = 2.0
"""A stage or capture alone may leave larger shares of its gap: it is one of many, and smaller."""


@dataclass(frozen=True)
class Unexplained:
    """The rest that no effect explains."""

    score: float
    """From 0 to 1, that an effect outside the catalogue is at work: no probability, but a ramp between the
    shares `TOLERATED` and `CERTAIN` of the gap."""
    p_value: float  # that the simulator differs from itself as much anywhere
    gap: float  # what is left [noise floor]
    share: float  # what is left of the squared gap above the noise floor, over what there was
    where: str | None  # statistic that holds most of it; None where nothing is left
    by_stage: Mapping[str, float] = field(default_factory=dict)
    """The score for the statistics of a stage alone."""
    by_capture: Mapping[str, float] = field(default_factory=dict)  # the score for those of a capture
    negligible: bool = False
    """Whether all blocks that differ significantly lie within the noise floor: equivalence margins are part
    of it, and a steady simulator makes differences within them significant."""
    worst: str | None = None  # statistic that holds most of what differs, however little; None of no evidence

    @property
    def is_significant(self) -> bool:
        return self.p_value < SIGNIFICANT and not self.negligible

    def beside(self, after: float) -> Unexplained:
        """With a rest of so many noise floors named where that is large by itself.

        It keeps an answer from being called whole, and takes nothing from effects that explain most of a gap.
        """
        score = max(self.score, round(_on_ramp(after, *LARGE_REST), 3))
        return replace(self, score=score, where=self.worst if score > NAMED else None)


def unexplained(problem: Problem, residuals: ReplicateResiduals) -> Unexplained:
    """Test residuals against the noise floor of the hypothesis they are left by.

    The most extreme of all blocks (a capture and a statistic) decides, so that an effect that shows in one
    place only is seen; or the most extreme statistic over all captures, as of hundreds of blocks some differ
    by luck as much as an effect that all captures share differs in each.
    """
    z = residuals.z
    # what there was, too, in units of the hypothesis: a noisier one must not seem to explain by that alone
    null = problem.null * problem.scale / residuals.scale
    size = floor_rms(residuals.replicates)
    blocks, names = block_index(problem), block_names(problem)
    test = block_test(z, residuals.replicates, blocks, SLACK)
    over_captures, statistic = _over_captures(z, residuals.replicates, problem)
    p_value = min(test.family_p_value(), _TESTS * over_captures.family_p_value(), 1.0)
    share = _share_left(z, null, residuals.replicates, blocks, names)
    score = _doubt(share) * (1 - p_value) if p_value < SIGNIFICANT else 0.0
    own = np.bincount(blocks, z**2, len(names))
    worst = int(np.argmax(own)) if len(own) else 0
    stages = {block: label.stage for block, label in zip(blocks.tolist(), problem.labels, strict=True)}
    part = _PartwiseDoubt(z, null, residuals.replicates, blocks, test)
    return Unexplained(
        round(score, 3),
        p_value,
        _rms(z) / size,
        round(share, 4),
        names[worst][1] if score > NAMED else None,
        part.by([stages[k] for k in range(len(names))]),
        part.by([capture for capture, _ in names]),
        negligible=not (
            _matters(test, z, blocks, SIGNIFICANT)
            or _matters(over_captures, z, statistic, SIGNIFICANT / _TESTS)
        ),
        worst=names[worst][1] if names else None,
    )


def _over_captures(
    z: NDArray[np.float64], replicates: NDArray[np.float64], problem: Problem
) -> tuple[BlockTest, NDArray[np.int64]]:
    """The test of each statistic over all captures, and (K,) which statistic each number is of."""
    order: dict[str, int] = {}
    index = np.array(
        [order.setdefault(label.statistic, len(order)) for label in problem.labels], dtype=np.int64
    )
    return block_test(z, replicates, index, SLACK), index


def _matters(test: BlockTest, z: NDArray[np.float64], blocks: NDArray[np.int64], p_value: float) -> bool:
    """True if any block is significant and beyond the noise floor."""
    significant = test.p_values <= test.least_p_value(p_value)
    return bool(np.any(significant & (np.bincount(blocks, z**2) > np.bincount(blocks))))


def doubt_beside(problem: Problem, with_it: NDArray[np.float64], without: NDArray[np.float64]) -> float:
    """From 0 to 1: how much of what there is without one effect is left with it, on the ramp of the score.

    Of clipped frames saturation explains all but a five-hundredth. That vouches for no other effect, which is
    held against that rest alone.

    `with_it`, `without`: (K,) residuals of an explanation with the effect and without it [noise floor].
    """
    blocks, names = block_index(problem), block_names(problem)
    return _doubt(_share_left(with_it, without, problem.null_replicates, blocks, names))


def _share_left(
    z: NDArray[np.float64],
    before: NDArray[np.float64],
    replicates: NDArray[np.float64],
    blocks: NDArray[np.int64],
    names: Sequence[tuple[str, str]],
) -> float:
    """Share of the squared gap before that (K,) residuals leave; 0 where there was none to speak of."""
    size = floor_rms(replicates)
    if not z.size or _rms(before) / size <= SLACK:
        return 0.0
    counted = _weights(before, replicates, blocks, names)[blocks]
    left = float(np.sum(counted * (z**2 - (SLACK * size) ** 2)))
    there = float(np.sum(counted * (before**2 - size**2)))
    return max(left, 0.0) / max(there, 1e-9)


@dataclass(frozen=True, eq=False)
class _PartwiseDoubt:
    """Score that something unknown shows in a part of the numbers."""

    z: NDArray[np.float64]
    null: NDArray[np.float64]
    replicates: NDArray[np.float64]
    blocks: NDArray[np.int64]
    test: BlockTest

    def by(self, part_of_block: Sequence[str]) -> dict[str, float]:
        """The score for each part, from the name of the part that each block belongs to."""
        significant = discoveries(self.test.p_values, SIGNIFICANT)
        found = {}
        for part in dict.fromkeys(part_of_block):
            members = np.array([name == part for name in part_of_block])
            p_value = self.test.family_p_value(members)
            inside = members[self.blocks]
            left = self._excess(self.z, inside & significant[self.blocks], inside, SLACK)
            before = self._excess(self.null, inside, inside, 1.0)
            doubt = _doubt(left / max(before, 1e-9) / IN_PART) if left else 0.0
            found[part] = round(doubt * (1 - p_value), 3)
        return found

    def _excess(
        self, z: NDArray[np.float64], counted: NDArray[np.bool_], inside: NDArray[np.bool_], slack: float
    ) -> float:
        """Squares above the noise floor of the numbers `counted`, over how many are `inside`."""
        floor = np.maximum((self.replicates**2).mean(axis=0), LEAST_FLOOR**2)
        above = float(np.sum((z**2 - slack**2 * floor)[counted]))
        return max(above, 0.0) / max(int(inside.sum()), 1)


def _doubt(share: float) -> float:
    return _on_ramp(share, TOLERATED, CERTAIN)


def _on_ramp(value: float, low: float, high: float) -> float:
    return float(np.clip((value - low) / (high - low), 0.0, 1.0))


def _rms(z: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(z**2)))


def _weights(
    null: NDArray[np.float64],
    replicates: NDArray[np.float64],
    blocks: NDArray[np.int64],
    names: Sequence[tuple[str, str]],
) -> NDArray[np.float64]:
    """(M,) what squares of each block count, so that no statistic has more than `MOST_OF_ONE` of the gap.

    Of the others only those weigh against it that differ significantly.
    """
    sizes = np.bincount(blocks, minlength=len(names))
    own = np.bincount(blocks, null**2, len(names))
    found = discoveries(block_test(null, replicates, blocks, SLACK).p_values, SIGNIFICANT)
    above = np.where(found, np.maximum(own - SLACK**2 * sizes, 0.0), 0.0)
    statistics = [statistic for _, statistic in names]
    order = {name: k for k, name in enumerate(dict.fromkeys(statistics))}
    index = np.array([order[name] for name in statistics], np.int64)
    by_statistic = np.bincount(index, above, len(order))
    weights = np.ones(len(order))
    if len(order):
        top = int(np.argmax(by_statistic))
        others = float(by_statistic.sum() - by_statistic[top]) * MOST_OF_ONE / (1 - MOST_OF_ONE)
        if 0 < others < by_statistic[top]:
            weights[top] = others / by_statistic[top]
    return weights[index]


def block_names(problem: Problem) -> list[tuple[str, str]]:
    return list(dict.fromkeys((label.capture, label.statistic) for label in problem.labels))


def block_index(problem: Problem) -> NDArray[np.int64]:
    """(K,) the block of each number."""
    order = {name: i for i, name in enumerate(block_names(problem))}
    return np.array([order[label.capture, label.statistic] for label in problem.labels], np.int64)
