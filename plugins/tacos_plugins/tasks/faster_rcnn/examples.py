"""Frames with what there is to detect in them, and how they are mixed for training."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.tasks.faster_rcnn.labels import Labels


@dataclass(frozen=True, eq=False)
class Example:
    """A frame to learn from or to be judged on."""

    image_dn: NDArray[Any]
    """(H, W, C) uint8 or uint16, linear [DN]."""
    black_level_dn: float
    white_level_dn: float
    """Pedestal and full scale [DN]."""
    labels: Labels

    def mirrored(self) -> Example:
        labels = self.labels.mirrored(self.image_dn.shape[1])
        return Example(self.image_dn[:, ::-1], self.black_level_dn, self.white_level_dn, labels)


def mixed_batches(
    examples: Iterable[Example], size: int, held: int, rng: np.random.Generator
) -> Iterator[list[Example]]:
    """Batches of `size` in a shuffled order, of which no more than `held` examples are in memory at once.

    Consecutive frames of a walk look alike; a batch of them teaches little more than one of them. Where
    cameras differ in their pixels, a batch takes images of like size, as all are padded to the largest: of
    the same octave and no more alike, or it would be of one camera.
    """
    waiting: list[Example] = []
    for example in examples:
        waiting.append(example)
        if len(waiting) == max(held, size):
            yield from _batches(waiting, size, rng)
            waiting = []
    yield from _batches(waiting, size, rng)


def _batches(examples: Sequence[Example], size: int, rng: np.random.Generator) -> Iterator[list[Example]]:
    shuffled = [examples[int(i)] for i in rng.permutation(len(examples))]
    by_size = sorted(shuffled, key=lambda example: round(math.log2(example.image_dn[..., 0].size)))
    batches = list(in_parts(by_size, size))
    for i in rng.permutation(len(batches)):
        yield batches[int(i)]


def in_parts(examples: Sequence[Example], size: int) -> Iterator[list[Example]]:
    """Runs of `size`, the last one of what is left."""
    for start in range(0, len(examples), size):
        yield list(examples[start : start + size])
