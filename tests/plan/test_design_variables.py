"""Design variables reach every setting of nodes, effects and scenarios; what they cannot reach is told."""

from __future__ import annotations

import pytest
from toy_study import toy_recipe

from tacos_framework.cli.explain import explain
from tacos_framework.errors import UserError
from tacos_framework.plan import make_plan, target_of
from tacos_framework.simulation.overrides import overrides_of

STEREO = {
    "rig": {"use": "rig.stereo", "baseline_m": 0.1},
    "nodes": {
        "dim": {"use": "effect.toy-dim", "in": {"capture": "capture"}, "cameras": ["left"]},
        "frames": {"in": {"capture": "dim"}},
        "isp": {"use": "effect.toy-invert", "in": {"frames": "frames"}},
        "mean": {"use": "transform.toy-mean", "in": {"frames": "isp"}},
        "level": {"use": "task.toy-level", "in": {"levels": "mean"}},
    },
    "effects": [
        {"use": "effect.toy-offset"},
        {"use": "effect.toy-offset", "cameras": ["right"]},
        {"use": "effect.toy-offset", "name": "pedestal"},
    ],
    "scenario": [{"name": "day"}, {"name": "night", "illumination_lux": 1}],
}


def recipe(design, **sections):
    base = {"mean.gain": {"between": [0.5, 2]}}
    return toy_recipe(**{**STEREO, "design": {**base, **design}, **sections})


def faults_of(design, toys, **sections):
    with pytest.raises(UserError) as caught:
        make_plan(recipe(design, **sections), toys)
    return list(map(str, caught.value.faults))


def test_every_setting_can_be_designed(toys):
    design = {
        "isp.share": {"between": [0, 1]},
        "isp.steps": {"between": [1, 64], "integer": True},
        "isp.mode": {"choose": ["all", "red"]},
        "isp.left.share": {"between": [0, 1]},
        "dim.left.share": {"between": [0, 1]},
        "frames.right.sigma_dn": {"between": [0, 2]},
        "world.frames": {"choose": [2, 3]},
        "effects.toy-offset.offset_dn": {"between": [-5, 5]},
        "effects.1.right.offset_dn": {"between": [-5, 5]},
        "effects.pedestal.offset_dn": {"between": [-5, 5]},
        "scenario.f_number": {"between": [1, 4]},
        "scenario.night.gain_db": {"between": [0, 20]},
    }
    plan = make_plan(recipe(design), toys)
    assert set(design) < set(plan.space.names)
    assert [part.name for part in plan.effects] == ["toy-offset", "toy-offset_2", "pedestal"]
    units = {row["name"]: row["unit"] for row in plan.space.as_data()}
    assert units["frames.right.sigma_dn"] == "DN"
    assert units["scenario.night.gain_db"] == "dB"


