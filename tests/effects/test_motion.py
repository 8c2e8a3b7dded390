"""Blur and rolling shutter of rendered views, against frames rendered at their own moments."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import ndimage
from scipy.spatial.transform import Rotation

from tacos_framework.camera import agent_from_camera
from tacos_framework.formation import EpisodeDraws, ImageFormation
from tacos_framework.testing.forming import placed
from tacos_framework.testing.samples import sample_world
from tacos_framework.values import (
    Camera,
    Capture,
    Electrons,
    Episode,
    Exposure,
    ImageContext,
    ImageGeometry,
    Mover,
    Object,
    Rig,
    Trajectory,
)
from tacos_plugins.effects.motion import Motion
from tests.effects.walls import Wall, cast

SUB_FRAMES = 64
ROW_TIME_US = 150.0
"""15 ms from the first row to the last."""
FULL_SCALE_DN = 250.0
WIDTH_PX, HEIGHT_PX = 140, 100
EXPOSURE_S = 0.030
CARD_ID = 1
FAR = Wall(4.0, 9.0)
NEAR = Wall(2.5, 0.7, object_id=2)
WORLD = replace(
    sample_world(),
    objects=(Object("background", "x"), Object("card", "x", moves=True), Object("near", "x")),
    class_names=("x",),
)


def way(turn_deg_s=(0, 0, 0), speed_m_s=(0, 0, 0), bend_deg_s2=(0, 0, 0), wave_deg=0.0, up_m=1.5):
    """A trajectory about t = 0 with a steady turn and speed, a turn that grows, and a shake of 8 Hz."""
    time_s = np.arange(-0.1, 0.1, 0.0005)
    turned = np.radians(np.outer(time_s, turn_deg_s) + np.outer(time_s**2 / 2, bend_deg_s2))
    turned[:, 2] += np.radians(wave_deg) * np.sin(2 * np.pi * 8 * time_s)
    poses = np.tile(np.eye(4), (len(time_s), 1, 1))
    poses[:, :3, :3] = Rotation.from_rotvec(turned).as_matrix()
    poses[:, :3, 3] = np.outer(time_s, speed_m_s) + np.array([0, 0, up_m])
    return Trajectory(time_s, poses)


def camera(**changes):
    given = {"pixel_um": 3.0, "focal_length_mm": 0.36, "agent_from_camera": agent_from_camera((0, 0, 0), -3)}
    return Camera("camera", WIDTH_PX, HEIGHT_PX, **{**given, "shutter": "global", **changes})


def strip(whole, row):
    """The camera of one row of another."""
    x, y = whole.centre_px
    return replace(whole, height_px=1, principal_point_px=(x, y - row))


def at(episode, time_s):
    return replace(episode, time_s=np.array([time_s]))


def moved(view, episode, exposure_s=EXPOSURE_S, **settings):
    formation = ImageFormation(Exposure(time_s=exposure_s), [placed(Motion, **settings)])
    return formation.light(Capture(episode, (view,)), EpisodeDraws(1, ("motion",))).views[0]


def sub_frames(episode, camera, walls, after_s=0.0, count=SUB_FRAMES):
    """(H, W, 3) the mean of views cast at moments spread evenly over an exposure."""
    moments = after_s + ((np.arange(count) + 0.5) / count - 0.5) * EXPOSURE_S
    return np.mean([cast(at(episode, each), camera, walls).luminance_cd_m2[0] for each in moments], axis=0)


def share_within_one_dn(found, expected, where):
    scale = FULL_SCALE_DN / expected.max()
    return (np.abs(found - expected)[where] * scale <= 1).mean()


def away_from_edges(view, by_px):
    """Pixels this far from where surfaces meet, and from the image's edge, beyond which nothing is known."""
    depth = view.depth_m[0]
    edge = ndimage.maximum_filter(depth, 3) > 1.05 * ndimage.minimum_filter(depth, 3)
    away = ~ndimage.binary_dilation(edge, iterations=by_px) & np.isfinite(depth)
    away[:by_px] = away[-by_px:] = False
    away[:, :by_px] = away[:, -by_px:] = False
    return away


