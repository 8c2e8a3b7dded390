"""Frames in one line: what they hold, and that it is what a study sees."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

import tacos
from tacos_framework.camera.geometry import pixel_rays
from tacos_framework.errors import UserError
from tacos_framework.recipe import Recipe, parse_recipe
from tacos_framework.settings.yaml_writer import to_yaml
from tacos_framework.simulation import EpisodeSpec
from tacos_view import Rendering, render, set_up
from tacos_view.cameras import built_rig
from tacos_view.rendering import CameraFrames
from tests.two_boxes import monocular_recipe, plugins_with_boxes, stereo_recipe
from tests.view.two_ports import plugins_with_two_ports

CAMERA = {"focal_length_mm": 0.6, "pitch_deg": -5.0}


@pytest.fixture(scope="module")
def shot() -> Rendering:
    return render(monocular_recipe(), CAMERA, frames=3, plugins=plugins_with_boxes())


def test_it_holds_images_depth_ids_and_poses(shot: Rendering) -> None:
    assert shot.image.shape == (3, 48, 64, 3)
    assert shot.image.dtype == np.uint8
    assert shot.depth_m.shape == shot.object_id.shape == shot.class_id.shape == (3, 48, 64)
    assert shot.world_from_camera.shape == (3, 4, 4)
    assert shot.time_s.tolist() == [0.25, 0.5, 0.75]
    seen = {shot.world.class_names[i] for i in np.unique(shot.class_id)}
    assert seen == {"background", "cup", "chair"}


def test_depth_and_poses_put_objects_where_they_are(shot: Rendering) -> None:
    """Each pixel of the cup, taken back into the world, lies on the cup's box."""
    rays = pixel_rays(shot.camera)
    for i in range(len(shot)):
        on_cup = shot.object_id[i] == 1
        points = (rays * shot.depth_m[i][..., None])[on_cup]
        pose = shot.world_from_camera[i]
        places = points @ pose[:3, :3].T + pose[:3, 3]
        assert on_cup.any()
        assert (places > np.array([2.0, -0.8, 0.6]) - 1e-4).all()
        assert (places < np.array([2.6, -0.2, 1.6]) + 1e-4).all()


def test_row_0_is_the_top(shot: Rendering) -> None:
    """The chair stands on the floor, so it is seen lower than the cup on no shelf."""
    rows = [np.flatnonzero((shot.object_id[0] == thing).any(axis=1)).max() for thing in (1, 2)]
    assert rows[1] > rows[0]


def test_frames_are_bit_for_bit_those_that_a_task_is_given() -> None:
    setup = set_up(monocular_recipe(), CAMERA, plugins=plugins_with_boxes())
    spec = EpisodeSpec(5, ("view",), 2)
    given = [batch.images[0] for batch in setup.simulation.batches("features", setup.camera.values, spec)]
    taken = [frame.images[0] for frame in setup.frames(2, seed=5)]
    assert np.array_equal(np.concatenate(given), np.concatenate(taken))


def two_ports(**sections: object) -> Recipe:
    """The boxes, seen by a task that takes frames beside what the renderer gave."""
    recipe = monocular_recipe(**sections).model_dump(by_alias=True, exclude_unset=True, mode="json")
    recipe["nodes"]["features"] = {"use": "task.seen", "in": {"capture": "capture", "frames": "frames"}}
    return Recipe.model_validate(recipe | {"fitness": [{"score": "features.count", "weight": 1}]})


@pytest.mark.parametrize("asked", [None, 2, 5])
def test_a_task_that_takes_more_than_frames_shows_each_frame_once(asked: int | None) -> None:
    """With an exposure that is controlled from frame to frame, as for a task that takes frames alone."""
    controlled = {"exposure": {"use": "control.mean-level", "lag_frames": 0, "warm_up_frames": 0}}
    alone = set_up(monocular_recipe(**controlled), CAMERA, plugins=plugins_with_boxes())
    beside = set_up(two_ports(**controlled), CAMERA, plugins=plugins_with_two_ports())
    expected, found = (list(setup.frames(asked)) for setup in (alone, beside))
    assert [float(each.episode.time_s[0]) for each in found] == [
        float(each.episode.time_s[0]) for each in expected
    ]
    assert [each.exposures for each in found] == [each.exposures for each in expected]


