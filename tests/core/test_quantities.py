"""Constraints in sentences and amounts, on numbers, words and what nobody knows; objectives."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.quantities import Breach, Constraint, quantity

CAMERA = {
    "focal_length_mm": 3.6,
    "sensor": {"name": "S", "power_w": 2.5, "shutter": "global", "mass_g": None},
}
DERIVED = {"hfov_deg": 80.0}


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("hfov_deg", 80.0),
        ("sensor.power_w", 2.5),
        ("sensor.shutter", "global"),
        ("sensor.mass_g", None),
        ("sensor.price_eur", None),
        ("lens.mount", None),
        ("focal_length_mm.mount", None),
        ("vfov_deg", None),
        ("features.inliers", 120.0),
        ("fitness", 1.5),
    ],
)
def test_a_quantity_is_found_by_its_name(name: str, value: Any) -> None:
    assert quantity(name, CAMERA, DERIVED, {"features.inliers": 120.0, "fitness": 1.5}) == value


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Constraint("hfov_deg"), "the constraint on hfov_deg has no bound"),
        (lambda: Constraint("hfov_deg", 9, 1), "the constraint on hfov_deg has min 9 above max 1"),
    ],
)
def test_what_makes_no_sense_is_refused(build: Any, message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}$"):
        build()


@pytest.mark.parametrize(
    ("value", "breach"),
    [
        (100.0, None),
        (140.0, None),
        (40.0, None),
        (140.5, Breach("hfov_deg", 0.5, "hfov_deg is 140.5, above the largest allowed value 140")),
        (12.0, Breach("hfov_deg", 28.0, "hfov_deg is 12, below the smallest allowed value 40")),
        (None, None),
    ],
)
def test_a_broken_constraint_says_by_how_much(value: float | None, breach: Breach | None) -> None:
    assert Constraint("hfov_deg", min=40, max=140).breach(value) == breach


finite = st.floats(-1e6, 1e6)


@given(value=finite, low=finite, high=finite)
def test_what_is_broken_is_mended_by_its_amount(value: float, low: float, high: float) -> None:
    low, high = min(low, high), max(low, high)
    constraint = Constraint("x", min=low, max=high)
    breach = constraint.breach(value)
    assert (breach is None) == (low <= value <= high)
    if breach is not None:
        assert breach.amount > 0
        mended = value + breach.amount if value < low else value - breach.amount
        assert mended == pytest.approx(low if value < low else high, rel=1e-9, abs=1e-6)


def test_a_quantity_may_be_wanted_at_one_value() -> None:
    assert Constraint("cameras", min=2, max=2).breach(2.0) is None


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_what_is_no_number_breaks_a_bound_by_a_finite_amount(value: float) -> None:
    breach = Constraint("hfov_deg", max=140).breach(value)
    assert breach is not None
    assert breach.amount == 1.0
    assert Constraint("hfov_deg", max=140).breach(-math.inf) is None


@pytest.mark.parametrize(
    ("value", "kept"), [("C", True), ("C, CS", True), ("CS, M12", False), ("M12", False), ("c", False)]
)
def test_a_text_that_lists_several_words_is_each_of_them(value: str, kept: bool) -> None:
    breach = Constraint("lens.mount", any_of=("C", "F")).breach(value, "L")
    assert (breach is None) == kept
    if breach is not None:
        assert breach.sentence == f"lens.mount of L is {value}, not C or F"


def test_what_nobody_states_is_allowed_or_refused() -> None:
    assert Constraint("sensor.mass_g", max=3).breach(None, "S") is None
    breach = Constraint("sensor.mass_g", max=3, unknown="refuse").breach(None, "S")
    assert breach == Breach(
        "sensor.mass_g", 1.0, "sensor.mass_g of S is unknown, which the constraint refuses", known=False
    )


def test_a_constraint_without_a_recipe_says_why_it_is_there() -> None:
    breach = Constraint("margin_mm", min=0, because="light must fall on it").breach(-1.0)
    assert breach is not None
    assert breach.sentence.endswith("below the smallest allowed value 0 (light must fall on it)")


def test_a_score_is_a_quantity_of_a_camera_that_was_scored() -> None:
    assert quantity("fitness", CAMERA, DERIVED, {"fitness": 1.25}) == 1.25
    assert quantity("fitness", CAMERA, DERIVED) is None
