"""The recipes to buy by: each is whole, and where nothing can be bought or seen none names a winner."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tacos_framework import Recipe, UserError, load_recipe, run
from tacos_framework.plan import make_plan
from tacos_framework.plugins import Plugins

NAMES = (
    "buy_headset",
    "buy_drone",
    "buy_warehouse_tags",
    "buy_car_front",
    "buy_parking",
    "buy_delivery_night",
    "buy_picking_stereo",
)


def recipe_of(name: str, **sets: Any) -> Recipe:
    recipe = load_recipe(name, {key.replace("__", "."): value for key, value in sets.items()})
    assert isinstance(recipe, Recipe)
    return recipe


@pytest.mark.parametrize("name", NAMES)
def test_each_chooses_among_products_and_says_where_its_constants_come_from(
    name: str, plugins: Plugins
) -> None:
    plan = make_plan(recipe_of(name), plugins)
    (camera,) = (each for each in plan.space.variables if each.name == "camera")
    assert len([row for row in camera.rows if row.name not in camera.excluded]) >= 8
    assert len(plan.recipe.notes) >= 2


@pytest.mark.parametrize("name", NAMES)
def test_a_bound_that_no_product_keeps_is_told_with_the_nearest(name: str, plugins: Plugins) -> None:
    with pytest.raises(UserError, match=r"megapixels is .*, above the largest allowed value 0\.01"):
        make_plan(recipe_of(name, constraints__megapixels__max=0.01), plugins)


SMALL = {"optimizer.evaluations": 2, "study.episodes": 1, "study.blocks": 2, "nodes.world.frames": 2}


def small_run(name: str, out: Path, **sets: Any) -> dict[str, Any]:
    small = {**SMALL, "executor": {"use": "executor.local"}, "rig.binning": 6, **sets}
    return run(load_recipe(name, small), out=out)


def test_a_world_without_room_for_tags_is_refused_with_what_to_do(tmp_path: Path) -> None:
    result = small_run("buy_warehouse_tags", tmp_path / "out", **{"nodes.tagged.size_m": 2.0})
    assert result["best"] is None
    assert "no wall of this world takes a marker of 2 m" in result["decision_absent"]
    assert "Give a smaller size_m" in result["decision_absent"]


def test_walks_without_pairs_of_frames_name_no_camera(tmp_path: Path) -> None:
    result = small_run("buy_headset", tmp_path / "out")
    assert result["best"] is None
    assert "No camera could be scored, so none is named" in result["decision_absent"]
    assert "ranking" not in result


@pytest.mark.parametrize(
    "name",
    [
        "buy_headset",
        pytest.param("buy_drone", marks=pytest.mark.slow),
        pytest.param("buy_warehouse_tags", marks=pytest.mark.slow),
    ],
)
def test_darkness_names_no_camera_and_asks_for_light(name: str, tmp_path: Path) -> None:
    dark = {"scenario.illumination_lux": 1e-6, "nodes.world.frames": 4, "nodes.capture.light_texel_m": 0.4}
    result = small_run(name, tmp_path / "out", **dark)
    assert "score zero: the tasks see nothing" in result["degenerate"]
    assert "Give more light" in result["degenerate"]
    assert result["decision"] is None
    assert "ranking" not in result