def test_seeds_differ_in_noise_and_repeat_themselves() -> None:
    setup = set_up(monocular_recipe(), CAMERA, plugins=plugins_with_boxes())
    first, again, other = (next(setup.frames(1, seed=seed)).images[0] for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_frames_spread_over_the_trip() -> None:
    recipe = monocular_recipe()
    spread = render(recipe, CAMERA, frames=2, spread=True, plugins=plugins_with_boxes())
    assert spread.time_s.tolist() == [0.25, 0.75]  # 0.25 and 0.75 of the way over three frames, to the next


def test_a_pair_has_both_cameras() -> None:
    pair = render(stereo_recipe(), {"baseline_m": 0.2, "hfov_deg": 80.0}, plugins=plugins_with_boxes())
    offset = pair["right"].world_from_camera[0, :3, 3] - pair["left"].world_from_camera[0, :3, 3]
    assert np.linalg.norm(offset) == pytest.approx(0.2)


def test_it_shows_itself(shot: Rendering) -> None:
    assert shot._repr_png_().startswith(b"\x89PNG")
    assert "3 frames of 64 x 48 pixels" in shot._repr_html_()


def test_of_many_frames_it_shows_some(shot: Rendering) -> None:
    """Three hundred side by side left no pixel for any, which no picture has."""
    taken = {name: _repeated(each, 100) for name, each in shot.cameras.items()}
    many = replace(shot, cameras=taken, time_s=np.tile(shot.time_s, 100))
    sheet = cv2.imdecode(np.frombuffer(many._repr_png_(), np.uint8), cv2.IMREAD_COLOR)
    assert sheet.shape[:2] == (2 * 48 + 6, 12 * 64 + 11 * 6)
    assert "300 frames of 64 x 48 pixels" in many._repr_html_()
    assert "; 12 of them" in many._repr_html_()


def _repeated(taken: CameraFrames, times: int) -> CameraFrames:
    names = ("image", "depth_m", "object_id", "world_from_camera", "luminance_cd_m2")
    return replace(taken, **{name: np.concatenate([getattr(taken, name)] * times) for name in names})


def test_effects_are_added() -> None:
    dark = render(
        "scene.light-box",
        {"focal_length_mm": 4.0, "sensor": {"width_px": 64, "height_px": 48, "pixel_um": 60}},
        sets={"nodes.capture": {"use": "renderer.analytic", "in": {"episode": "world"}}},
        effects=[{"use": "effect.vignetting", "k1": -0.8}],
    )
    grey = dark.image[0].mean(axis=-1)
    assert grey[0, 0] < 0.5 * grey[24, 32]


@pytest.mark.parametrize("written", [False, True])
def test_a_recipe_built_in_python_takes_settings_and_effects_too(written: bool) -> None:
    plain = monocular_recipe()
    if written:
        plain, _ = parse_recipe(to_yaml(plain.as_data()))
    plugins = plugins_with_boxes()
    dark = [{"use": "effect.vignetting", "k1": -0.8}]
    changed = set_up(plain, CAMERA, sets={"rig.binning": 4}, effects=dark, plugins=plugins)
    assert changed.rig.cameras[0].width_px == 32
    assert [effect.name for effect in changed.effects] == ["vignetting"]
    assert set_up(plain, CAMERA, plugins=plugins).rig.cameras[0].width_px == 64
    with pytest.raises(UserError, match=r"rig\.binnning"):
        set_up(plain, CAMERA, sets={"rig.binnning": 4}, plugins=plugins)


def test_the_facade_is_the_same_functions() -> None:
    from tacos_decision import read_result
    from tacos_framework import load_recipe, run

    assert (tacos.render, tacos.read_result, tacos.load_recipe, tacos.run) == (
        render,
        read_result,
        load_recipe,
        run,
    )
    with pytest.raises(AttributeError, match="no attribute 'rendr'"):
        tacos.rendr  # noqa: B018 - the access is what is tested


def test_a_procedure_has_no_camera() -> None:
    with pytest.raises(UserError, match=r"a recipe of procedure\.diagnose, which has no camera"):
        render("diagnose")


def test_notebooks_show_cameras() -> None:
    shown: dict[type, object] = {}

    class Formatter:
        def for_type(self, kind: type, function: object) -> None:
            shown[kind] = function

    display = SimpleNamespace(formatters={"text/html": Formatter()})
    tacos.load_ipython_extension(SimpleNamespace(display_formatter=display))
    setup = set_up(monocular_recipe(), CAMERA, plugins=plugins_with_boxes())
    rig = built_rig(setup.plan, setup.camera)
    assert "<td>64 x 48</td>" in shown[type(rig)](rig)
    assert "<svg" in shown[type(rig.cameras[0])](rig.cameras[0])
