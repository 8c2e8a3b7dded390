"""What is taken apart and put together again is the same, down to the bits and the order in memory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tacos_plugins.kept_worlds.entry_file import Damaged, packed, unpacked
from tacos_plugins.kept_worlds.structures import CannotBeKept, put_together, taken_apart


@dataclass(frozen=True, eq=False)
class Thing:
    name: str
    content: Any


arrays = hnp.arrays(
    dtype=st.sampled_from([np.float32, np.float64, np.int32, np.uint8, np.bool_]),
    shape=hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4),
).flatmap(lambda array: st.sampled_from([array, array.T, np.asfortranarray(array)]))
plain = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text()
values = st.recursive(
    plain | arrays | st.floats(width=32, allow_nan=False).map(np.float32),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.lists(inner, max_size=3).map(tuple)
        | st.builds(Thing, st.text(max_size=5), inner)
    ),
    max_leaves=6,
)


def same(one: Any, other: Any) -> bool:
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        orders = (one.flags.c_contiguous, other.flags.c_contiguous)
        return (
            one.dtype == other.dtype and np.array_equal(one, other, equal_nan=True) and orders[0] == orders[1]
        )
    if isinstance(one, Thing):
        return one.name == other.name and same(one.content, other.content)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return bool(one == other)


@settings(max_examples=60, deadline=None)
@given(value=values)
def test_there_and_back(value: Any) -> None:
    assert same(value, put_together(*unpacked(packed(*taken_apart(value, [Thing]))), [Thing]))


def test_an_array_that_many_share_is_kept_once() -> None:
    shared = np.arange(6.0).reshape(2, 3)
    tree, kept = taken_apart([Thing("a", shared), Thing("b", shared[:]), Thing("c", shared.copy())], [Thing])
    assert len(kept) == 2
    a, b, _ = put_together(tree, kept, [Thing])
    assert a.content is b.content


class Derived(Thing):
    """Might hold what is no field."""


@pytest.mark.parametrize(
    "strange",
    [object(), {"a": 1}, np.array(["text"]), Derived("a", 1), b"bytes"],
    ids=lambda s: type(s).__name__,
)
def test_what_is_not_known_is_refused(strange: Any) -> None:
    with pytest.raises(CannotBeKept):
        taken_apart(("fine", strange), [Thing])


def test_every_flipped_bit_and_every_truncation_shows() -> None:
    data = packed(*taken_apart(Thing("a", np.arange(40, dtype=np.float32)), [Thing]))
    rng = np.random.default_rng(0)
    for place in rng.choice(len(data), 100, replace=False):
        flipped = bytearray(data)
        flipped[place] ^= 1 << rng.integers(8)
        with pytest.raises(Damaged):
            unpacked(bytes(flipped))
    for length in (0, 10, 32, 33, len(data) // 2, len(data) - 1):
        with pytest.raises(Damaged):
            unpacked(data[:length])
