"""What is left after an explanation, and when it is named."""

from __future__ import annotations

import pytest

from tacos_gap.inference.unknown import LARGE_REST, Unexplained

HARDLY_ANY = Unexplained(0.0, 0.01, 1.4, 0.002, None, worst="level")
"""A five-hundredth of a very large gap."""


@pytest.mark.parametrize(("after", "where"), [(1.0, None), (LARGE_REST[0], None), (7.5, "level")])
def test_a_rest_of_many_noise_floors_is_named_however_much_was_explained(after, where):
    left = HARDLY_ANY.beside(after)
    assert left.where == where
    assert (left.score >= 0.5) == (where is not None)


def test_a_small_rest_takes_nothing_from_what_is_unknown_anyway():
    unknown = Unexplained(0.8, 0.01, 1.4, 0.08, "detail", worst="detail")
    assert unknown.beside(1.0) == unknown