BETWEEN = {"between": [0, 1]}
WRONG = [
    ("isp.shar", BETWEEN, "effect.toy-invert has no variable 'shar'\n  to do: Did you mean 'share'?"),
    ("ips.share", BETWEEN, "there is no node 'ips'\n  to do: Did you mean 'isp'?"),
    ("effects.pedestl.offset_dn", BETWEEN, "there is no effect 'pedestl'"),
    ("effects.pedestl.offset_dn", BETWEEN, "Did you mean 'pedestal'?"),
    ("effects.3.offset_dn", BETWEEN, "there is no effect '3'"),
    ("effects.pedestal", BETWEEN, "effect.toy-offset has no variable ''"),
    ("effects.pedestal.offset", BETWEEN, "Did you mean 'offset_dn'?"),
    ("effects.0.middle.offset_dn", BETWEEN, "rig.stereo has no camera 'middle'"),
    ("effects.1.left.offset_dn", BETWEEN, "the effect does not act on camera 'left', but on right"),
    ("dim.right.share", BETWEEN, "the effect does not act on camera 'right', but on left"),
    ("mean.left.gain", BETWEEN, "transform.toy-mean has no settings for one camera, 'left'"),
    ("mean.left.gain", BETWEEN, "Call it mean.gain."),
    ("world.left.frames", BETWEEN, "scene.toy has no settings for one camera"),
    ("frames.middle.sigma_dn", BETWEEN, "rig.stereo has no camera 'middle'"),
    ("scenario.gain", BETWEEN, "scenario has no variable 'gain'\n  to do: Did you mean 'gain_db'?"),
    ("gain_db", BETWEEN, "rig.stereo has no variable 'gain_db'\n  to do: Did you mean 'scenario.gain_db'?"),
    ("aperture", BETWEEN, "to do: Did you mean 'scenario.f_number'?"),
    ("share", BETWEEN, "to do: Did you mean 'dim.share'?"),
    ("scenario.offset_dn", BETWEEN, "to do: Did you mean 'effects.toy-offset.offset_dn'?"),
    ("rig.baseline_m", BETWEEN, "variables of the rig are named alone"),
    ("rig.baseline_m", BETWEEN, "to do: Did you mean 'baseline_m'?"),
    ("scenario.nigth.gain_db", BETWEEN, "there is no scenario 'nigth'"),
    ("scenario.nigth.gain_db", BETWEEN, "Did you mean 'night'?"),
    ("scenario.night.weight", BETWEEN, "scenario has no variable 'weight'"),
    ("scenario.f_number", BETWEEN, "scenario.f_number is 0.0"),
    ("isp.share", {"between": [0, 1.5]}, "isp.share is 1.5\n  expected: less than or equal to 1"),
    ("isp.share", {"between": [-1, 1]}, "isp.share is -1.0\n  expected: greater than or equal to 0"),
    ("isp.left.share", {"between": [0, 1.5]}, "isp.left.share is 1.5"),
    ("effects.1.offset_dn", {"choose": [1, "two"]}, 'effects.1.offset_dn is "two"'),
    ("isp.mode", {"choose": ["all", "blue"]}, "isp.mode is \"blue\"\n  expected: 'all' or 'red'"),
    ("isp.steps", {"between": [1, 8]}, "isp.steps is 1.0\n  expected: a whole number"),
    ("isp.steps", {"between": [1, 8]}, "to do: Add integer: true to design whole numbers."),
    ("isp.steps", {"between": [0.5, 8], "integer": True}, "a whole number, so its bounds are, not 0.5"),
    ("world.frames", {"choose": [2, 0, 3]}, "world.frames is 0"),
    ("mean.gain", {"between": [0, 99]}, "mean.gain is 99.0"),
    ("effects.toy-offset_2.offset_dn", BETWEEN, "", {"effects.1.offset_dn": BETWEEN}),
]


@pytest.mark.parametrize("wrong", WRONG, ids=lambda wrong: f"{wrong[0]}: {wrong[2][:40]}")
def test_what_cannot_be_designed_is_told_at_its_place(toys, wrong):
    name, entry, message, *more = wrong
    faults = faults_of({name: entry, **(more[0] if more else {})}, toys)
    assert all(fault.startswith("recipe.design.") for fault in faults), "\n".join(faults)
    if more:
        message = "it sets what 'effects.toy-offset_2.offset_dn' sets already"
    assert any(message in fault for fault in faults), "\n".join(faults)


@pytest.mark.parametrize("name", ["offset_dn", "scenario.offset_dn", "effects.toy-offset.offset_dn"])
def test_an_effect_that_the_recipe_lacks_is_named_with_what_to_write(toys, name):
    (fault,) = faults_of({name: BETWEEN}, toys, effects=[])
    assert "effects: [{use: effect." in fault
    assert "effect.toy-offset" in fault or "'effects.toy-offset.offset_dn'" in fault


def test_all_values_are_tried_and_each_fault_is_told_once(toys):
    faults = faults_of({"world.frames": {"choose": [0, -1, 2]}, "isp.share": {"between": [-1, 2]}}, toys)
    assert len(faults) == 4


def test_settings_that_must_be_given_may_be_designed_instead(toys):
    assert make_plan(recipe({}), toys).nodes["mean"].config.gain == 0.5
    (fault,) = faults_of(
        {"mean.gain": BETWEEN},
        toys,
        nodes={
            **STEREO["nodes"],
            "second": {"use": "transform.toy-mean", "in": {"frames": "isp"}},
            "judge": {"use": "task.toy-level", "in": {"levels": "second"}},
        },
    )
    assert "recipe.nodes.second.gain: 'gain' is missing" in fault


