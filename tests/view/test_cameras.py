"""The camera a user means, and what is said where there is none."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tacos_framework.errors import UserError
from tacos_framework.plan import Plan, make_plan
from tacos_framework.plugins import Plugins
from tacos_framework.recipe.loading import load_recipe
from tacos_view.cameras import built_rig, choose_camera


@pytest.fixture(scope="module")
def plan() -> Plan:
    return make_plan(load_recipe("headset_quick"), Plugins.discover())


def test_a_product_fixes_what_it_fixes_and_the_rest_is_in_the_middle(plan: Plan) -> None:
    choice = choose_camera(plan, "flea3")
    (camera,) = built_rig(plan, choice).cameras
    assert (choice.title, camera.focal_length_mm, camera.pixel_um) == ("FLIR Flea3", 3.6, 1.55)
    assert (camera.width_px, camera.binning) == (1333, 3)
    assert (choice.values["pitch_deg"], choice.assumed) == (0.0, ("pitch_deg",))


def test_without_a_name_it_is_the_first_product_of_the_recipe(plan: Plan) -> None:
    assert choose_camera(plan).title == "OAK-D Pro Wide (RGB)"


def test_figures_of_ones_own_may_name_a_part_of_the_catalog(plan: Plan) -> None:
    choice = choose_camera(plan, {"focal_length_mm": 5.0, "pitch_deg": -10.0, "sensor": "IMX219"})
    (camera,) = built_rig(plan, choice).cameras
    assert (camera.width_px, camera.focal_length_mm, choice.assumed) == (1093, 5.0, ())


@pytest.mark.parametrize(
    ("camera", "said"),
    [
        ("flea", "Did you mean 'flea3'"),
        ("zed_2i", "ZED 2i is a camera of rig.stereo, and the recipe has rig.monocular"),
        ("zed_2i", "Name one of oak_d_pro_wide, flea3, basler_dart."),
        ({"focal_mm": 3.0}, "Did you mean 'focal_length_mm'"),
        ({"sensor": "IMX21"}, "no part 'IMX21'"),
        ({"focal_length_mm": -1.0}, "rig.monocular refuses it"),
    ],
)
def test_what_is_wrong_is_said(plan: Plan, camera: object, said: str) -> None:
    with pytest.raises(UserError) as caught:
        choose_camera(plan, camera)
    assert said in str(caught.value)


def test_a_run_has_its_designed_camera_and_those_it_was_compared_with(plan: Plan, tmp_path: Path) -> None:
    product = dict(choose_camera(plan, "flea3").values)
    cameras = {
        "designed": {"title": "Designed", "camera": {**product, "focal_length_mm": 2.5}},
        "flea3": {"title": "FLIR Flea3", "camera": product},
    }
    (tmp_path / "result.json").write_text(json.dumps({"cameras": cameras}))
    assert choose_camera(plan, None, tmp_path).values["focal_length_mm"] == 2.5
    assert choose_camera(plan, "flea3", tmp_path).values["focal_length_mm"] == 3.6
    with pytest.raises(UserError, match="Did you mean 'flea3'"):
        choose_camera(plan, "flea33", tmp_path)


def test_an_unfinished_run_is_said(plan: Plan, tmp_path: Path) -> None:
    with pytest.raises(UserError, match="a run that has not ended has none yet"):
        choose_camera(plan, None, tmp_path)
