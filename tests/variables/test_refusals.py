"""What makes no sense as a design space or as a value in it is refused in a sentence."""

from __future__ import annotations

import math
from typing import Any

import pytest

from tacos_framework.variables.design_space import (
    Categorical,
    Continuous,
    DesignSpace,
    Integer,
)
from tests.variables.spaces import SENSORS, UNKNOWN_PIXEL, full_space, sensor, sensor_choice


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Continuous("f", 20, 1), "f is between 20 and 1: the lower bound must come first"),
        (lambda: Continuous("f", 1, 1), "the lower bound must come first"),
        (lambda: Continuous("f", 1, math.inf), "bounds of f must be finite numbers, not 1 and inf"),
        (lambda: Continuous("f", math.nan, 1), "bounds of f must be finite numbers"),
        (lambda: Integer("n", 1, 2.5), "n is a whole number, so its bounds are, not 2.5"),  # type: ignore[arg-type]
        (lambda: Integer("n", 0, 2**60), "n is a whole number"),
        (lambda: Categorical("c", ()), "c needs at least one value to choose from"),
        (lambda: Categorical("c", ("a", "b", "a")), "c names 'a' more than once"),
        (lambda: sensor_choice(columns=()), "sensor needs at least one column"),
        (lambda: sensor_choice(columns=("maker",)), "sensors has no column of numbers 'maker'"),
        (lambda: sensor_choice(columns=("pixel_mm",)), "numbers 'pixel_mm'. Did you mean 'pixel_um'?"),
        (
            lambda: sensor_choice(UNKNOWN_PIXEL),
            "no part of catalog sensors is known in width_mm, height_mm, pix",
        ),
        (lambda: sensor_choice(scheme="quantised"), "the scheme of sensor is quantized or discrete, not"),
        (lambda: sensor_choice(distance="far"), "the distance of sensor is normalised or plain, not 'far'"),
        (lambda: DesignSpace([Continuous("f", 1, 2)] * 2), "design variables need different names, not f, f"),
        (lambda: full_space().fix(["sensr"]), "'sensr' is no design variable. Did you mean 'sensor'?"),
    ],
)
def test_what_makes_no_sense_is_refused_in_a_sentence(build: Any, message: str) -> None:
    with pytest.raises(ValueError) as caught:  # noqa: PT011
        build()
    assert message in str(caught.value)


def test_parts_that_coincide_have_no_nearest() -> None:
    twins = (*SENSORS, sensor("twin", 6.0, 4.5, 1.5))
    with pytest.raises(
        ValueError, match="fine and twin are equal in width_mm, height_mm, pixel_um, so neither"
    ):
        sensor_choice(*twins)
    space = DesignSpace([sensor_choice(*twins, scheme="discrete")])
    for part in twins:
        assert space.decode(space.encode({"sensor": part})).values["sensor"] is part


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"pitch_deg": 31}, "pitch_deg is 31 deg, outside of -30 to 30 deg"),
        ({"pitch_deg": math.nan}, "pitch_deg is nan deg, outside"),
        ({"pitch_deg": "3"}, "pitch_deg is a number, not '3'"),
        ({"pitch_deg": True}, "pitch_deg is a number, not True"),
        ({"cameras": 2.5}, "cameras is a whole number, not 2.5"),
        ({"cameras": 9}, "cameras is 9, outside of 1 to 4"),
        ({"lens": "macro"}, "lens is one of 'wide', 'tele', 1, True, None, not 'macro'"),
        ({"sensor": "fin"}, "sensor has no part 'fin'. Did you mean 'fine'?"),
        ({"sensor": {"width_mm": 6.0}}, "sensor has no part None"),
        ({"sensr": 1}, "'sensr' is no design variable"),
    ],
)
def test_values_outside_the_space_are_refused(changes: dict[str, Any], message: str) -> None:
    values = {"pitch_deg": 0.0, "sensor": "fine", "cameras": 2, "lens": "wide", **changes}
    with pytest.raises(ValueError) as caught:  # noqa: PT011
        full_space().encode(values)
    assert message in str(caught.value)


def test_genes_and_values_must_be_complete() -> None:
    with pytest.raises(ValueError, match="no value for sensor, lens"):
        full_space().encode({"pitch_deg": 0.0, "cameras": 2})
    with pytest.raises(ValueError, match=r"this design space has 6 genes, not \(2,\)"):
        full_space().decode([1.0, 2.0])
    with pytest.raises(ValueError, match=r"not a number: sensor.pixel_um, lens"):
        full_space().decode([0, 6, 4, math.nan, 2, math.nan])


@pytest.mark.parametrize("scheme", ["quantized", "discrete"])
def test_parts_with_an_unknown_number_are_left_out_and_told(scheme: Any) -> None:
    choice = sensor_choice(*SENSORS, UNKNOWN_PIXEL, scheme=scheme)
    assert choice.left_out == (UNKNOWN_PIXEL,)
    assert set(choice.rows) == set(SENSORS)
    by_size = sensor_choice(*SENSORS, UNKNOWN_PIXEL, scheme=scheme, columns=("width_mm", "height_mm"))
    assert by_size.left_out == ()
