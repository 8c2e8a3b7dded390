"""The statistics of a capture, fixed once: each simulation of it gives the same numbers in the same order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_gap.statistics import StatisticBlock


@dataclass(frozen=True, eq=False)
class TakenStatistics:
    blocks: Sequence[StatisticBlock]  # as its real frames gave them
    kept: NDArray[np.bool_]  # (K,) which of their numbers count: those that every simulation gives, too

    @classmethod
    def of(cls, blocks: Sequence[StatisticBlock]) -> TakenStatistics:
        return cls(blocks, np.isfinite(_concatenated([block.values for block in blocks])))

    def values(self, blocks: Sequence[StatisticBlock]) -> NDArray[np.float64]:
        """(K,) the numbers of a measurement; not a number where it lacks one."""
        if [(b.statistic, len(b.values)) for b in blocks] == self._outline:
            return _concatenated([block.values for block in blocks])[self.kept]
        found = {
            (block.statistic, repr(at)): value
            for block in blocks
            for at, value in zip(block.at, block.values.tolist(), strict=True)
        }
        return np.array([found.get(key, np.nan) for key in self._keys])[self.kept]

    def finite_in(self, draws: NDArray[np.float64]) -> TakenStatistics:
        """Without the numbers that some of (B, K) simulations lack."""
        kept = self.kept.copy()
        kept[self.kept] = np.isfinite(draws).all(axis=0)
        return TakenStatistics(self.blocks, kept)

    @property
    def left_out(self) -> list[str]:
        return list(
            dict.fromkeys(name for (name, _), kept in zip(self._keys, self.kept, strict=True) if not kept)
        )

    @cached_property
    def margin(self) -> NDArray[np.float64]:
        """(K,) equivalence margins."""
        return _concatenated([np.broadcast_to(b.margin, b.values.shape) for b in self.blocks])[self.kept]

    def described(self) -> list[tuple[StatisticBlock, Mapping[str, Any]]]:
        """The block of each number, and where it was taken."""
        every = [(block, at) for block in self.blocks for at in block.at]
        return [each for each, kept in zip(every, self.kept, strict=True) if kept]

    def steadied(self, spread: NDArray[np.float64]) -> NDArray[np.float64]:
        """(K,) standard deviations from few draws, none far below the middle one of its block."""
        block = np.repeat(np.arange(len(self.blocks)), [len(b.values) for b in self.blocks])[self.kept]
        steady = spread.copy()
        for k in np.unique(block):
            part = block == k
            steady[part] = np.maximum(spread[part], 0.6 * np.median(spread[part]))
        return steady

    @cached_property
    def _outline(self) -> list[tuple[str, int]]:
        return [(block.statistic, len(block.values)) for block in self.blocks]

    @cached_property
    def _keys(self) -> list[tuple[str, str]]:
        return [(block.statistic, repr(at)) for block in self.blocks for at in block.at]


def _concatenated(parts: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    return np.concatenate([np.asarray(part, float) for part in parts]) if parts else np.zeros(0)
