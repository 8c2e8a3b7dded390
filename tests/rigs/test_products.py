"""Whole cameras as a choice: what they fix, what they cost, and which of them a rig takes."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from tacos_framework.catalog import find_catalog
from tacos_plugins.rigs.costs import COST_UNITS
from tacos_plugins.rigs.monocular import MonocularRig
from tacos_plugins.rigs.priced_part import total_prices
from tacos_plugins.rigs.sensor_part import bits_of
from tacos_plugins.rigs.stereo import StereoRig

PRODUCTS = find_catalog("cameras")
OWN = {
    "name": "Own",
    "sensor": "IMX000",
    "width_px": 1000,
    "height_px": 800,
    "pixel_um": 3.0,
    "hfov_deg": 90.0,
    "f_number": 1.8,
    "max_fps": 50.0,
    "bit_depth": "8/10",
    "price_usd": 110.0,
    "mass_g": 30.0,
    "power_w": 1.5,
}


def monocular(camera=None, config=None, **variables):
    builder = MonocularRig(MonocularRig.Config(**(config or {})))
    own = {"camera": OWN if camera is None else camera, **variables}
    return builder, MonocularRig.Variables(**own)


def test_a_product_fixes_sensor_and_lens() -> None:
    builder, variables = monocular(PRODUCTS.part("raspberry_pi_camera_module_v2"))
    (camera,) = builder.build(variables).cameras
    assert (camera.width_px, camera.height_px, camera.pixel_um) == (3280, 2464, 1.12)
    assert camera.electrons.sensor == "IMX219"
    assert camera.hfov_deg == pytest.approx(62.2)
    assert camera.focal_length_mm == pytest.approx(3.04, rel=0.005)  # as its maker states


def test_a_stereo_product_fixes_the_baseline() -> None:
    builder = StereoRig(StereoRig.Config())
    variables = StereoRig.Variables(camera=PRODUCTS.part("luxonis_oak_d_stereo_pair"))
    left, right = builder.build(variables).cameras
    assert left.agent_from_camera[1, 3] - right.agent_from_camera[1, 3] == pytest.approx(0.075)
    assert builder.derived(variables)["pixel_rate_mpx_s"] == pytest.approx(2 * 1.28 * 0.8 * 120)


def test_costs_follow_from_what_is_stated() -> None:
    builder, variables = monocular(config={"per_euro": {"usd": 1.1}})
    found = builder.derived(variables)
    costs = {name: value for name, value in found.items() if name in COST_UNITS}
    assert costs == pytest.approx(
        {
            "image_width_px": 1000,
            "image_height_px": 800,
            "frame_rate_fps": 50,
            "exposure_max_ms": 20,
            "pixel_rate_mpx_s": 40,
            "bandwidth_mbit_s": 400,  # of 10 bits
            "power_w": 1.5,
            "mass_g": 30,
            "f_number": 1.8,
            "price_usd": 110,
            "price_eur": 100,
        }
    )


def test_what_nobody_states_is_no_cost() -> None:
    bare = {name: OWN[name] for name in ("width_px", "height_px", "pixel_um", "hfov_deg")}
    builder, variables = monocular(bare)
    assert set(builder.derived(variables)) & set(COST_UNITS) == {"image_width_px", "image_height_px"}
    said = " ".join(builder.notes(variables))
    assert "Not published: the f-number of custom" in said
    assert "Not published: price, mass, power of custom." in said


def test_coded_images_take_less_of_the_link() -> None:
    builder, variables = monocular(config={"bits_per_pixel": 1.5})
    assert builder.derived(variables)["bandwidth_mbit_s"] == pytest.approx(60)


@given(share=st.floats(0.1, 1), row_time_us=st.floats(1, 50), blanking=st.integers(0, 200))
def test_fewer_rows_are_read_faster(share: float, row_time_us: float, blanking: int) -> None:
    """A frame lasts as its rows and its blanking, whatever is read of each row."""
    sensor = {"width_px": 640, "height_px": 480, "pixel_um": 3.0, "row_time_us": row_time_us}
    builder, variables = (
        MonocularRig(MonocularRig.Config()),
        MonocularRig.Variables(
            focal_length_mm=3,
            sensor={**sensor, "frame_lines": 480 + blanking},
            roi_height=share,
            roi_width=0.5,
        ),
    )
    found = builder.derived(variables)
    frame_us = 1e6 / found["frame_rate_fps"]
    assert frame_us == pytest.approx(row_time_us * (found["image_height_px"] + blanking))
    assert found["exposure_max_ms"] == pytest.approx(frame_us * 1e-3)


def test_a_sensor_and_a_lens_cost_together() -> None:
    sensor = {**{n: OWN[n] for n in ("width_px", "height_px", "pixel_um")}, "camera_mass_g": 40.0}
    builder, variables = (
        MonocularRig(MonocularRig.Config()),
        MonocularRig.Variables(
            sensor={**sensor, "price_eur": 300.0},
            lens={"focal_length_mm": 4, "price_eur": 90.0, "mass_g": 12.0},
        ),
    )
    found = builder.derived(variables)
    assert (found["price_eur"], found["mass_g"]) == (390, 52)
    lensless = MonocularRig.Variables(sensor={**sensor, "price_eur": 300.0}, focal_length_mm=4)
    assert {"price_eur", "mass_g"}.isdisjoint(builder.derived(lensless))


@pytest.mark.parametrize(
    ("variables", "said"),
    [
        ({"sensor": {"width_px": 8, "height_px": 8, "pixel_um": 1}}, "give camera or sensor, not both"),
        ({"focal_length_mm": 4.0}, "give camera or focal_length_mm, not both"),
        ({"camera": {**OWN, "kind": "stereo"}}, "its kind is stereo, not mono"),
        ({"camera": {**OWN, "hfov_deg": None}}, "neither hfov_deg nor focal_length_mm is known"),
        ({"camera": {**OWN, "price_xyz": 3.0}}, "price_xyz names no currency that is known here"),
        ({"camera": {**OWN, "mass": 3.0}}, "mass_g, with its unit, in place of mass"),
        (
            {"camera": {**OWN, "black_level_dn": 900, "black_level_bits": 10}},
            "900 DN at 10 bit, leaves less than half of the range for light",
        ),
    ],
)
def test_what_does_not_go_together_is_said(variables, said: str) -> None:
    with pytest.raises(ValidationError, match=said):
        MonocularRig.Variables(**{"camera": OWN, **variables})


def test_a_rate_is_of_a_currency_that_is_known() -> None:
    with pytest.raises(ValidationError, match="per_euro"):
        MonocularRig.Config(per_euro={"xyz": 2.0})


@given(rate=st.floats(0.01, 200), euros=st.floats(1, 1e4), dollars=st.floats(1, 1e4))
def test_prices_in_two_currencies_are_added_by_the_stated_rate_alone(rate, euros, dollars) -> None:
    parts = [{"eur": euros}, {"usd": dollars}]
    assert total_prices(parts, {}) == {}
    total = total_prices(parts, {"usd": rate})
    assert total["eur"] == pytest.approx(euros + dollars / rate)
    assert total["usd"] == pytest.approx(total["eur"] * rate)
    assert set(total) == {"eur", "usd"}


def test_every_product_that_can_be_chosen_shows_the_field_its_maker_states() -> None:
    built = 0
    for row in PRODUCTS.rows:
        rig = {"mono": MonocularRig, "stereo": StereoRig}.get(str(row["kind"]))
        if rig is None or None in map(row.values.get, PRODUCTS.design_columns):
            continue
        variables = rig.Variables(camera=row)
        camera = rig(rig.Config()).build(variables).cameras[0]
        assert camera.hfov_deg == pytest.approx(row.number("hfov_deg"))
        assert math.isfinite(rig(rig.Config()).derived(variables)["pixels_per_deg"])
        built += 1
    assert built >= 48


@pytest.mark.parametrize(
    ("stated", "bits"), [("8/10", 10), ("12", 12), ("8/16", 16), (None, None), ("", None)]
)
def test_the_deepest_mode_counts(stated, bits) -> None:
    assert bits_of(stated) == bits
