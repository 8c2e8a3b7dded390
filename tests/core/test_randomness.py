"""Generators by name: stable for ever, independent of each other and of what else was drawn."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.randomness import generator

REFERENCE = [11960509671139267664, 4744865570247769836]

PROGRAM = """
from tacos_framework.randomness import generator
print(generator(7, "noise", 3).bit_generator.random_raw(2).tolist())
"""


def test_the_stream_of_a_name_never_changes() -> None:
    raw = generator(7, "noise", 3).bit_generator.random_raw(2)
    assert raw.tolist() == REFERENCE


@pytest.mark.parametrize("hash_seed", ["0", "1"])
def test_the_stream_does_not_depend_on_the_process(hash_seed: str) -> None:
    printed = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env={"PYTHONHASHSEED": hash_seed},
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert printed.strip() == str(REFERENCE)


NAMES = st.lists(st.text(max_size=5) | st.integers(-3, 10**6), max_size=4)


@given(st.tuples(st.integers(0, 5), NAMES), st.tuples(st.integers(0, 5), NAMES))
def test_different_seeds_or_names_give_different_streams(
    one: tuple[int, list[Any]], other: tuple[int, list[Any]]
) -> None:
    same_name = one[0] == other[0] and list(map(repr, one[1])) == list(map(repr, other[1]))
    draws = [generator(seed, *names).bit_generator.random_raw(2).tolist() for seed, names in (one, other)]
    assert (draws[0] == draws[1]) == same_name


@pytest.mark.parametrize(
    ("one", "other"),
    [(("a", "b"), ("ab",)), (("a", 1), ("a", "1")), ((), ("",)), (('a", "b',), ("a", "b"))],
)
def test_names_are_not_confused(one: tuple[Any, ...], other: tuple[Any, ...]) -> None:
    assert generator(7, *one).random() != generator(7, *other).random()


def test_neighbouring_names_are_uncorrelated() -> None:
    draws = np.array([generator(7, "candidate", i).random(500) for i in range(40)])
    correlation = np.corrcoef(draws) - np.eye(40)
    assert np.abs(correlation).max() < 0.25
    assert abs(draws.mean() - 0.5) < 0.01


def test_numpy_integers_count_as_numbers() -> None:
    assert generator(7, np.int64(3)).random() == generator(7, 3).random()  # type: ignore[arg-type]


def test_a_negative_seed_is_refused() -> None:
    with pytest.raises(ValueError, match="a seed must be 0 or above, not -1"):
        generator(-1)
