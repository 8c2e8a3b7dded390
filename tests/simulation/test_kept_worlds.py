"""Worlds are kept within a bound of memory, those used last."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.cache import LRUCache
from tacos_worlds.indoor.scene import IndoorScene


@given(sizes=st.lists(st.integers(1, 40), min_size=1, max_size=30), most=st.integers(10, 60))
def test_what_is_kept_fits_unless_it_is_one_thing_that_is_too_large(sizes, most):
    held: dict[int, int] = {}
    kept: LRUCache[tuple[int, int]] = LRUCache(
        5, most, bytes_of=lambda thing: thing[1], let_go=lambda thing: held.pop(thing[0])
    )
    for number, size in enumerate(sizes):
        held[number] = size
        assert kept.get(number, lambda thing=(number, size): thing) == (number, size)
        assert len(held) <= 5
        others = sum(held.values()) - size  # what was there before, and had room for one of its own size
        assert others == 0 or others + max(s for n, s in held.items() if n != number) <= most


def test_what_is_used_stays():
    kept: LRUCache[int] = LRUCache(2)
    for number in (1, 2, 1, 3):
        kept.get(number, lambda number=number: number)
    assert kept.get(1, lambda: -1) == 1
    assert kept.get(2, lambda: -2) == -2


def test_a_world_says_what_memory_it_takes():
    scene = IndoorScene(IndoorScene.Config(size_m=(5, 5), frames=1))
    world = scene.episode(rng=np.random.default_rng(3), illumination_lux=20.0).world
    arrays: dict[int, np.ndarray] = {}
    collect(world, arrays)
    assert abs(world.nbytes / sum(array.nbytes for array in arrays.values()) - 1) < 0.01


def collect(thing: Any, arrays: dict[int, np.ndarray]) -> None:
    if isinstance(thing, np.ndarray):
        arrays[id(thing)] = thing
    elif is_dataclass(thing):
        for each in fields(thing):
            collect(getattr(thing, each.name), arrays)
    elif isinstance(thing, tuple):
        for each in thing:
            collect(each, arrays)
