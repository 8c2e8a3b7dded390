"""Figures that are assumed of parts are said before a study runs."""

from __future__ import annotations

from tacos_framework import load_recipe
from tacos_framework.plan import make_plan
from tacos_framework.plan.conditions import conditions
from tacos_framework.plan.origins import notes_on_assumptions
from tacos_framework.plugins import Plugins


def test_line_times_that_no_maker_states_are_counted():
    plugins = Plugins.discover()
    said = list(notes_on_assumptions(make_plan(load_recipe("headset_moving"), plugins)))
    assert any(each.startswith("sensor.camera assumes figures of 43 of 43 parts") for each in said)
    (motion,) = [each for each in said if each.startswith("effect.motion")]
    assert motion.endswith("parts of image_sensors: line time (8).")
    one_for_all = {"effects": [{"use": "effect.motion", "row_time_us": 20}]}
    said = notes_on_assumptions(make_plan(load_recipe("headset_moving", one_for_all), plugins))
    assert not any(each.startswith("effect.motion") for each in said)


def test_products_are_asked_of_their_image_sensors():
    plan = make_plan(load_recipe("buy_drone"), Plugins.discover())
    assert any(
        "sensor.camera assumes figures of 16 of 16 parts of cameras" in s for s in notes_on_assumptions(plan)
    )
    assert "with figures assumed for 16 of 16 parts" in conditions(plan)
