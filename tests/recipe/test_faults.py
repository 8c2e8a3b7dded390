"""What a user reads who got a recipe wrong: all of it at once, each with place, expectation and remedy."""

from __future__ import annotations

import pytest

from tacos_framework.components import Component
from tacos_framework.errors import UserError
from tacos_framework.hookspecs import hookimpl
from tacos_framework.plan import make_plan
from tacos_framework.plan.procedure import plan_procedure
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Recipe, parse_recipe
from tacos_framework.recipe.procedure import procedure_from
from tacos_framework.settings.yaml_reader import read_yaml_draft

RIGHT = """\
tacos: 1
name: right
seed: 7
rig: {use: rig.monocular, binning: 4}
design:
  pitch_deg: {between: [-30, 30]}
  focal_length_mm: {between: [1, 20]}
  sensor: {from: image_sensors}
constraints: {hfov_deg: {max: 140}}
scenario: {illumination_lux: 20, gain_db: 5}
effects: []
nodes:
  world: {use: scene.toy, frames: 5}
  capture: {use: renderer.toy, in: {episode: world}}
  frames: {use: sensor.affine-noise, in: {capture: capture}, calibration: flea3_imx172}
  features: {use: task.orb-features, in: {frames: frames}}
fitness:
  - {score: features.inliers, weight: 0.0025}
  - {score: features.inlier_ratio, weight: 0.5}
optimizer: {use: optimizer.genetic, population: 10, keep: 3, parents: 5, generations: 20}
executor: {use: executor.local}
compare: {cameras: [oak_d_pro_wide, flea3, basler_dart], evaluations: 30}
test: {seed: 1001}
"""


def plan(text, plugins):
    recipe, faults = parse_recipe(text, name="r.yaml")
    return make_plan(recipe, plugins, faults)


def faults_of(text, plugins):
    with pytest.raises(UserError) as caught:
        plan(text, plugins)
    return list(map(str, caught.value.faults))


def test_a_right_recipe_has_no_faults(toys):
    assert plan(RIGHT, toys).space.names == ("pitch_deg", "focal_length_mm", "sensor")


def test_resolved_recipes_read_back_equal(toys):
    import yaml

    recipe, faults = parse_recipe(RIGHT)
    assert not faults
    again, faults = parse_recipe(yaml.safe_dump(recipe.as_data()))
    assert not faults
    assert again.as_data() == recipe.as_data()
    assert Recipe.model_validate(recipe.as_data()).as_data() == recipe.as_data()


