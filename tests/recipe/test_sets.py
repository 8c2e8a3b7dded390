"""``--set``: values from outside the file are put in, fixed, and named where they are wrong."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from toy_study import FROM_CATALOG, merged

from tacos_framework.cli import run_main
from tacos_framework.errors import UserError
from tacos_framework.plan import make_plan
from tacos_framework.recipe import load_recipe
from tacos_framework.recipe.loading import read_any_recipe

RECIPE = {
    **merged(
        FROM_CATALOG,
        {
            "rig": {"use": "rig.stereo"},
            "design": {
                "baseline_m": {"between": [0.1, 0.2]},
                "frames.sigma_dn": {"between": [0, 3]},
                "frames.left.sigma_dn": {"between": [0, 3]},
                "effects.toy-dim.share": {"between": [0, 0.5]},
                "effects.dusk.share": {"between": [0, 0.5]},
                "scenario.night.gain_db": {"between": [0, 9]},
                "scenario.exposure_ms": {"between": [5, 9]},
            },
        },
    ),
    "effects": [{"use": "effect.toy-dim"}, {"use": "effect.toy-dim", "name": "dusk"}],
    "scenario": [{"name": "day"}, {"name": "night", "illumination_lux": 1}],
}


@pytest.fixture(scope="module")
def file(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("recipes") / "r.yaml"
    path.write_text(json.dumps(RECIPE, indent=1))
    return path


def changed(file, **sets):
    recipe = load_recipe(file, {key.replace("__", "."): value for key, value in sets.items()})
    return recipe.as_data()


def faults_of(file, toys, sets):
    recipe, faults = read_any_recipe(file, sets=sets)
    with pytest.raises(UserError) as caught:
        make_plan(recipe, toys, faults)
    return list(map(str, caught.value.faults))


def test_the_recipe_itself_is_right(file, toys):
    recipe, faults = read_any_recipe(file)
    assert make_plan(recipe, toys, faults).space.names[-1] == "scenario.exposure_ms"


def test_a_plain_value_fixes_a_variable_of_the_rig(file, toys):
    data = changed(file, design__baseline_m=0.15)
    assert "baseline_m" not in data["design"]
    assert data["rig"]["baseline_m"] == 0.15
    recipe, faults = read_any_recipe(file, sets={"design.baseline_m": 0.15})
    assert make_plan(recipe, toys, faults).fixed["baseline_m"] == 0.15


def test_a_plain_value_fixes_the_setting_of_a_node_of_an_effect_and_of_the_scenarios(file):
    sets = {
        "design.frames.sigma_dn": 2,
        "design.effects.toy-dim.share": 0.1,
        "design.effects.dusk.share": 0.2,
        "design.scenario.night.gain_db": 3,
        "design.scenario.exposure_ms": 7,
    }
    data = load_recipe(file, sets).as_data()
    assert not {key.removeprefix("design.") for key in sets} & set(data["design"])
    assert data["nodes"]["frames"]["sigma_dn"] == 2
    assert [effect["share"] for effect in data["effects"]] == [0.1, 0.2]
    assert [scenario["gain_db"] for scenario in data["scenario"]] == [5, 3]
    assert [scenario["exposure_ms"] for scenario in data["scenario"]] == [7, 7]


def test_what_is_set_within_a_value_stays_out_of_the_caller_s_value(file):
    optimizer = {"use": "optimizer.genetic", "population": 4}
    effect = {"use": "effect.toy-dim", "name": "dawn"}
    changed = load_recipe(file, {"optimizer": optimizer, "optimizer.start": "largest"}, effects=[effect])
    assert changed.optimizer.settings["start"] == "largest"
    assert optimizer == {"use": "optimizer.genetic", "population": 4}
    assert "start" not in load_recipe(file, {"optimizer": optimizer}).optimizer.settings


def test_an_effect_may_be_fixed_by_its_number(file):
    assert changed(file, design__effects__1__share=0.3)["effects"][1]["share"] == 0.3


def test_the_setting_of_one_camera_has_no_other_place_and_stays_with_nothing_to_choose(file, toys):
    recipe, faults = read_any_recipe(file, sets={"design.frames.left.sigma_dn": 1})
    (variable,) = [
        v for v in make_plan(recipe, toys, faults).space.variables if v.name == "frames.left.sigma_dn"
    ]
    assert variable.values == (1,)


def test_what_is_below_a_variable_with_dots_in_its_name_can_be_set(file):
    design = changed(file, design__frames__sigma_dn__between=[1, 2])["design"]
    assert design["frames.sigma_dn"]["between"] == [1, 2]
    design = changed(file, design__capture__reads__between=[1, 2])["design"]
    assert design["capture.reads"]["between"] == [1, 2]  # which `make_plan` knows nothing of
    assert changed(file, design__pitch_deg={"between": [0, 1]})["design"]["pitch_deg"]["between"] == [0, 1]


def test_bounds_of_a_column_whose_name_has_dots_can_be_set(file):
    sets = {"constraints.sensor.full_well_e.min": 5, "constraints.sensor.full_well_e.unknown": "refuse"}
    found = load_recipe(file, {**sets, "constraints.hfov_deg.max": 90}).constraints
    assert set(found) == {"sensor.full_well_e", "hfov_deg"}
    assert (found["sensor.full_well_e"].min, found["sensor.full_well_e"].unknown) == (5, "refuse")
    whole = load_recipe(file, {"constraints.sensor.shutter": {"is": "global"}}).constraints
    assert whole["sensor.shutter"].words == ("global",)


def test_the_last_variable_cannot_be_fixed(tmp_path, toys):
    path = tmp_path / "one.yaml"
    path.write_text(json.dumps({**RECIPE, "design": {"focal_length_mm": {"between": [1, 2]}}}))
    (fault, *_) = faults_of(path, toys, {"design.focal_length_mm": 1})
    assert fault.startswith("--set design.focal_length_mm: with 'focal_length_mm' fixed, nothing is left to")


@pytest.mark.parametrize(
    ("sets", "message"),
    [
        ({"design.pitch_dg": 5}, "--set design.pitch_dg: unknown key 'pitch_dg'"),
        ({"design.pitch_deg": 500}, "--set design.pitch_deg: pitch_deg is 500"),
        ({"design.frames.sigma_dn": -1}, "--set design.frames.sigma_dn: sigma_dn is -1"),
        ({"design.frames.sigma": 1}, "--set design.frames.sigma: unknown key 'sigma'"),
        ({"design.nodes.sigma": 1}, "--set design.nodes.sigma: there is no node 'nodes'"),
        ({"design.effects.3.share": 1}, "--set design.effects.3.share: there is no effect '3'"),
        ({"nodes.world": {"use": "scene.toy", "frames": "x"}}, '--set nodes.world: frames is "x"'),
        ({"nodes": {"world": {"use": "scene.toi"}}}, "--set nodes: no component 'scene.toi'"),
        ({"rig": {"use": "rig.stereo", "binnig": 4}}, "--set rig: unknown key 'binnig'"),
        ({"scenario.0.gain_db": "x"}, '--set scenario.0.gain_db: scenario.0.gain_db is "x"'),
        ({"scenario": []}, "--set scenario: the list of scenarios is empty"),
        ({"foo.bar": 1}, "--set foo.bar: unknown key 'foo'"),
        ({"test": {"seed": -1}}, "--set test: test.seed is -1"),
        (
            {"test": {"seed": 5}, "test.seed": -1},
            "--set test.seed: test.seed is -1",
        ),
        ({"test.seed": 1, "test": 3}, "--set test: test is 3"),
    ],
)
def test_faults_of_a_value_are_placed_at_its_option_and_never_at_a_line(file, toys, sets, message):
    faults = faults_of(file, toys, sets)
    assert any(fault.startswith(message) for fault in faults), "\n".join(faults)
    assert not any(fault.startswith("r.yaml") and "sigma" in fault for fault in faults)


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ("seed=.nan", "--set seed: .nan is not a number that can be used"),
        ("seed=[", "--set seed: this is not valid YAML"),
        ("seed={a: .inf, a: 1}", "--set seed: .inf is not"),
        ("design.pitch_deg=x", '--set design.pitch_deg: pitch_deg is "x"'),
        ("notes=&a 1", "--set notes: anchor &a is not supported"),
    ],
)
def test_what_yaml_refuses_in_an_option_is_placed_at_the_option(option, message, capsys):
    assert run_main(["headset_quick", "--check", "--set", option]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert ":1:" not in error


WORDS = """design rig nodes effects scenario study fitness test frames left use focal_length_mm sigma_dn share
between in race 0 1 7 ² ٣ -1 toy-dim day compare cameras tacos name train optimizer executor"""
KEYS = st.lists(st.sampled_from([*WORDS.split(), "", "x y"]), min_size=1, max_size=4).map(".".join)
ODD = """

