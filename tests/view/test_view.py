"""``tacos view``: what it writes, and what it refuses."""

from __future__ import annotations

import logging
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_framework.camera.geometry import project
from tacos_framework.catalog import find_catalog
from tacos_framework.cli import tacos_main
from tacos_framework.cli.terminal import log_on_terminal
from tacos_framework.errors import UserError
from tacos_framework.plugins import Plugins
from tacos_view import render, set_up
from tacos_view.catalog_sheet import Outline, arranged, outlines
from tacos_view.effect_ladder import effect_ladder
from tacos_view.floor_plan import floor_plan
from tacos_view.pages import write_ladder, write_rendering
from tacos_view.pictures import contact_sheet, shown_depth, shown_objects
from tacos_view.recipes import study_recipe
from tests.two_boxes import monocular_recipe, plugins_with_boxes

CAMERA = {"focal_length_mm": 0.6, "pitch_deg": -5.0}


def test_a_scene_and_its_frames_are_written(tmp_path: Path) -> None:
    shot = render(monocular_recipe(), CAMERA, frames=2, plugins=plugins_with_boxes())
    page = write_rendering(tmp_path, shot, "two boxes", ("pitch_deg",))
    assert {path.name for path in tmp_path.iterdir()} == {
        "index.html",
        "plan.png",
        *(f"frame_{i}{kind}.png" for i in (1, 2) for kind in ("", "_depth", "_objects")),
    }
    text = page.read_text("utf-8")
    assert "2 labelled objects of 2 classes" in text
    for name in ("background", "chair", "cup"):
        assert f"</i>{name}</li>" in text
    assert "dog" not in text
    assert "pitch_deg is not set; using the middle of its range" in text
    assert "://" not in text.replace("http://www.w3.org", "")


def test_the_plan_is_open_below_the_ceiling_and_shows_what_stands_where(tmp_path: Path) -> None:
    shot = render(monocular_recipe(), CAMERA, plugins=plugins_with_boxes())
    picture = floor_plan(shot.world, shot.trajectory, shot.world_from_camera, shot.camera, widest_px=740)
    px_per_m = 740 / 7.4  # the room is 7 m long, and 0.2 m is left around it
    assert picture.shape == (640, 740, 3)

    def at(x_m: float, y_m: float) -> np.ndarray:
        return picture[round((3.2 - y_m) * px_per_m), round((x_m + 2.2) * px_per_m)]

    floor, cup_wall, wall = at(-1.0, 2.0), at(2.0, -0.75), at(-2.0, 1.0)
    assert floor.min() > 120  # no ceiling over it
    assert wall.max() < 90
    assert cup_wall.max() < 90  # the cup is cut 1.5 m above the floor


def test_a_ladder_rises(tmp_path: Path) -> None:
    plugins = plugins_with_boxes()
    setup = set_up(monocular_recipe(), CAMERA, plugins=plugins)
    ladder = effect_ladder(setup, "vignetting", {}, plugins)
    assert [step.label for step in ladder.steps] == ["off", "k1 -0.2", "k1 -0.4", "k1 -0.8"]
    corners = [float(step.frame[:4, :4].mean()) for step in ladder.steps]
    assert corners == sorted(corners, reverse=True)
    assert len(set(corners)) == 4
    write_ladder(tmp_path, ladder, "two boxes")
    assert (tmp_path / "step_3_difference.png").is_file()


def test_off_is_the_frame_itself_and_the_noise_stays() -> None:
    plugins = plugins_with_boxes()
    setup = set_up(monocular_recipe(), CAMERA, plugins=plugins)
    given_settings = effect_ladder(setup, "effect.exposure-error", {"scale": 2.0}, plugins)
    off, *rest = given_settings.steps
    assert [step.label for step in rest] == ["scale 1.25", "scale 1.5", "scale 2"]
    assert (off.difference == 127).all()


@pytest.mark.parametrize(
    ("name", "chosen", "said"),
    [
        ("vigneting", {}, "Did you mean"),
        ("vignetting", {"k9": 1.0}, "k9"),
        ("vignetting", {"k1": -99.0}, "k1"),
    ],
)
def test_wrong_effects_are_said(name: str, chosen: dict[str, float], said: str) -> None:
    plugins = plugins_with_boxes()
    setup = set_up(monocular_recipe(), CAMERA, plugins=plugins)
    with pytest.raises(UserError, match=said):
        effect_ladder(setup, name, chosen, plugins)