WRONG = [
    ("seed: 7", "seed: seven", 'r.yaml:3:1: seed is "seven"'),
    ("seed: 7", "sed: 7", "r.yaml:3:1: unknown key 'sed'\n  to do: Did you mean 'seed'?"),
    ("seed: 7", "seed: 1001", "the test scenes would not be unseen"),
    ("seed: 7", "seed: -7", "expected: greater than or equal to 0 (Everything random follows from it)"),
    (
        "[1, 20]",
        "[1]",
        "design.focal_length_mm.between is [1]\n  expected: 2 entries (Lower and upper bound)",
    ),
    ("[1, 20]", "[1, 2, 3]", "expected: at most 2 entries (Lower and upper bound)"),
    (
        "  world: {use",
        "  World: {use",
        'nodes has a key "World"\n  expected: lower-case letters, digits and _',
    ),
    ("name: right", "name: 3", "expected: text ("),
    ("{cameras: [oak_d_pro_wide, flea3, basler_dart],", "{cameras: [],", "expected: at least 1 entry (Names"),
    ("tacos: 1", "tacos: 2", "r.yaml:1:1: tacos is 2"),
    ("name: right\n", "", "'name' is missing"),
    ("rig: {use: rig.monocular,", "rig: {use: rig.monoculr,", "Did you mean 'rig.monocular'?"),
    ("rig: {use: rig.monocular,", "rig: {use: task.orb-features,", "task.orb-features is a task, not a rig"),
    ("binning: 4", "binnig: 4", "unknown key 'binnig'"),
    ("binning: 4", "binning: 0.5", "greater than or equal to 1"),
    ("binning: 4", "pitch_deg: 3", "'pitch_deg' is fixed here and designed under design:"),
    (
        "  focal_length_mm: {between: [1, 20]}\n",
        "",
        "give exactly one of focal_length_mm and lens, not neither",
    ),
    ("focal_length_mm: {", "focal_length_m: {", "rig.monocular has no variable 'focal_length_m'"),
    ("[1, 20]", "[20, 1]", "r.yaml:7:3"),
    ("[1, 20]", "[-1, 20]", "greater than 0"),
    ("[1, 20]", "[1, 1e400]", "r.yaml:7"),
    ("[1, 20]", "[1, .nan]", "r.yaml:7"),
    ("[1, 20]", '["1", 20]', "r.yaml:7"),
    ("[-30, 30]", "[-300, 30]", "greater than or equal to -90"),
    ("from: image_sensors", "from: image_sensor", "Did you mean 'image_sensors'?"),
    ("from: image_sensors", "from: ../../etc/passwd", "r.yaml:8"),
    ("hfov_deg: {max", "hfov: {max", "rig.monocular derives no 'hfov'"),
    ("{max: 140}", "{max: 140, min: 150}", "min 150 is above max 140"),
    ("{max: 140}", "{}", "'hfov_deg' has no bound"),
    ("illumination_lux: 20", "illumination_lux: 20 lux", 'illumination_lux is "20 lux"'),
    ("illumination_lux: 20", "illumination_lux: 0", "greater than 0"),
    ("gain_db: 5", "gain: 5", "unknown key 'scenario.gain'\n  to do: Did you mean 'gain_db'?"),
    (
        "effects: []",
        "effects: []\nstudy: {race: {}}",
        "unknown key 'study.race'\n  to do: Take it out: races ",
    ),
    (
        "test: {seed: 1001}",
        "test: {margin: 0.05, seed: 1001}",
        "unknown key 'test.margin'\n  to do: Use `margins`, which has a difference for each score",
    ),
    ("effects: []", "effects: [{use: effect.vignettin}]", "Did you mean 'effect.vignetting'?"),
    ("frames: 5", "frames: 0", "r.yaml:13:"),
    ("{episode: world}", "{episod: world}", "has no port 'episod'"),
    ("{episode: world}", "{episode: word}", "there is no node 'word'"),
    ("{episode: world}", "{episode: frames}", "r.yaml:14:"),
    (
        "in: {frames: frames}",
        "in: {frames: capture}",
        "takes FrameBatch, but node 'capture' (renderer.toy) gives Capture",
    ),
    (
        "in: {frames: frames}",
        "in: {frames: frames}, train: {weights: shared}",
        "task.orb-features does not learn",
    ),
    (
        "in: {frames: frames}",
        "in: {frames: frames}, train: {weights: some}",
        "'shared', 'branched' or 'frozen'",
    ),
    ("seed: 7", "study: {train_best: 3}\nseed: 7", "r.yaml:3:9: no task is trained in this study"),
    ("seed: 7", "study: {renew_training: each_candidate}\nseed: 7", "no task is trained in this study"),
    ("use: task.orb-features", "use: effect.vignetting", "(effect.vignetting) has no port 'frames'"),
    ("use: task.orb-features", "use: rig.monocular", "rig.monocular cannot be a node\n  expected: a scene,"),
    ("use: task.orb-features", "use: optimizer.genetic", "Put it under optimizer:."),
    ("use: task.orb-features", "use: procedure.diagnose", "A procedure has a recipe of its own"),
    ("use: task.orb-features", "use: task.nothing-here", "install that package"),
    ("calibration: flea3_imx172", "calibration: flea4", "r.yaml:15:62: flea4: no noise"),
    ("score: features.inliers,", "score: features.inlier,", "Did you mean 'features.inliers'?"),
    ("score: features.inlier_ratio", "score: features.inliers", "stands twice"),
    ("weight: 0.5", 'weight: "0.5"', "expected: a number"),
    ("population: 10", "population: ten", "r.yaml:20"),
    ("use: optimizer.genetic", "use: optimizer.genetics", "Did you mean 'optimizer.genetic'?"),
    ("use: executor.local", "use: executor.cloud", "no component 'executor.cloud'"),
    ("basler_dart]", "basler]", "basler_dart"),
    ("basler_dart]", "zed_2i]", "which rig.monocular does not have"),
    ("evaluations: 30", "evaluations: 0", "greater than or equal to 1"),
    ("tacos: 1", "tacos: 1\ntacos: 1", "r.yaml:2:1"),
    ("seed: 7", "seed: !!python/object:os.system 7", "r.yaml:3"),
    ("seed: 7", "seed: &a 7", "r.yaml:3"),
    ("effects: []", "effects: [", "r.yaml:"),
]