1
-1
1e999
.nan
x
[
[]
{}
[1, 2]
true
~
'\\0'
"\\uD800"
!!x 1
{a: 1, a: 2}
{between: [1, 2]}
{between: [.inf, 1]}
{choose: []}
{choose: [a, 1, true]}
{from: image_sensors}
{use: scene.toy}
{use: ''}
{use: task.toy-width, in: {frames: world}}
{use: procedure.diagnose}
procedure.simulate-captures
[{name: a, weight: 0}]
999999999999999999999999999999999999999999999"""
VALUES = st.sampled_from(ODD.splitlines()[1:])


@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.lists(st.tuples(KEYS, VALUES), min_size=1, max_size=3))
@example([("design.pitch_deg", "5")])
@example([("design", "5")])
@example([("design.effects.0", "5")])
@example([("scenario", "~"), ("design.scenario.gain_db", "4")])
@example([("nodes", "~"), ("nodes.frames.in.capture", "capture")])
@example([("effects", "[1]"), ("design.effects.0.share", "1")])
@example([("tacos", ""), ("use", "procedure.diagnose")])
@example([("constraints", "[1]"), ("constraints.0.min", "1"), ("constraints.sensor.width.min", "1")])
def test_no_option_ends_in_a_traceback(file, toys, sets):
    from tacos_framework.cli import run as command

    arguments = command.parser().parse_args([str(file), *(f"--set={key}={value}" for key, value in sets)])
    with contextlib.suppress(UserError):
        recipe, faults = command._read(arguments, toys)
        planned = command._plan_study if hasattr(recipe, "nodes") else command._plan_procedure
        planned(recipe, toys, faults)
