"""What a study simulates, in a sentence, and variables that end at a bound."""

from __future__ import annotations

import pytest

from tacos_framework import load_recipe
from tacos_framework.plan import make_plan
from tacos_framework.plan.conditions import conditions
from tacos_framework.plan.notes import notes_on_bounds


def test_light_exposure_effects_and_noise_are_said(plugins):
    plan = make_plan(
        load_recipe(
            "headset_quick",
            {
                "nodes.frames": {"use": "sensor.camera", "in": {"capture": "capture"}},
                "effects": [{"use": "effect.motion-blur", "speed_deg_s": 60}],
                "scenario": {"illumination_lux": 20, "exposure_ms": 30, "f_number": 2, "gain_db": 5},
            },
        ),
        plugins,
    )
    said = conditions(plan)
    assert said.startswith(
        "Simulated: 20 lux, 30 ms, f/2, 5 dB; moving at 1 m/s, not shaken; effects of the camera: "
    )
    assert "motion-blur (speed" in said
    assert "noise by sensor.camera, with figures assumed for 43 of 43 parts." in said


def test_the_motion_of_the_cameras_is_said(plugins):
    said = conditions(make_plan(load_recipe("headset_moving", {"nodes.world.motion_scale": 2}), plugins))
    assert "; moving at 1 m/s, shaken as on a head (turning by 36 deg/s rms); effects" in said


def test_what_is_designed_and_controlled_is_said(plugins):
    plan = make_plan(
        load_recipe("headset_quick", {"design.scenario.exposure_ms": {"between": [1, 30]}, "effects": []}),
        plugins,
    )
    assert "20 lux, exposure time as designed, f/2" in conditions(plan)
    assert "effects of the camera: demosaic" in conditions(plan)  # what its pipeline does
    controlled = make_plan(load_recipe("headset_exposure"), plugins)
    assert "from which control.mean-level sets time and gain" in conditions(controlled)


def test_only_catalogs_of_image_sensors_count(plugins):
    said = conditions(make_plan(load_recipe("headset_lens"), plugins))
    assert said.count("figures assumed for") == 1
    assert "parts" not in conditions(make_plan(load_recipe("stereo_quick"), plugins))


@pytest.mark.parametrize(
    ("pitch_deg", "said"), [(-30, "bound of -30 deg"), (29.6, "bound of 30 deg"), (0, "")]
)
def test_a_variable_at_its_bound_is_named(plugins, pitch_deg, said):
    plan = make_plan(load_recipe("headset_quick"), plugins)
    values = plan.space.decode([0.5 * (gene.lower + gene.upper) for gene in plan.space.genes]).as_dict()
    notes = list(notes_on_bounds(plan, {**values, "pitch_deg": pitch_deg}))
    assert len(notes) == (1 if said else 0)
    assert said in "".join(notes)
