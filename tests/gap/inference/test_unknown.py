"""What is left after an explanation, and when it is named."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from tacos_gap.evidence import ReplicateResiduals
from tacos_gap.inference.unknown import LARGE_REST, Unexplained, unexplained

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


@pytest.mark.parametrize("shift", [0.0, 3.0])
def test_what_shows_a_little_in_each_of_many_captures_is_significant(shift):
    rng = np.random.default_rng(1)
    labels = [
        SimpleNamespace(capture=f"bracket_{k}", statistic=name, stage="pixel")
        for k in range(90)
        for name in ("fixed_pattern", "level", "row_noise", "dark_level", "noise_tails", "line_offset")
    ]
    z = rng.standard_normal(len(labels))
    z += [shift if label.statistic == "fixed_pattern" else 0.0 for label in labels]
    replicates, scale = rng.standard_normal((12, len(labels))), np.ones(len(labels))
    problem = cast(Any, SimpleNamespace(labels=labels, null=z, scale=scale))
    left = unexplained(problem, ReplicateResiduals(z, replicates, scale))
    assert left.is_significant == (shift > 0)
