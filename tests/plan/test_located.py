"""The recipe in a results folder: its files are found from there."""

from __future__ import annotations

from pathlib import Path

from toy_study import FROM_CATALOG, run

from tacos_framework.plan import make_plan
from tacos_framework.plan.located import located_recipe
from tacos_framework.recipe import load_recipe
from tacos_framework.settings.yaml_writer import to_yaml


def test_a_catalog_beside_the_recipe_is_found_from_the_results(toys, tmp_path: Path) -> None:
    (tmp_path / "ours.csv").write_text(
        "name,width_px,height_px,pixel_um\nsmall,2048,1024,1\nlarge,4096,2048,1\n"
    )
    design = {"focal_length_mm": {"between": [1, 20]}, "sensor": {"from": "ours.csv"}}
    (tmp_path / "study.yaml").write_text(to_yaml({**FROM_CATALOG, "design": design}))
    recipe = load_recipe(tmp_path / "study.yaml")
    run(recipe, toys, tmp_path / "runs" / "out")
    again = make_plan(load_recipe(tmp_path / "runs" / "out" / "recipe.yaml"), toys)
    assert located_recipe(again)["design"]["sensor"]["from"] == str(tmp_path / "ours.csv")
    assert located_recipe(again) == located_recipe(make_plan(recipe, toys))


def test_names_of_shipped_catalogs_stay(toys, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "image_sensors").mkdir()  # no path, whatever lies there
    (tmp_path / "study.yaml").write_text(to_yaml(FROM_CATALOG))
    plan = make_plan(load_recipe(tmp_path / "study.yaml"), toys)
    assert located_recipe(plan)["design"] == plan.recipe.as_data()["design"]
