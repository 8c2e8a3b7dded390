"""The package as a user meets it: installed, found, run from recipes."""

from __future__ import annotations

from pathlib import Path

import tacos_framework as tacos

RECIPES = Path(__file__).parents[1] / "recipes"


def test_every_component_is_found_and_fits_its_contract() -> None:
    plugins = tacos.Plugins.discover()
    own = [found.component.use for found in plugins if found.distribution == "tacos-example-plugin"]
    assert len(own) == 13
    assert all(plugins.resolve(use) for use in own)


def test_a_camera_is_designed(tmp_path: Path) -> None:
    result = tacos.run(tacos.load_recipe(RECIPES / "find_the_board.yaml"), out=tmp_path / "run")
    assert result["evaluations"] >= 6  # the best are scored again, as weights have moved
    assert result["best"]["scores"]["board.found_ratio"] > 0.5


def test_a_front_end_with_a_value_of_its_own_is_designed_with_the_lens(tmp_path: Path) -> None:
    result = tacos.run(tacos.load_recipe(RECIPES / "keep_the_course.yaml"), out=tmp_path / "run")
    assert set(result["best"]["camera"]) == {"hfov_deg", "tracks.corners"}
    assert result["best"]["scores"]["heading.error_deg"] < 10
    assert result["best"]["scores"]["heading.tracks"] > 20


def test_the_corridor_is_shown(tmp_path: Path) -> None:
    tacos.run(tacos.load_recipe(RECIPES / "look_at_the_corridor.yaml"), out=tmp_path / "run")
    assert (tmp_path / "run" / "preview.png").is_file()