@pytest.mark.parametrize(
    ("old", "new", "message"), WRONG, ids=[f"{o.strip()}->{n.strip()}" for o, n, _ in WRONG]
)
def test_every_mistake_is_reported_with_its_place(toys, old, new, message):
    assert RIGHT.count(old) >= 1
    faults = faults_of(RIGHT.replace(old, new, 1), toys)
    assert any(message in fault for fault in faults), "\n\n".join(faults)
    assert all(fault.startswith("r.yaml:") for fault in faults)


def test_all_mistakes_of_a_recipe_come_at_once_in_the_order_of_the_file(toys):
    text = RIGHT
    chosen = [
        ("seed: 7", "sed: 7"),
        ("binning: 4", "binnig: 4"),
        ("[1, 20]", "[20, 1]"),
        ("hfov_deg: {max", "hfov: {max"),
        ("gain_db: 5", "gain: 5"),
        ("{episode: world}", "{episode: word}"),
        ("calibration: flea3_imx172", "calibration: flea4"),
        ("score: features.inliers,", "score: features.inlier,"),
        ("use: optimizer.genetic", "use: optimizer.genetics"),
        ("basler_dart]", "basler]"),
    ]
    for old, new in chosen:
        text = text.replace(old, new, 1)
    faults = faults_of(text, toys)
    lines = [int(fault.split(":")[1]) for fault in faults]
    assert lines == sorted(lines)
    assert set(lines) == {3, 4, 7, 9, 10, 14, 15, 18, 20, 22}


@pytest.mark.parametrize(("seed", "line"), [("seed: -7", "3"), ("seed: 1001", "23")])
def test_a_wrong_seed_is_told_with_faults_of_other_sections(toys, seed, line):
    text = RIGHT.replace("seed: 7", seed, 1).replace("evaluations: 30", "evaluation: 30", 1)
    assert {fault.split(":")[1] for fault in faults_of(text, toys)} == {line, "22"}


def test_a_seed_that_cannot_be_read_clashes_with_none(toys):
    text = RIGHT.replace("seed: 7", "seed: seven", 1).replace("seed: 1001", "seed: 0")
    assert len(faults_of(text, toys)) == 1


def test_python_recipes_get_dotted_places(toys):
    recipe, _ = parse_recipe(RIGHT)
    data = recipe.as_data()
    data["constraints"] = {"hfov": {"max": 3}}
    with pytest.raises(UserError, match=r"recipe\.constraints\.hfov"):
        make_plan(Recipe.model_validate(data), toys)


def test_relative_paths_start_from_the_folder_of_the_recipe(toys, tmp_path, monkeypatch):
    from tacos_framework.packaged_resources import shipped_folder
    from tacos_framework.recipe.loading import read_any_recipe

    (tmp_path / "mine").mkdir()
    shipped = shipped_folder("catalogs") / "noise" / "flea3_imx172.yaml"
    (tmp_path / "mine" / "own.yaml").write_text(shipped.read_text())
    (tmp_path / "mine" / "r.yaml").write_text(RIGHT.replace("flea3_imx172", "own.yaml"))
    monkeypatch.chdir(tmp_path)
    recipe, faults = read_any_recipe(tmp_path / "mine" / "r.yaml")
    config = make_plan(recipe, toys, faults).nodes["frames"].config
    assert config.calibration == str(tmp_path / "mine" / "own.yaml")


EMVA = RIGHT.replace("use: sensor.affine-noise", "use: sensor.emva").replace(
    ", calibration: flea3_imx172", ""
)


def test_a_sensor_that_knows_enough_of_no_camera_says_what_it_lacks(toys):
    further = EMVA.replace("{from: image_sensors}", "{from: image_sensors_more, scheme: discrete}")
    (fault,) = faults_of(further, toys)
    assert fault.startswith("r.yaml:15:3: sensor.emva does not know dark_current_e_s (electrons per second")
    assert "of 47 tried there is none" in fault
    assert "Give the missing figures as settings of the node" in fault


def test_a_task_that_can_judge_no_camera_says_why(toys):
    (fault,) = faults_of(
        RIGHT.replace("task.orb-features", "task.sgbm")
        .replace("inliers", "d1")
        .replace("inlier_ratio", "rmse_m"),
        toys,
    )
    assert fault.startswith(
        "r.yaml:16:3: stereo needs two cameras, and the rig has one: camera (see rig.stereo)"
    )
    assert "expected: cameras it can judge; of 43 tried there is none" in fault
    assert "Choose another rig, or other values of its variables." in fault


