"""Design spaces in steps, as optimizers are compared on: what is nearest, what is a neighbour."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tacos_framework.variables.design_space import Categorical, Continuous, DesignSpace, Integer
from tacos_validation.optimizers_compared.grid import Stepped, coarse_grid, neighbours, on_grid


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.integers(-100, 100), st.integers(1, 500), st.integers(1, 300), st.floats(0, 1))
def test_what_is_decoded_is_the_nearest_step(lower, tenths, step_tenths, share):
    variable = Stepped("x", lower, lower + tenths / 10, step=step_tenths / 10)
    asked_for = lower + share * tenths / 10
    value, genes = variable.decode((asked_for,))
    nearest = min(variable.points, key=lambda point: abs(point - asked_for))
    assert abs(value - asked_for) == pytest.approx(abs(nearest - asked_for), abs=1e-8)
    assert variable.decode(genes) == (value, genes)
    assert value in variable.points


def test_what_lies_between_two_steps_cannot_be_had():
    with pytest.raises(ValueError, match="in steps of 2"):
        Stepped("x", 0, 10, step=2).encode(3.0)


SPACE = on_grid(
    DesignSpace([Continuous("x", 0, 10), Categorical("lens", ("wide", "tele")), Integer("n", 1, 3)]), {"x": 2}
)


def test_the_coarse_grid_is_part_of_the_fine_one():
    coarse = list(coarse_grid(SPACE, {"x": 4}))
    assert len(coarse) == 3 * 2 * 3
    assert {each.values["x"] for each in coarse} == {0, 4, 8}
    assert all(SPACE.decode(each.genes) == each for each in coarse)


def test_neighbours_are_one_stride_away_and_inside():
    start = SPACE.decode([0, 0, 2])
    assert [each.as_dict() for each in neighbours(SPACE, start, {"x": 1})] == [
        {"x": 2.0, "lens": "wide", "n": 2}
    ]
