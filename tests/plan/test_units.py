"""Figures in another unit, found before anything is rendered."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from toy_study import toy_recipe

from tacos_framework import load_recipe
from tacos_framework.errors import UserError
from tacos_framework.plan import make_plan
from tacos_framework.plan.units import doubts_of_camera, doubts_of_units
from tacos_framework.plugins import Plugins
from tacos_framework.values import Camera


def camera(**figures: float) -> Camera:
    return Camera("c", 1280, 960, **{"pixel_um": 3.0, "focal_length_mm": 4.0, **figures})


@given(pixel_um=st.floats(1.0, 20.0), focal_length_mm=st.floats(3.0, 80.0))
def test_what_cameras_have_passes_and_other_units_do_not(pixel_um: float, focal_length_mm: float) -> None:
    figures = {"pixel_um": pixel_um, "focal_length_mm": focal_length_mm}
    assert [*doubts_of_camera(camera(**figures))] == []
    for name, other, factor in (
        ("pixel_um", "millimetres", 1e-3),
        ("pixel_um", "nanometres", 1e3),
        ("focal_length_mm", "metres", 1e-3),
        ("focal_length_mm", "micrometres", 1e3),
    ):
        (doubt,) = doubts_of_camera(camera(**{**figures, name: figures[name] * factor}))
        assert doubt.startswith(f"{name} is ")
        assert f"is it in {other}? Then it is {figures[name]:g}" in doubt


def test_a_field_of_view_that_no_lens_has_is_doubted() -> None:
    (doubt,) = doubts_of_camera(camera(pixel_um=100.0, focal_length_mm=0.2))
    assert "sees 180 degrees; check both" in doubt


@pytest.mark.parametrize(
    ("scenario", "said"),
    [
        ({"exposure_ms": 30.0}, ""),
        (
            {"exposure_ms": 3e5},
            "as of no camera; is it in microseconds? Then it is 300",
        ),
        ({"exposure_ms": 5e-5}, "is it in seconds? Then it is 0.05"),
    ],
)
def test_exposures_are_doubted_with_the_likely_unit(toys: Plugins, scenario: Any, said: str) -> None:
    found = [*doubts_of_units(make_plan(toy_recipe(scenario=scenario), toys))]
    assert found == [] if not said else said in " ".join(found)


def test_binning_that_leaves_no_image_is_a_fault(toys: Plugins) -> None:
    rig = {"use": "rig.monocular", "sensor": {"width_px": 1600, "height_px": 800, "pixel_um": 1.0}}
    assert make_plan(toy_recipe(rig={**rig, "binning": 2}), toys)
    with pytest.raises(UserError, match="2000 leaves an image of 1 x 1 pixels") as refused:
        make_plan(toy_recipe(rig={**rig, "binning": 2000}), toys)
    assert "rig.binning" in str(refused.value)


@pytest.mark.parametrize(
    ("sets", "place"),
    [
        ({"scenario.exposure_ms": 150.0}, "scenario.exposure_ms"),
        ({"design.scenario.exposure_ms": {"choose": [4, 150]}}, "design.scenario.exposure_ms"),
        ({"design.scenario.exposure_ms": {"between": [4, 150]}}, "design.scenario.exposure_ms"),
    ],
)
def test_exposures_longer_than_the_time_of_a_frame_are_refused(sets: Any, place: str) -> None:
    plugins = Plugins.discover()
    if "scenario.exposure_ms" in sets:
        sets = {**sets, "design": {"camera": {"from": "cameras"}}}
    with pytest.raises(UserError) as refused:
        make_plan(load_recipe("buy_headset", sets), plugins)
    (fault,) = refused.value.faults
    assert fault.what == "exposures of 150 ms are longer than the 100 ms from frame to frame of 'world'"
    assert "a frame_rate_hz of 6.67 or less" in fault.remedy
    assert place in fault.where
    assert make_plan(load_recipe("buy_headset", {**sets, "nodes.world.frame_rate_hz": 6}), plugins)
