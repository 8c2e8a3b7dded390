"""Whole cameras in a recipe: chosen, compared, bounded, and what of a recipe they stand for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from toy_study import FROM_CATALOG

from tacos_framework.catalog import load_cameras
from tacos_framework.errors import UserError
from tacos_framework.plan import Plan, make_plan
from tacos_framework.plan.notes import notes_on_catalogs
from tacos_framework.recipe import NamedScenario, Recipe, Scenario
from tacos_framework.variables import CatalogChoice

PI = "raspberry_pi_camera_module_v2"


def recipe(**sections: Any) -> Recipe:
    data = {
        **FROM_CATALOG,
        "design": {"pitch_deg": {"between": [-30, 30]}, "camera": {"from": "cameras"}},
        "rig": {"use": "rig.monocular", "binning": 64},
        "constraints": {},
        "scenario": {"exposure_ms": 10},
        **sections,
    }
    return Recipe.model_validate(data)


def choice_of(plan: Plan) -> CatalogChoice:
    (found,) = (each for each in plan.space.variables if isinstance(each, CatalogChoice))
    return found


def faults_of(toys: Any, **sections: Any) -> list[str]:
    with pytest.raises(UserError) as caught:
        make_plan(recipe(**sections), toys)
    return [f"{fault.where}: {fault.what} {fault.remedy}" for fault in caught.value.faults]


def test_a_camera_is_a_choice_of_its_own(toys: Any) -> None:
    choice = choice_of(make_plan(recipe(), toys))
    assert choice.scheme == "discrete"
    assert {row["kind"] for row in choice.rows} == {"mono"}
    assert PI in {row.name for row in choice.rows}


def test_products_that_cannot_be_simulated_are_counted_with_the_reason(toys: Any) -> None:
    plan = make_plan(recipe(), toys)
    notes = list(notes_on_catalogs(plan))
    assert notes[0].startswith("57 of 134 parts of cameras cannot be chosen, hfov_deg unknown: ")
    assert any("its kind is stereo, not mono: luxonis_oak_d_stereo_pair" in note for note in notes)
    assert sum(int(note.split()[0]) for note in notes) + len(choice_of(plan).rows) == 134


def test_products_are_chosen_by_their_columns_and_by_what_follows(toys: Any) -> None:
    bounds = {"camera.shutter": {"is": "rolling"}, "mass_g": {"max": 200, "unknown": "refuse"}}
    plan = make_plan(recipe(constraints=bounds), toys)
    assert {row["shutter"] for row in choice_of(plan).rows} == {"rolling"}
    for row in choice_of(plan).rows:
        values = {"pitch_deg": 0.0, "camera": row.as_dict()}
        broken = {breach.quantity for breach in plan.breaches(values, plan.derived(values))}
        assert ("mass_g" in broken) == (row["mass_g"] is None)


def test_a_product_keeps_its_own_f_number(toys: Any) -> None:
    plan = make_plan(recipe(), toys)
    for name, expected in ((PI, 2.0), ("luxonis_oak_1", 2.8)):
        row = choice_of(plan).catalog.part(name)
        variables = plan.rig_variables({"pitch_deg": 0.0, "camera": row.as_dict()})
        assert plan.exposure_in(Scenario(f_number=2.8), variables).f_number == expected


def test_products_are_compared_with_a_design_of_sensor_and_lens(toys: Any) -> None:
    design = {key: FROM_CATALOG["design"][key] for key in ("focal_length_mm", "pitch_deg", "sensor")}
    plan = make_plan(recipe(design=design, compare={"cameras": [PI, "flea3"]}), toys)
    product, flea3 = plan.cameras
    assert plan.free_of(product).names == plan.free_of(flea3).names == ("pitch_deg",)
    assert plan.derived({**product.fixes, "pitch_deg": 0.0})["hfov_deg"] == pytest.approx(62.2)


def test_the_paper_s_cameras_are_compared_with_a_chosen_one(toys: Any) -> None:
    plan = make_plan(recipe(compare={"cameras": ["flea3"]}), toys)
    assert plan.free_of(plan.cameras[0]).names == ("pitch_deg",)
    assert plan.derived({**plan.cameras[0].fixes, "pitch_deg": 0.0})["hfov_deg"] == pytest.approx(
        81.46, abs=0.01
    )


def test_a_product_without_pixels_cannot_be_compared(toys: Any) -> None:
    said = faults_of(toys, compare={"cameras": ["balluff_bvs_ca_gx0_0124d"]})
    assert "camera 'balluff_bvs_ca_gx0_0124d' cannot be simulated: 'width_px' is missing" in said[0]


def test_a_stereo_product_is_none_of_a_single_camera(toys: Any) -> None:
    (said, *_) = faults_of(toys, compare={"cameras": ["luxonis_oak_d_stereo_pair"]})
    assert "its kind is stereo, not mono" in said


def test_a_frame_rate_that_exposures_cannot_keep_is_said(toys: Any) -> None:
    bounds = {"frame_rate_fps": {"min": 30, "unknown": "refuse"}}
    make_plan(recipe(constraints=bounds), toys)
    (said,) = faults_of(toys, constraints=bounds, scenario={"exposure_ms": 40})
    assert "recipe.constraints.frame_rate_fps: none of" in said
    assert "frame_rate_fps is 25, below the smallest allowed value 30 (exposures leave no more)" in said


def test_an_exposure_no_camera_can_take_is_said(toys: Any) -> None:
    scenario = [NamedScenario(name="day", exposure_ms=0.001), NamedScenario(name="night", exposure_ms=10)]
    plan = make_plan(recipe(scenario=scenario), toys)
    row = choice_of(plan).catalog.part(PI)
    values = {"pitch_deg": 0.0, "camera": row.as_dict()}
    (breach,) = plan.breaches(values, plan.derived(values))
    assert breach.sentence == (
        "exposure_min_us is 75.6, above the largest allowed value 1 (an exposure is 0.001 ms)"
    )


def test_what_a_recipe_states_of_a_camera_counts(toys: Any) -> None:
    own = {"name": "mine", "width_px": 640, "height_px": 480, "pixel_um": 5.0, "hfov_deg": 60.0}
    rig = {"use": "rig.monocular", "camera": {**own, "price_gbp": 250.0, "mass_g": 90.0}}
    bounds = {"price_gbp": {"max": 300}, "camera.mass_g": {"max": 50}}
    design = {"pitch_deg": {"between": [-30, 30]}}
    (said,) = faults_of(toys, rig=rig, design=design, constraints=bounds)
    assert "camera.mass_g of mine is 90, above the largest allowed value 50" in said


def test_products_of_a_user_are_read_like_those_that_ship(tmp_path: Path) -> None:
    text = """title: Ours
source: us
rigs: {mono: rig.monocular}
columns:
  kind: {type: text, help: Kind.}
  width_px: {type: integer, help: Width.}
  height_px: {type: integer, help: Height.}
  pixel_um: {help: Pitch.}
  hfov_deg: {help: Field of view.}
parts:
  ours: {kind: mono, width_px: 640, height_px: 480, pixel_um: 5, hfov_deg: 60}
"""
    (tmp_path / "ours.yaml").write_text(text)
    (found,) = load_cameras(["ours"], "ours.yaml", tmp_path)
    assert (found.rig, found.fixes["camera"]["hfov_deg"], found.sources) == (
        "rig.monocular",
        60.0,
        found.sources,
    )
    (tmp_path / "ours.yaml").write_text(text.replace("rigs: {mono: rig.monocular}\n", ""))
    with pytest.raises(UserError, match="nothing says which rig takes these cameras"):
        load_cameras(["ours"], "ours.yaml", tmp_path)