@pytest.mark.parametrize(
    "known",
    [
        "quantum_efficiency: 0.5, dark_current_e_s: 5",  # the catalog knows the rest of some sensors
        "quantum_efficiency: 0.5, dark_current_e_s: 5, full_well_e: 9000, read_noise_e: 3",
    ],
)
def test_a_sensor_that_knows_enough_of_some_camera_has_no_fault(toys, known):
    assert plan(EMVA.replace("in: {capture: capture}}", f"in: {{capture: capture}}, {known}}}"), toys).nodes


def test_what_yaml_refuses_is_told_among_all_other_faults_and_once(toys):
    text = RIGHT
    for old, new in [
        ("seed: 7", "seed: .nan"),
        ("binning: 4", "binning: .inf, binnig: 4"),
        ("[1, 20]", "[1, -.inf]"),
        ("{max: 140}", "{max: 140, max: 150}"),
        ("gain_db: 5", "gain_db: 1e999"),
        ("frames: 5", "frames: &n 0"),
        ("{episode: world}", "{episode: word}"),
        ("calibration: flea3_imx172", "calibration: .nan"),
        ("weight: 0.5", "weight: .NaN"),
        ("population: 10", "population: *n"),
    ]:
        assert old in text
        text = text.replace(old, new, 1)
    faults = [fault.splitlines()[0] for fault in faults_of(text, toys)]
    assert faults == [
        "r.yaml:3:7: .nan is not a number that can be used",
        "r.yaml:4:36: .inf is not a number that can be used",
        "r.yaml:4:42: unknown key 'binnig'",
        "r.yaml:7:34: -.inf is not a number that can be used",
        "r.yaml:9:36: key 'max' stands here again, first in line 9",
        "r.yaml:10:43: 1e999 is too large for a number",
        "r.yaml:13:27: frames is 0",
        "r.yaml:13:35: anchor &n is not supported",
        "r.yaml:14:37: there is no node 'word'",
        "r.yaml:15:75: .nan is not a number that can be used",
        "r.yaml:19:44: .NaN is not a number that can be used",
        "r.yaml:20:49: alias *n is not supported",
    ]


def test_a_node_or_variable_at_fault_brings_no_faults_of_what_leads_to_it(toys):
    (fault,) = faults_of(RIGHT.replace("use: sensor.affine-noise", "use: 7"), toys)
    assert "nodes.frames.use is 7" in fault
    (fault,) = faults_of(RIGHT.replace("[1, 20]", '["1", 20]'), toys)
    assert "design.focal_length_mm.between.0" in fault


def test_a_design_variable_that_is_a_plain_value_says_how_to_fix_it(toys):
    (fault,) = faults_of(RIGHT.replace("pitch_deg: {between: [-30, 30]}", "pitch_deg: 5"), toys)
    assert fault.startswith(
        "r.yaml:6:3: design.pitch_deg is 5\n  expected: an entry such as {between: [1, 2]}"
    )
    assert "move it under rig:" in fault


def test_a_procedure_s_recipe_tells_all_its_faults_too():
    class Offer:
        @hookimpl
        def tacos_components(self):
            return [Component("procedure", "count", "toy_procedure:Counting", summary="Counts.")]

    plugins = Plugins.discover()
    plugins.register(Offer())
    text = (
        "tacos: 1\nuse: procedure.count\nseed: .nan\nfoo: 1\n"
        "executor: {use: executor.process, workers: .inf}\nlimit: 0\n"
    )
    recipe, faults = procedure_from(read_yaml_draft(text, name="p.yaml"), {"name": 3}, ())
    with pytest.raises(UserError) as caught:
        plan_procedure(recipe, plugins, faults)
    found = [str(fault).splitlines()[0] for fault in caught.value.faults]
    assert "--set name: name is 3" in found
    assert "p.yaml:3:7: .nan is not a number that can be used" in found
    assert "p.yaml:5:44: .inf is not a number that can be used" in found
    assert "p.yaml:4:1: unknown key 'foo'" in found
    assert "p.yaml:6:1: limit is 0" in found
    assert sum("p.yaml:3" in fault or "p.yaml:5" in fault for fault in found) == 2