def test_a_catalog_is_drawn_to_scale(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert tacos_main(["view", "image_sensors", "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().out == f"Look at {tmp_path / 'index.html'}\n"
    assert cv2.imread(str(tmp_path / "image_sensors.png")) is not None
    by_name = {each.name: each for each in outlines(find_catalog("image_sensors"))}
    assert len(by_name) == 43
    assert by_name["IMX219"].width_mm == pytest.approx(3280 * 1.12e-3)


def test_lenses_are_circles() -> None:
    drawn = outlines(find_catalog("lenses"))
    assert all(each.round for each in drawn)


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(st.floats(0.5, 50), st.floats(0.5, 40)), min_size=1, max_size=12))
def test_no_part_is_drawn_over_another(sizes: list[tuple[float, float]]) -> None:
    placed = arranged([Outline(str(i), "", w, h) for i, (w, h) in enumerate(sizes)])
    assert len(placed) == len(sizes)
    for i, a in enumerate(placed):
        for b in placed[i + 1 :]:
            apart_x = a.x_mm + a.outline.width_mm <= b.x_mm or b.x_mm + b.outline.width_mm <= a.x_mm
            apart_y = a.y_mm + a.outline.height_mm <= b.y_mm or b.y_mm + b.outline.height_mm <= a.y_mm
            assert apart_x or apart_y


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "there is nothing to look at"),
        (["scene.indor"], "Did you mean"),
        (["headset_quik"], "Did you mean 'headset_quick'"),
        (["image_sensor"], "Did you mean 'image_sensors'"),
        (["."], "this folder holds no recipe.yaml"),
        (["nothing-like-it"], "there is nothing of this name to look at"),
        (["headset_quick", "--camera", "flea"], "Did you mean 'flea3'"),
        (["headset_quick", "--set", "a"], "there is no '='"),
        (["headset_quick", "--frames", "0"], "0 frames are none"),
        (["--effect", "vigneting"], "Did you mean"),
    ],
)
def test_it_says_what_is_wrong(
    arguments: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert tacos_main(["view", *arguments, "--out", str(tmp_path / "out")]) == 2
    assert said in capsys.readouterr().err


def test_pictures_of_depth_and_ids() -> None:
    depth = shown_depth(np.array([[1.0, 2.0, np.inf]]))
    assert depth[0, 0].sum() > depth[0, 1].sum() > depth[0, 2].sum() == 0
    ids = shown_objects(np.array([[0, 1, 2, 1, 4]]), np.array([0, 1, 2, 1, 1]))[0].astype(float)
    assert np.array_equal(ids[1], ids[3])
    assert not np.array_equal(ids[1], ids[2])
    assert ids[4] / ids[4].max() == pytest.approx(ids[1] / ids[1].max(), abs=0.02)  # a shade of one class


def test_a_sheet_keeps_small_pictures_sharp() -> None:
    tile = np.random.default_rng(1).integers(0, 255, (10, 12, 3), dtype=np.uint8)
    sheet = contact_sheet([tile, tile, tile], columns=2)
    assert np.array_equal(sheet[:10, :12], tile)
    assert sheet.shape == (26, 30, 3)


def test_wedges_point_where_the_camera_looks() -> None:
    """What lies at the middle of the image lies, from above, along the middle of the wedge."""
    shot = render(monocular_recipe(), CAMERA, plugins=plugins_with_boxes())
    pose = shot.world_from_camera[0]
    ahead = pose[:3, 3] + pose[:3, 2]
    pixel, depth = project(ahead, shot.camera, pose)
    assert pixel.tolist() == pytest.approx(list(shot.camera.centre_px))
    assert depth == pytest.approx(1.0)


def test_settings_of_a_scene_by_itself_need_no_path() -> None:
    plugins = Plugins.discover()
    short = study_recipe("scene.indoor", {"clutter": 0, "rig.binning": 2}, plugins=plugins)
    full = study_recipe("scene.indoor", {"nodes.world.clutter": 0, "rig.binning": 2}, plugins=plugins)
    assert short.as_data() == full.as_data()
    assert short.nodes["world"].settings["clutter"] == 0


def test_a_ladder_of_a_list_has_a_picture_for_each_value_and_one_of_what_has_nothing_between() -> None:
    plugins = plugins_with_boxes()
    setup = set_up(monocular_recipe(), CAMERA, plugins=plugins)
    ladder = effect_ladder(setup, "defocus", {"focus_m": [0.2, 1.0], "f_number": 1.0}, plugins)
    assert [step.settings.get("focus_m") for step in ladder.steps] == [None, 0.2, 1.0]
    single = effect_ladder(setup, "defocus", {"focus_m": 0.2, "f_number": 1.0}, plugins)
    assert len({str(step.settings) for step in single.steps}) == len(single.steps)
    with pytest.raises(UserError, match="focus_m"):
        effect_ladder(setup, "defocus", {"focus_m": [1.0, -2.0]}, plugins)


def test_cameras_of_a_catalog_are_drawn_by_their_sensors(tmp_path: Path) -> None:
    assert tacos_main(["view", "cameras", "--out", str(tmp_path / "shipped")]) == 0
    text = (tmp_path / "shipped" / "index.html").read_text("utf-8")
    assert "FLIR Flea3" in text
    assert "Without a stated size: RealSense D450" in text
    own = tmp_path / "mine.yaml"
    own.write_text(
        "cameras:\n  mine: {title: Mine, maker: me, rig: rig.stereo, fixes: {hfov_deg: 87}, sources: [me]}\n"
    )
    assert tacos_main(["view", str(own), "--out", str(tmp_path / "own")]) == 2


@pytest.mark.parametrize(("lux", "f_number"), [(None, 8.0), (20_000, 8.0), (10, 2.0)])
def test_a_street_by_night_is_not_exposed_as_by_day(lux: float | None, f_number: float) -> None:
    sets = {} if lux is None else {"scenario.illumination_lux": lux}
    recipe = study_recipe("scene.street", sets, plugins=Plugins.discover())
    assert recipe.scenarios[0].f_number == f_number


def test_a_rendering_is_printed_in_a_line() -> None:
    shot = render(monocular_recipe(), CAMERA, frames=2, plugins=plugins_with_boxes())
    assert f"2 frames of {shot.camera.width_px} x {shot.camera.height_px} pixels" in repr(shot)
    assert "\n" not in repr(shot) + repr(shot.first)


def test_what_components_log_is_said_while_the_command_runs(capsys) -> None:
    log = logging.getLogger("tacos_worlds.somewhere")
    with log_on_terminal(["tacos_worlds"]):
        log.info("lighting %d triangles", 7)
    log.info("nobody hears this")
    assert capsys.readouterr().err == "lighting 7 triangles\n"
