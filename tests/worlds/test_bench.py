"""The measuring bench: what stands where, and how bright it is."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tacos_framework.values import Exposure
from tacos_plugins.renderers.analytic import AnalyticRenderer
from tacos_worlds.bench.chessboard import Chessboard
from tacos_worlds.bench.colour_chart import REFLECTANCES, ColourChart
from tacos_worlds.bench.grey_bars import GreyBars
from tacos_worlds.bench.light_box import LightBox
from tacos_worlds.bench.slanted_edges import SlantedEdges
from tacos_worlds.bench.textured_target import TexturedTarget, dead_leaves
from tests.small_worlds import camera, rig


def seen(illumination_lux: float = 2000.0, **config) -> np.ndarray:
    """Luminance of a camera 0.5 m off that sees the target of 0.13 x 0.10 m and a margin [cd/m2]."""
    episode = GreyBars(GreyBars.Config(**config)).episode(illumination_lux=illumination_lux)
    looking = rig(camera(280, 220, focal_px=1000.0))
    capture = AnalyticRenderer(AnalyticRenderer.Config()).capture(episode, rig=looking, exposure=Exposure())
    return capture.views[0].luminance_cd_m2[0, ..., 1]


def test_the_mean_illuminance_on_the_target_is_the_scenario_s():
    light = seen(bars=3, darkest=0.5, brightest=0.5)
    on_target = light[light > 0.5 * light.max()]
    assert np.pi * on_target.mean() / 0.5 == pytest.approx(2000.0, rel=0.02)
    assert np.ptp(on_target) / on_target.mean() < 0.4


def test_bars_rise_evenly_from_black_on_the_left_to_white_on_the_right():
    row = seen(bars=5, brightest=0.8)[110]
    edges = np.linspace(140 - 130, 140 + 130, 6)
    middles = row[((edges[1:] + edges[:-1]) / 2).astype(int)]
    assert middles[0] == 0.0
    np.testing.assert_allclose(middles / middles[-1], [0, 0.25, 0.5, 0.75, 1.0], atol=0.03)


def test_there_is_nothing_but_the_target():
    light = seen()
    assert light[:5].max() == 0.0
    assert light[:, :5].max() == 0.0


def test_a_board_off_the_axis_turns_about_its_own_middle():
    aside = {"right_m": 0.3, "up_m": -0.1, "tilt_deg": 20, "turn_deg": -60}
    board = Chessboard(Chessboard.Config(distance_m=0.2, **aside)).episode(illumination_lux=100.0)
    paper = board.world.parts[0].vertices_m
    np.testing.assert_allclose(paper.mean(axis=0), [0.2, -0.3, -0.1], atol=1e-6)
    assert paper[paper[:, 1] < -0.3, 0].max() < 0.2, "its right side has come nearer"


def test_other_settings_are_other_worlds():
    keys = {
        GreyBars(GreyBars.Config(**config)).episode(illumination_lux=lux).world.key
        for config, lux in [({}, 100.0), ({}, 200.0), ({"bars": 8}, 100.0), ({"distance_m": 0.6}, 100.0)]
    }
    assert len(keys) == 4


# targets in a light tent ------------------------------------------------------------------------------------


def tent(scene, looking=None, **supplied):
    """What the camera sees of a target, under light that makes white 1 [1/pi cd/m2]."""
    episode = scene.episode(illumination_lux=np.pi, **supplied)
    looking = looking or rig(camera(160, 120, focal_px=300.0))
    return AnalyticRenderer(AnalyticRenderer.Config()).capture(episode, rig=looking, exposure=Exposure())


def test_a_light_box_is_even_for_the_widest_camera():
    view = tent(LightBox(LightBox.Config(reflectance=0.7)), rig(camera(160, 120, focal_px=20.0))).views[0]
    np.testing.assert_allclose(view.luminance_cd_m2, 0.7, rtol=1e-5)


def test_slanted_edges_are_turned_by_their_angle():
    config = SlantedEdges.Config(angle_deg=10, pitch_m=0.2, square=0.5, dark=0.0, white=1.0)
    looking = rig(camera(200, 200, focal_px=800.0))
    image = tent(SlantedEdges(config), looking).views[0].luminance_cd_m2[0, ..., 1]
    rows = np.arange(60, 140)  # the square in the middle is 160 px wide
    right_edge = [100 + int(np.argmax(image[row, 100:] > 0.5)) for row in rows]
    slope = np.polyfit(rows, right_edge, 1)[0]
    assert np.degrees(np.arctan(abs(slope))) == pytest.approx(10, abs=0.5)


@pytest.mark.parametrize(("tilt_deg", "turn_deg"), [(0, 0), (30, 0), (0, -35), (20, 25)])
def test_the_corners_of_a_board_are_where_its_pose_says(tilt_deg, turn_deg):
    config = Chessboard.Config(tilt_deg=tilt_deg, turn_deg=turn_deg, square_mm=20, distance_m=0.5)
    image = (
        tent(Chessboard(config), rig(camera(320, 240, focal_px=500.0))).views[0].luminance_cd_m2[0, ..., 1]
    )
    found, corners = cv2.findChessboardCorners(np.rint(255 * image).astype(np.uint8), (9, 6))
    assert found
    grid = np.stack(np.meshgrid(np.arange(9) - 4, np.arange(6) - 2.5), axis=-1).reshape(-1, 2) * 0.02
    tilt, turn = np.radians([tilt_deg, turn_deg])
    right, up = grid[:, 0], -grid[:, 1]
    back, up = up * np.sin(tilt), up * np.cos(tilt)  # the top goes back
    back, right = back * np.cos(turn) + right * np.sin(turn), right * np.cos(turn) - back * np.sin(turn)
    expected = np.column_stack([159.5 + 500 * right / (0.5 + back), 119.5 - 500 * up / (0.5 + back)])
    misses = np.linalg.norm(corners.reshape(-1, 1, 2) - expected[None], axis=-1).min(axis=0)
    assert misses.max() < 1.0


def test_the_patches_of_a_colour_chart_have_its_reflectances():
    capture = tent(ColourChart(ColourChart.Config()))
    view, world = capture.views[0], capture.episode.world
    seen = {
        thing.name: view.luminance_cd_m2[view.object_id == number].mean(axis=0)
        for number, thing in enumerate(world.objects)
        if thing.class_name == "patch"
    }
    assert list(seen) == list(REFLECTANCES)
    for name, colour in REFLECTANCES.items():
        np.testing.assert_allclose(seen[name], colour, atol=1e-4)


def test_the_table_of_the_colour_chart_is_that_of_colour_science():
    import colour

    chart = colour.CCS_COLOURCHECKERS["ColorChecker24 - After November 2014"]
    xyz = colour.xyY_to_XYZ(np.array(list(chart.data.values())))
    adapted = {"chromatic_adaptation_transform": "Bradford"}
    rgb = np.clip(colour.XYZ_to_RGB(xyz, "sRGB", chart.illuminant, **adapted), 0, 1)
    assert list(REFLECTANCES) == list(chart.data)
    np.testing.assert_allclose(list(REFLECTANCES.values()), rgb, atol=1e-8)


def test_the_greys_of_the_colour_chart_are_grey_and_its_red_is_red():
    greys = list(REFLECTANCES.values())[-6:]
    for grey in greys:
        assert np.ptp(grey) < 0.06
    assert [round(grey[1], 2) for grey in greys] == sorted((round(g[1], 2) for g in greys), reverse=True)
    assert greys[0][1] == pytest.approx(0.9, abs=0.03)
    red, green, blue = REFLECTANCES["red"]
    assert red > 5 * green
    assert red > 5 * blue


def leaves(seed=0, size=128):
    return dead_leaves(np.random.default_rng(seed), size, 0.1, 0.8)


def test_dead_leaves_tile_without_a_seam():
    sheet = leaves().astype(np.float64)
    for axis in (0, 1):
        steps = np.abs(sheet - np.roll(sheet, 1, axis)).mean(
            axis=(1 - axis, 2)
        )  # the first is across the seam
        assert steps[0] < np.quantile(steps[1:], 0.99)


def test_dead_leaves_keep_to_their_reflectances():
    from colour.models import eotf_sRGB

    linear = eotf_sRGB(leaves() / 255)
    assert linear.min() == pytest.approx(0.1, abs=0.02)
    assert linear.max() == pytest.approx(0.8, abs=0.02)


def test_a_target_passes_at_its_speed():
    config = TexturedTarget.Config(texture_px=64, speed_m_s=0.2, frames=3, frame_interval_s=0.05)
    episode = TexturedTarget(config).episode(rng=np.random.default_rng(0), illumination_lux=1.0)
    poses = episode.trajectory.at(episode.time_s)
    np.testing.assert_allclose(poses[:, 1, 3], [-0.01, 0.0, 0.01], atol=1e-12)
    assert (poses[:, [0, 2], 3] == 0).all()


def test_a_tilted_target_has_depth():
    config = TexturedTarget.Config(texture_px=64, tilt_deg=40)
    depth = tent(TexturedTarget(config), rng=np.random.default_rng(0)).views[0].depth_m[0]
    assert depth[0].mean() > 0.5 > depth[-1].mean()
    assert np.ptp(depth[60]) < 0.01
