"""The camera's processing as a recipe states it: nothing but effects at their stages."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_framework.errors import UserError
from tacos_framework.packaged_resources import shipped_folder
from tacos_framework.plan import make_plan
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Recipe, parse_recipe
from tacos_framework.simulation import EpisodeSpec, Simulation
from tests.two_boxes import SENSOR, monocular_recipe, plugins_with_boxes

GAMMA = {"use": "effect.tone-curve", "gamma": 0.4545}
JPEG = {"use": "effect.jpeg", "quality": 80}
CAMERA = {"focal_length_mm": 0.6, "pitch_deg": -5.0}
SPEC = EpisodeSpec(7, ("design", 0), 1)
FRAMES = {"use": "sensor.camera", "in": {"capture": "capture"}}


@pytest.fixture(scope="module")
def plugins() -> Plugins:
    return plugins_with_boxes()


def with_sensor(**sections: object) -> Recipe:
    recipe = monocular_recipe(**sections).as_data()
    recipe["nodes"]["frames"] = FRAMES
    return Recipe.model_validate(recipe)


def image(recipe: Recipe, plugins: Plugins) -> np.ndarray:
    simulation = Simulation(make_plan(recipe, plugins))
    return next(iter(simulation.batches("features", CAMERA, SPEC))).images[0]


def test_a_pipeline_is_its_effects(plugins: Plugins) -> None:
    written = {"tone-curve": {"gamma": 0.4545}, "jpeg": {"quality": 80}}
    of_pipeline = image(with_sensor(pipeline=written), plugins)
    np.testing.assert_array_equal(of_pipeline, image(with_sensor(effects=[JPEG, GAMMA]), plugins))
    assert np.any(of_pipeline != image(with_sensor(), plugins))


def test_named_pipelines_are_written_out_and_may_be_changed() -> None:
    coded = monocular_recipe(pipeline="coded")
    assert list(coded.pipeline) == ["demosaic", "tone-curve"]
    changed = monocular_recipe(pipeline={"from": "jpeg", "jpeg": {"quality": 50}}).pipeline
    assert changed["jpeg"] == {"quality": 50}
    assert "sharpening" in changed
    assert Recipe.model_validate(coded.as_data()) == coded
    assert coded.effect_names == ("demosaic", "tone-curve")


def test_a_variable_of_the_design_reaches_a_step(plugins: Plugins) -> None:
    recipe = with_sensor(
        pipeline="jpeg",
        design={
            "focal_length_mm": {"between": [0.5, 0.7]},
            "effects.jpeg.quality": {"between": [10, 90], "integer": True},
        },
    )
    plan = make_plan(recipe, plugins)
    assert plan.target("effects.jpeg.quality").owner == "jpeg"


@pytest.mark.parametrize("colour", ["mono", "colour"])
def test_one_pipeline_serves_mono_and_colour_parts(colour: str, plugins: Plugins) -> None:
    pipeline = {"from": "jpeg", "white-balance": {"red": 1.5, "blue": 2.0}}
    rig = {"use": "rig.monocular", "binning": 1, "sensor": {**SENSOR, "colour": colour}}
    frame = Simulation(make_plan(with_sensor(pipeline=pipeline, rig=rig), plugins)).sample(CAMERA, SPEC, 0)
    assert frame.images[0].shape[-1] == (1 if colour == "mono" else 3)
    assert frame.coded


def said(recipe: Recipe, plugins: Plugins) -> str:
    with pytest.raises(UserError) as caught:
        make_plan(recipe, plugins)
    return "\n".join(map(str, caught.value.faults))


def test_what_acts_before_there_are_files_is_refused(plugins: Plugins) -> None:
    found = said(with_sensor(pipeline={"vignetting": {}}), plugins)
    assert "effect.vignetting acts in the stage optics, before there are files" in found
    assert "Put it under effects:" in found


def test_yaml_may_name_a_pipeline_and_is_told_of_names_that_are_not_shipped() -> None:
    text = (shipped_folder("recipes") / "stereo_quick.yaml").read_text()
    recipe, faults = parse_recipe(text)
    assert not faults
    assert recipe.pipeline == monocular_recipe(pipeline="coded").pipeline
    _, (fault,) = parse_recipe(text.replace("pipeline: coded", "pipeline: codes"))
    assert "no pipeline of this name is shipped" in str(fault)


def test_a_task_that_wants_linear_files_is_not_given_coded_ones(plugins: Plugins) -> None:
    features = {"use": "task.orb-features", "in": {"frames": "frames"}, "images": "linear"}
    data = with_sensor(pipeline="coded").as_data()
    data["nodes"]["features"] = features
    found = said(Recipe.model_validate(data), plugins)
    assert "task.orb-features wants linear files, and tone-curve codes them for a display" in found
    assert "pipeline: raw" in found
    data["pipeline"] = "raw"
    assert make_plan(Recipe.model_validate(data), plugins)