@pytest.mark.parametrize(
    ("sections", "message"),
    [
        ({"effects": [{"use": "effect.toy-dim", "cameras": ["lft"]}]}, "Did you mean 'left'?"),
        (
            {"effects": [{"use": "effect.toy-dim", "cameras": ["lft"]}]},
            "recipe.effects.0.cameras.0: rig.ster",
        ),
        (
            {"nodes": {"dim": {**STEREO["nodes"]["dim"], "cameras": ["up"]}}},
            "recipe.nodes.dim.cameras.0: rig.stereo has no camera 'up'",
        ),
        (
            {"nodes": {"dim": {**STEREO["nodes"]["dim"], "cameras": []}}},
            "recipe.nodes.dim.cameras: cameras is []",
        ),
        ({"nodes": {"dim": {**STEREO["nodes"]["dim"], "cameras": "up"}}}, 'cameras is "up"'),
        ({"nodes": {"frames": {"use": "sensor.toy", "cameras": ["left"]}}}, "unknown key 'cameras'"),
        (
            {"effects": [{"use": "effect.toy-dim", "name": "a"}, {"use": "effect.toy-dim", "name": "a"}]},
            "recipe.effects.1.name: two effects are called 'a'",
        ),
        ({"scenario": []}, "recipe.scenario: the list of scenarios is empty"),
        ({"scenario": [{"name": "a"}, {"name": "a"}]}, "recipe.scenario.1: two scenarios are called 'a'"),
        (
            {"nodes": {"effects": {"use": "scene.toy"}}},
            "a node is called 'effects', which under design: means",
        ),
        ({"nodes": {"scenario": {"use": "scene.toy"}}}, "expected: another name"),
        ({"nodes": {"odd": {"use": "thing.odd"}}}, "no component 'thing.odd' is installed"),
    ],
)
def test_cameras_and_names_are_checked(toys, sections, message):
    merged = {**sections, "nodes": {**STEREO["nodes"], **sections.get("nodes", {})}}
    faults = faults_of({}, toys, **merged)
    assert any(message in fault for fault in faults), "\n".join(faults)


def test_explain_says_what_each_variable_sets_and_reaches(toys):
    design = {
        "effects.1.right.offset_dn": {"between": [-5, 5]},
        "isp.share": {"between": [0, 1]},
        "scenario.night.illumination_lux": {"between": [1, 2]},
        "scenario.gain_db": {"between": [1, 2]},
    }
    text = explain(make_plan(recipe(design), toys))
    for line in (
        "  mean.gain: continuous, 0.5 to 2; sets gain of node mean (transform.toy-mean); reaches mean, level",
        "  effects.1.right.offset_dn: continuous, -5 to 5 DN; sets offset_dn of effect toy-offset_2 "
        "(effect.toy-offset) at camera right; reaches frames, isp, mean, level",
        "  scenario.night.illumination_lux: continuous, 1 to 2 lux; sets illumination_lux of scenario night; "
        "reaches world, capture, dim, frames, isp, mean, level",
        "; sets gain_db of all scenarios; reaches capture, dim, frames, isp, mean, level",
        "  toy-offset_2: effect.toy-offset, on right",
        "Scenarios: every candidate is scored in each, and their weighted mean counts",
        "      gain: designed",
        "      cameras: left",
    ):
        assert line in text


def test_targets_are_told_from_names():
    names = ("jpeg", "jpeg_2")
    assert target_of("pitch_deg", names).kind == "rig"
    assert target_of("effects.1.left.quality", names) == target_of("effects.jpeg_2.left.quality", names)
    assert target_of("scenario.night.gain_db", names).owner == "night"
    assert target_of("isp.a.b.gamma", names).camera == "a.b"  # of which no rig has one


def test_a_candidate_s_values_are_sorted_by_what_they_set():
    overrides = overrides_of(
        {
            "pitch_deg": 3.0,
            "isp.gamma": 2.0,
            "isp.left.gamma": 2.2,
            "effects.0.quality": 50,
            "effects.jpeg.right.quality": 60,
            "scenario.gain_db": 1.0,
            "scenario.night.gain_db": 9.0,
        },
        ["jpeg"],
    )
    assert overrides.nodes.settings == {"isp": {"gamma": 2.0}}
    assert overrides.nodes.by_camera == {"isp": {"left": {"gamma": 2.2}}}
    assert overrides.effects.settings == {"jpeg": {"quality": 50}}
    assert overrides.effects.by_camera == {"jpeg": {"right": {"quality": 60}}}
    assert overrides.of_scenario("night") == {"gain_db": 9.0}
    assert overrides.of_scenario("day") == overrides.of_scenario("") == {"gain_db": 1.0}
