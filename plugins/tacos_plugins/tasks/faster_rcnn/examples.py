"""Frames with what there is to detect in them, and how they are mixed for training."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.tasks.faster_rcnn.labels import Labels


@dataclass(frozen=True, eq=False)
class Example:
    """A frame to learn from or to be judged on.

    Parameters
    ----------
    image_dn
        (H, W, C) uint8 or uint16, linear [DN].
    black_level_dn, white_level_dn
        Pedestal and full scale [DN].
    labels
        What there is to detect.
    """

    image_dn: NDArray[Any]
    black_level_dn: float
    white_level_dn: float
    labels: Labels

    def mirrored(self) -> Example:
        """With left and right exchanged."""
        labels = self.labels.mirrored(self.image_dn.shape[1])
        return Example(self.image_dn[:, ::-1], self.black_level_dn, self.white_level_dn, labels)


def mixed(examples: Iterable[Example], held: int, rng: np.random.Generator) -> Iterator[Example]:
    """The examples in a shuffled order, of which no more than `held` are in memory at once.

    Consecutive frames of a walk look alike; a batch of them teaches little more than one of them.
    """
    waiting: list[Example] = []
    for example in examples:
        waiting.append(example)
        if len(waiting) == held:
            yield waiting.pop(int(rng.integers(held)))
    for index in rng.permutation(len(waiting)):
        yield waiting[int(index)]


def in_batches(examples: Iterable[Example], size: int) -> Iterator[list[Example]]:
    """Batches of `size`, the last one of what is left."""
    batch: list[Example] = []
    for example in examples:
        batch.append(example)
        if len(batch) == size:
            yield batch
            batch = []
    if batch:
        yield batch