MOTIONS = {
    "turn": way(turn_deg_s=(0, 0, 60)),
    "roll": way(turn_deg_s=(90, 0, 0)),
    "slanted": way(turn_deg_s=(0, 40, 50)),
    "ahead": way(speed_m_s=(8.0, 0, 0)),
    "past": way(speed_m_s=(0, 4.0, 1.0)),
    "all": way((20, -30, 40), (1.0, 0.5, 0.2), (300, 600, 900)),
    "shaking": way(wave_deg=1.5),
}


def trip(trajectory, **more):
    return Episode(WORLD, trajectory, np.zeros(1), np.zeros(1), **more)


@pytest.mark.parametrize("name", MOTIONS)
def test_blur_is_the_mean_of_sub_frames(name):
    episode, walls = trip(MOTIONS[name]), (FAR, NEAR)
    sharp = cast(episode, camera(), walls)
    found, expected = moved(sharp, episode), sub_frames(episode, camera(), walls)
    where = away_from_edges(sharp, 8)
    assert where.mean() > 0.4
    assert share_within_one_dn(found.luminance_cd_m2[0], expected, where) >= 0.99
    assert share_within_one_dn(sharp.luminance_cd_m2[0], expected, where) < 0.8
    assert np.array_equal(found.depth_m, sharp.depth_m)
    assert np.array_equal(found.object_id, sharp.object_id)


def test_the_first_exposure_of_a_path_is_blurred_like_any_other():
    whole = MOTIONS["slanted"]
    begun = whole.time_s >= 0
    cut = Trajectory(whole.time_s[begun], whole.world_from_agent[begun])
    sharp = cast(trip(whole), camera(), (FAR, NEAR))
    found, expected = (moved(sharp, trip(each)).luminance_cd_m2 for each in (cut, whole))
    np.testing.assert_allclose(found, expected, atol=2e-3)


def test_what_moves_by_itself_is_blurred_by_its_own_way():
    card = Wall(2.5, 0.7, CARD_ID, way=way(speed_m_s=(0.5, 1.5, 0), up_m=0))
    episode = trip(way(turn_deg_s=(0, 0, 20)), movers=(Mover(CARD_ID, card.way),))
    sharp = cast(episode, camera(), (FAR, card))
    found, expected = moved(sharp, episode), sub_frames(episode, camera(), (FAR, card))
    where = away_from_edges(sharp, 8)
    assert (sharp.object_id[0][where] == CARD_ID).sum() > 300
    assert share_within_one_dn(found.luminance_cd_m2[0], expected, where) >= 0.99


@pytest.mark.parametrize("name", ["slanted", "ahead", "all"])
def test_rows_of_a_rolling_shutter_are_those_of_their_own_moments(name):
    rolling = camera(shutter="rolling", row_time_us=ROW_TIME_US)
    episode, walls = trip(MOTIONS[name]), (FAR, NEAR)
    sharp = cast(episode, rolling, walls)
    found = moved(sharp, episode)
    where = away_from_edges(sharp, 14)
    rows = range(0, HEIGHT_PX, 3)
    after_s = [(row - (HEIGHT_PX - 1) / 2) * ROW_TIME_US * 1e-6 for row in rows]
    then = [
        cast(at(episode, each), strip(rolling, row), walls) for row, each in zip(rows, after_s, strict=True)
    ]
    light = [
        sub_frames(episode, strip(rolling, row), walls, each, 16)[0]
        for row, each in zip(rows, after_s, strict=True)
    ]
    assert share_within_one_dn(found.luminance_cd_m2[0, ::3], np.stack(light), where[::3]) >= 0.99
    depth, ids = (
        np.concatenate([getattr(each, name)[0] for each in then]) for name in ("depth_m", "object_id")
    )
    np.testing.assert_allclose(found.depth_m[0, ::3][where[::3]], depth[where[::3]], rtol=2e-3)
    assert (found.object_id[0, ::3] != ids).mean() < 0.015  # one pixel of each row at either edge


