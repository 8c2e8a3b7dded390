"""What blocks of scores tell about a fitness: its value, and its standard error."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.fitness import Fitness, FitnessTerm, mean_scores
from tacos_framework.study.fitness_contributions import contributions

FITNESS = Fitness((FitnessTerm("a", 1.0),))
TWO_TERMS = Fitness((FitnessTerm("a", 0.5), FitnessTerm("b", -2.0)))

numbers = st.floats(-100, 100)
blocks_of_two = st.lists(
    st.one_of(
        st.fixed_dictionaries({"a": numbers, "b": numbers}),
        st.fixed_dictionaries({"a": numbers}),
        st.fixed_dictionaries({"b": numbers}),
    ),
    min_size=1,
    max_size=12,
)


@given(blocks_of_two)
def test_the_mean_of_contributions_is_the_fitness_of_all_blocks(blocks):
    found = contributions(blocks, TWO_TERMS)
    if min(sum(name in scores for scores in blocks) for name in "ab") < 2:
        assert found is None
    else:
        assert found.mean() == pytest.approx(TWO_TERMS.value(mean_scores(blocks)), abs=1e-9)


@given(st.lists(numbers, min_size=2, max_size=8), st.integers(0, 8))
def test_a_score_of_some_blocks_has_the_standard_error_of_those(values, silent):
    blocks = [{"a": value} for value in values] + [{}] * silent
    found = contributions(blocks, FITNESS)
    expected = np.std(values, ddof=1) / math.sqrt(len(values))
    assert found.std(ddof=1) / math.sqrt(len(found)) == pytest.approx(expected, abs=1e-9)
