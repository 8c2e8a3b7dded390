"""The recipes of tables that are shipped: their cameras, scores and weights are there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import save_file

from tacos_framework import ProcedureRecipe, Recipe, UserError, load_recipe
from tacos_framework.plan.procedure import plan_procedure
from tacos_framework.plugins import Plugins
from tacos_validation.studies_table.table import StudiesTable

TABLES = ("stereo_compared", "stereo_start", "stereo_population", "stereo_parents", "headset_compared")


PRETRAINED = {
    "headset_compared": ("detect", "detector_resnet50", "pretrain_detector_resnet50"),
    "stereo_compared": ("stereo", "stereo_psmnet", "pretrain_stereo_psmnet"),
}


@pytest.fixture
def pretrained(tmp_path, monkeypatch):
    """A folder in which the pre-training recipes have left their weights, as the recipes' comments say."""
    for _, out, name in PRETRAINED.values():
        made = load_recipe(name)
        assert isinstance(made, ProcedureRecipe)
        file = tmp_path / "runs" / out / "weights" / f"{made.settings['file']}.safetensors"
        file.parent.mkdir(parents=True)
        save_file({"weight": np.zeros(1, np.float32)}, file)
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("name", PRETRAINED)
def test_frozen_rows_start_from_what_a_shipped_recipe_makes(name, pretrained):
    node, _, makes = PRETRAINED[name]
    table, made = load_recipe(name), load_recipe(makes)
    assert isinstance(table, ProcedureRecipe)
    assert isinstance(made, ProcedureRecipe)
    assert made.settings["problem"] == table.settings["problem"]
    assert Path(table.settings["change"][f"nodes.{node}.weights"]).is_file()
    frozen = [study for study in table.settings["studies"] if "frozen" in study]
    assert frozen
    plan_procedure(table, Plugins.discover())


@pytest.mark.parametrize("name", PRETRAINED)
def test_without_these_weights_the_check_says_once_what_is_missing(name):
    recipe = load_recipe(name)
    assert isinstance(recipe, ProcedureRecipe)
    with pytest.raises(UserError, match="there is no file runs") as raised:
        plan_procedure(recipe, Plugins.discover())
    (fault,) = raised.value.faults
    assert "more like it" in fault.where
    assert "procedure.pretrain" in fault.remedy


@pytest.mark.parametrize("name", PRETRAINED)
def test_frozen_rows_from_random_weights_are_refused(name):
    recipe = load_recipe(name, {"change": {}})
    assert isinstance(recipe, ProcedureRecipe)
    with pytest.raises(UserError, match="never trained: weights is none"):
        plan_procedure(recipe, Plugins.discover())


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.usefixtures("pretrained")
def test_shipped_tables_name_studies_cameras_and_scores_there_are(name):
    recipe = load_recipe(name)
    assert isinstance(recipe, ProcedureRecipe)
    table = StudiesTable(StudiesTable.Config.model_validate(recipe.settings))
    values = [column.value for column in table.config.columns]
    wanted = {value.removeprefix("test.") for value in values if value.startswith("test.")}
    planned, _ = table.plan(Plugins.discover())
    assert planned
    for study in planned:
        nodes = study.plan.nodes
        scores = {f"{name}.{s}" for name in nodes for s in getattr(nodes[name].cls, "scores", ())}
        assert wanted <= {"fitness", *scores}


@pytest.mark.usefixtures("pretrained")
def test_the_second_table_s_nights_are_those_of_headset_night():
    recipe = load_recipe("headset_compared")
    assert isinstance(recipe, ProcedureRecipe)
    table = StudiesTable(StudiesTable.Config.model_validate(recipe.settings))
    planned, _ = table.plan(Plugins.discover())
    (night,) = (study.recipe for study in planned if study.name == "night_quantized_joint")
    alone = load_recipe("headset_night")
    assert isinstance(alone, Recipe)
    data = night.as_data()
    data["nodes"]["detect"]["weights"] = "none"  # the table names weights, the study alone leaves them open
    differing = {key for key, value in data.items() if value != alone.as_data()[key]}
    assert differing == {"name"}