def test_binned_rows_are_read_one_by_one():
    whole = camera(shutter="rolling", row_time_us=ROW_TIME_US)
    binned = replace(whole, binning=2.0, pixel_um=whole.pixel_um / 2, row_time_us=ROW_TIME_US / 2)
    episode = trip(MOTIONS["turn"])
    one, other = (moved(cast(episode, each, (FAR,)), episode) for each in (whole, binned))
    np.testing.assert_array_equal(one.luminance_cd_m2, other.luminance_cd_m2)


def test_where_nothing_moves_it_hands_on_the_very_arrays():
    episode = trip(way())
    sharp = cast(episode, camera(shutter="rolling", row_time_us=ROW_TIME_US), (FAR, NEAR))
    assert moved(sharp, episode) is sharp


def test_the_whole_image_moves_with_a_known_velocity():
    signal = np.random.default_rng(1).uniform(0, 1, (1, 30, 40, 1))
    velocity = np.zeros((30, 40, 2))
    velocity[..., 0] = 500.0
    results = []
    for given in (velocity[0, 0], velocity):
        context = ImageContext(exposure_s=0.01, velocity_px_s=given)
        geometry = ImageGeometry(40, 30, 30.0, (19.5, 14.5), 3.0)
        results.append(
            Motion(Motion.Config()).on_array(
                signal, geometry=geometry, context=context, rng=np.random.default_rng(1)
            )
        )
    np.testing.assert_allclose(*results, atol=1e-6)
    # A line of 5 px through each pixel: the pixel, two neighbours on either side, and no more.
    np.testing.assert_allclose(
        results[0][0, :, 10:-10, 0],
        np.mean([signal[0, :, 10 + k : 30 + k, 0] for k in range(-2, 3)], axis=0),
        atol=0.03,
    )


def test_it_says_what_it_assumes_of_a_shutter():
    effect, strict = (Motion(Motion.Config(unknown=unknown)) for unknown in ("assume", "refuse"))
    named = {"electrons": Electrons("IMX"), "agent_from_camera": np.eye(4)}
    unknown, rolling, known = (
        camera(shutter=shutter, row_time_us=row_time_us, **named)
        for shutter, row_time_us in ((None, None), ("rolling", None), ("rolling", 20.0))
    )
    assert effect.origins(unknown) == {"shutter": "assumed global: not published"}
    assert "assumed to be 15 us a row" in effect.origins(rolling)["line time"]
    assert effect.origins(known)["line time"] == "20 us a row, as the catalog states"
    fast = replace(rolling, row_time_at_most_us=5.48)
    assert effect.origins(fast)["line time"] == "assumed to be 5.48 us a row, all that its frame rate leaves"
    faster = replace(known, row_time_at_most_us=12.0)
    assert effect.origins(faster)["line time"] == "12 us a row, all that its frame rate leaves"
    assert (
        Motion(Motion.Config(row_time_us=30))
        .origins(fast)["line time"]
        .startswith("30 us a row, as the recipe")
    )

    assert strict.lacks(Rig((unknown,))) == "the shutter of IMX is unknown"
    assert strict.lacks(Rig((rolling,))) == "the line time of IMX is unknown"
    assert strict.lacks(Rig((known,))) is None
    assert effect.lacks(Rig((unknown,))) is None


def test_no_line_takes_longer_than_the_frame_rate_leaves():
    slow = camera(shutter="rolling", row_time_us=4 * ROW_TIME_US)
    bounded, known = replace(slow, row_time_at_most_us=ROW_TIME_US), replace(slow, row_time_us=ROW_TIME_US)
    episode = trip(MOTIONS["turn"])
    one, other = (moved(cast(episode, each, (FAR,)), episode) for each in (bounded, known))
    np.testing.assert_array_equal(one.luminance_cd_m2, other.luminance_cd_m2)
