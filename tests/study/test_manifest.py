"""A run that goes on with other code, versions, catalogs or weights than it was begun with."""

from __future__ import annotations

import sys
import types

import pytest
from toy_study import comparable, run, toy_recipe

from tacos_framework.errors import UserError
from tacos_framework.plan import make_plan
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Recipe, load_recipe
from tacos_framework.settings.yaml_writer import to_yaml
from tacos_framework.store import dependencies
from tacos_framework.store.dependencies import manifest_of_study
from tacos_framework.store.manifest import Manifest
from tests.toy_study import FROM_CATALOG


def changes(before: Manifest, **changed) -> list[str]:
    return before.changes(before.model_copy(update=changed))


@pytest.fixture(scope="module")
def of_toys(toys):
    return manifest_of_study(make_plan(toy_recipe(), toys))


def test_every_difference_is_a_sentence(of_toys):
    code = {**of_toys.code, "toy_plugin": {"toy_plugin.py": "0"}}
    assert changes(of_toys, code=code) == ["the code of toy_plugin is not the same: toy_plugin.py changed"]
    assert changes(of_toys, python="2.7") == [f"Python is 2.7, and was {of_toys.python}"]
    numpy = {**of_toys.packages, "numpy": "1"}
    assert changes(of_toys, packages=numpy) == [f"numpy is 1, and was {of_toys.packages['numpy']}"]
    assert changes(of_toys) == []


def test_a_changed_plugin_is_refused_and_taken_where_that_is_wanted(toys, tmp_path, monkeypatch):
    result = run(toy_recipe(), toys, tmp_path)
    monkeypatch.setattr(dependencies, "_code_of", lambda package: {f"{package}.py": "changed"})
    with pytest.raises(UserError, match="the code of toy_plugin is not the same") as caught:
        run(toy_recipe(), toys, tmp_path, resume=True)
    assert "--accept-changes" in str(caught.value)
    taken = run(toy_recipe(), toys, tmp_path, resume=True, accept_changes=True)
    assert any("The study went on although" in note and "toy_plugin" in note for note in taken["notes"])
    again = run(toy_recipe(), toys, tmp_path, resume=True)  # from now on this code is the run's own
    assert again["notes"] == taken["notes"]
    assert {**comparable(taken), "notes": result["notes"]} == comparable(result)


def test_a_part_of_a_catalog_that_has_changed_is_named(toys, tmp_path):
    catalog = tmp_path / "ours.csv"
    rows = "name,width_px,height_px,pixel_um\nsmall,2048,1024,1\nlarge,4096,2048,1\n"
    catalog.write_text(rows)
    data = {
        **FROM_CATALOG,
        "design": {"focal_length_mm": {"between": [1, 20]}, "sensor": {"from": str(catalog)}},
    }
    before = manifest_of_study(make_plan(Recipe.model_validate(data), toys))
    catalog.write_text(rows.replace("large,4096", "large,6144"))
    now = manifest_of_study(make_plan(Recipe.model_validate(data), toys))
    assert before.changes(now) == ["the catalog ours is not the same: large changed"]


def test_files_that_settings_name_are_in_it(toys):
    data = toy_recipe().as_data()
    data["nodes"] |= {
        "capture": {"use": "renderer.moderngl", "in": {"episode": "world"}},
        "frames": {"use": "sensor.affine-noise", "in": {"capture": "capture"}, "calibration": "flea3_imx172"},
        "world": {"use": "scene.indoor"},
        "width": {"use": "task.orb-features", "in": {"frames": "frames"}},
    }
    data["fitness"] = [{"score": "width.inliers", "weight": 1}]
    found = manifest_of_study(make_plan(Recipe.model_validate(data), toys))
    assert set(found.files) == {"frames.calibration: flea3_imx172.yaml"}


def test_code_is_that_of_the_packages_in_use(of_toys):
    assert {"tacos_framework", "toy_plugin", "tacos_plugins"} == set(of_toys.code)
    assert "store/manifest.py" in of_toys.code["tacos_framework"]
    assert not any("__pycache__" in name for files in of_toys.code.values() for name in files)
    assert sys.version.startswith(of_toys.python)
    assert to_yaml(of_toys.model_dump(mode="json"))


def test_a_module_that_was_made_by_hand_has_no_files(monkeypatch):
    monkeypatch.setitem(sys.modules, "zz_made", types.ModuleType("zz_made"))
    assert dependencies._code_of("zz_made") == {}


def test_all_that_a_recipe_names_is_in_the_manifest_but_what_evaluates_it():
    plan = make_plan(load_recipe("headset_exposure"), Plugins.discover())
    assert {"rig", "optimizer", "exposure"} < set(plan.parts)
    assert plan.parts["exposure"] is plan.exposure
    assert plan.executor not in plan.parts.values()
