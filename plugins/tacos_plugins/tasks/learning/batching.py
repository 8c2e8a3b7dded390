"""Batches of examples for training."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TypeVar

import numpy as np

Example = TypeVar("Example")


def mixed(examples: Iterable[Example], held: int, rng: np.random.Generator) -> Iterator[Example]:
    """The examples in a shuffled order, of which no more than `held` are in memory at once.

    Consecutive frames of a trip look alike; a batch of them teaches little more than one of them.

    >>> list(mixed("abcdef", 3, np.random.default_rng(1)))
    ['b', 'c', 'e', 'f', 'a', 'd']
    """
    waiting: list[Example] = []
    for example in examples:
        waiting.append(example)
        if len(waiting) == held:
            yield waiting.pop(int(rng.integers(held)))
    for index in rng.permutation(len(waiting)):
        yield waiting[int(index)]


def in_batches(examples: Iterable[Example], size: int) -> Iterator[list[Example]]:
    """Batches of `size`, the last one of what is left.

    >>> list(in_batches("abcde", 2))
    [['a', 'b'], ['c', 'd'], ['e']]
    """
    batch: list[Example] = []
    for example in examples:
        batch.append(example)
        if len(batch) == size:
            yield batch
            batch = []
    if batch:
        yield batch
