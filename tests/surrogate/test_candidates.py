"""Candidates that keep all constraints."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_framework.catalog import find_catalog
from tacos_framework.variables.design_space import (
    CatalogChoice,
    Categorical,
    Continuous,
    DesignSpace,
    Integer,
)
from tacos_plugins.surrogate.candidates import FeasibleCandidates, bare_coordinates
from tacos_plugins.surrogate.warp import Warp

SENSORS = CatalogChoice("sensor", find_catalog("image_sensors"))
SPACE = DesignSpace(
    [Continuous("focal_length_mm", 1, 20, "mm"), SENSORS, Categorical("lens", ("wide", "normal", "tele"))]
)


def feasible(space=SPACE, coordinates=None, broken=lambda _: {}) -> FeasibleCandidates:
    return FeasibleCandidates(space, coordinates or (lambda c: bare_coordinates(space, c)), broken)


def test_every_combination_of_parts_and_choices_is_there():
    pool = feasible().pool(10, np.random.default_rng(1))
    found = {(p.candidate.values["sensor"].name, p.candidate.values["lens"]) for p in pool}
    assert len(found) == len(SENSORS.rows) * 3


def test_of_too_many_combinations_each_value_comes_as_often_as_any():
    space = DesignSpace([Integer(name, 1, 10) for name in "abc"])
    pool = feasible(space).pool(200, np.random.default_rng(1))
    for name in "abc":
        counts = np.bincount([p.candidate.values[name] for p in pool])[1:]
        assert counts.min() >= 8, "20 of 200, give or take"


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 2**32), most=st.floats(1.5, 20))
def test_none_breaks_a_constraint_and_each_is_there_once(seed, most):
    found = feasible(broken=lambda c: {"f": 1.0} if c.values["focal_length_mm"] > most else {})
    rng = np.random.default_rng(seed)
    pool = found.pool(150, rng)
    near = found.around([pool[0].candidate, pool[-1].candidate], 20, 0.1, rng)
    for placed in (pool, near):
        assert placed
        assert all(p.candidate.values["focal_length_mm"] <= most for p in placed)
        assert len({p.candidate for p in placed}) == len(placed)


def test_where_few_combinations_can_be_had_there_are_more_candidates_of_each():
    only = SENSORS.rows[3].name
    found = feasible(broken=lambda c: {} if c.values["sensor"].name == only else {"mount": 1.0})
    pool = found.pool(200, np.random.default_rng(1))
    assert 100 < len(pool) <= 210


def test_where_nothing_is_allowed_there_is_nothing_and_the_reason_has_a_name():
    nothing = feasible(broken=lambda _: {"mass_g": 2.0})
    assert nothing.pool(50, np.random.default_rng(1)) == []
    assert nothing.most_broken(20, np.random.default_rng(1)) == "mass_g"
    assert feasible().most_broken(20, np.random.default_rng(1)) is None


def test_numbers_are_drawn_so_that_coordinates_come_evenly():
    """A field of view falls with one over the focal length: most focal lengths see about the same."""
    space = DesignSpace([Continuous("focal_length_mm", 1, 20, "mm")])
    found = feasible(space, lambda c: {"fov_deg": np.degrees(2 * np.arctan(3 / c.genes[0]))})
    fovs_deg = [p.coordinates["fov_deg"] for p in found.pool(200, np.random.default_rng(1))]
    shares, _ = np.histogram(fovs_deg, bins=5)
    assert shares.min() > 25


@settings(deadline=None)
@given(
    steps=st.lists(st.none() | st.floats(-1e3, 1e3), min_size=3, max_size=9),
    place=st.floats(0, 1),
)
def test_a_warp_can_be_undone_whatever_it_was_made_from(steps, place):
    genes = np.linspace(2.0, 5.0, len(steps))
    warp = Warp.of_sweep(genes, [None if step is None else {"x": step} for step in steps])
    assert warp.gene(0.0) == 2.0
    assert warp.gene(1.0) == 5.0
    assert warp.gene(warp.place(warp.gene(place))) == pytest.approx(warp.gene(place))


def test_neighbours_are_near_and_now_and_then_of_another_part():
    found, rng = feasible(), np.random.default_rng(1)
    centre = SPACE.decode(found.pool(1, rng)[0].candidate.genes)
    near = found.around([centre], 200, 0.02, rng)
    own = [p for p in near if p.candidate.values["sensor"] == centre.values["sensor"]]
    assert 0.6 < len(own) / len(near) < 0.99
    places = [p.candidate.values["focal_length_mm"] - centre.values["focal_length_mm"] for p in own]
    assert np.abs(places).max() < 2


def test_a_number_of_many_values_is_drawn_from_its_range():
    space = DesignSpace([Integer("n", 0, 10**6)])
    pool = feasible(space).pool(64, np.random.default_rng(1))
    assert np.ptp([p.candidate.values["n"] for p in pool]) > 9e5


def test_bare_coordinates_have_a_number_for_each_value_of_a_choice():
    candidate = SPACE.decode([5.0, *SENSORS.encode(SENSORS.rows[0]), 1.0])
    found = bare_coordinates(SPACE, candidate)
    assert found["focal_length_mm"] == 5.0
    assert (found["lens=wide"], found["lens=normal"], found["lens=tele"]) == (0.0, 1.0, 0.0)
    assert found["sensor.pixel_um"] == SENSORS.rows[0].number("pixel_um")
