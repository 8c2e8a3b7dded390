"""What worlds outdoors need of the rasteriser: a sky, a sun, far depths, and things that move."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from small_worlds import camera, matte, moving_plate, pose, quad, rig, standing, world

from tacos_framework.camera.geometry import agent_from_camera, pixel_rays
from tacos_framework.values import Exposure, Light, Mover
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer

pytestmark = pytest.mark.gl

AGENT = pose((0.0, 0.0, 2.0), (1.0, 0.0, 0.0))


def one_view(episode, seen_by, **config):
    renderer = ModernglRenderer(ModernglRenderer.Config(light_texel_m=0.5, near_m=0.3, **config))
    (view,) = renderer.capture(episode, rig=rig(seen_by), exposure=Exposure(time_s=0.04)).views
    return view


def panorama(rows: int = 64) -> np.ndarray:
    """Red rises with the height, green with the turn from +x to +y."""
    zenith = (np.arange(rows) + 0.5) / rows
    azimuth = (np.arange(2 * rows) + 0.5) / (2 * rows)
    up, turn = np.meshgrid(1 - zenith, 0.5 + 0.5 * np.sin(2 * np.pi * azimuth), indexing="ij")
    return 100 * np.stack([up, turn, np.full_like(up, 0.5)], axis=-1).astype(np.float32)


@pytest.mark.parametrize("antialiasing", ["edges", "multisampling"])
def test_the_sky_is_seen_in_its_direction_behind_everything(antialiasing):
    seen_by = camera(90, 60, 50.0, agent_from_camera=agent_from_camera((0, 0, 0), 15.0, 30.0))
    ground = quad((0, 0, 0), (20, 0, 0), (0, 20, 0))
    place = replace(world([ground], [matte(0.5)]), sky_cd_m2=panorama())
    view = one_view(standing(place, AGENT), seen_by, antialiasing=antialiasing)
    rays = pixel_rays(seen_by) @ view.world_from_camera[0, :3, :3].T
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    sky = ~np.isfinite(view.depth_m[0])
    assert 0.3 < sky.mean() < 0.95
    inside = sky[1:-1, 1:-1] & sky[2:, 1:-1] & sky[:-2, 1:-1]
    seen = view.luminance_cd_m2[0, 1:-1, 1:-1][inside]
    direction = rays[1:-1, 1:-1][inside]
    assert seen[:, 0] == pytest.approx(100 * (1 - np.arccos(direction[:, 2]) / math.pi), abs=0.6)
    turn = np.arctan2(direction[:, 1], direction[:, 0])
    assert seen[:, 1] == pytest.approx(50 + 50 * np.sin(turn), abs=1.0)
    assert seen[:, 2] == pytest.approx(50, abs=0.1)


@pytest.mark.parametrize(
    "config", [{"antialiasing": "none"}, {"antialiasing": "multisampling"}, {"reuse": "cube-map"}], ids=str
)
def test_each_pixel_shows_the_sky_in_the_direction_of_its_centre(config):
    """The sky's red tells the angle from the zenith, its green that from +x: 100 for 180 degrees each."""
    seen_by = camera(
        24,
        16,
        12.0,  # half a pixel is more than a degree
        principal_point_px=(9.0, 8.5),
        agent_from_camera=agent_from_camera((0, 0, 0), 50.0, 90.0),
    )
    rows = 256
    zenith = 100 * (np.arange(rows) + 0.5) / rows
    turn = 100 * (1 - np.abs(1 - (np.arange(2 * rows) + 0.5) / rows))
    red, green = np.meshgrid(zenith, turn, indexing="ij")
    sky = np.stack([red, green, np.zeros_like(red)], axis=-1).astype(np.float32)
    below = quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    place = replace(world([below], [matte(0.5)]), sky_cd_m2=sky)
    view = one_view(standing(place, AGENT), seen_by, **config)
    assert np.isinf(view.depth_m).all()
    rays = pixel_rays(seen_by) @ view.world_from_camera[0, :3, :3].T
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    from_zenith = np.degrees(np.arccos(rays[..., 2]))
    from_x = np.degrees(np.arctan2(np.abs(rays[..., 1]), rays[..., 0]))
    shown = view.luminance_cd_m2[0] * 1.8
    off_zenith = from_zenith > 5  # closer in, a texel of the panorama spans many degrees of turn
    assert shown[..., 0] == pytest.approx(from_zenith, abs=0.2)
    assert shown[..., 1][off_zenith] == pytest.approx(from_x[off_zenith], abs=0.2)


def test_a_sun_far_away_lights_ground_by_the_cosine_and_casts_sharp_shadows():
    elevation = math.radians(40)
    towards = np.array([0.0, -math.cos(elevation), math.sin(elevation)])
    distance, lux = 10_000.0, 1000.0
    sun = Light(
        position_m=distance * towards,
        flux_lm=np.full(3, lux * 4 * math.pi * distance**2),
        radius_m=distance * 0.00465,
    )
    ground = quad((10, 0, 0), (10, 0, 0), (0, 10, 0))
    wall = quad((10, -2, 1.5), (3, 0, 0), (0, 0, 1.5))
    place = world([ground, wall], [matte(0.5, roughness=1.0)], lights=[sun])
    seen_by = camera(64, 64, 40.0, agent_from_camera=agent_from_camera((0, 0, 0), -89.0))
    above = pose((10.0, 0.0, 9.0), (1.0, 0.0, 0.0))
    view = one_view(standing(place, above), seen_by)
    lit = view.luminance_cd_m2[0, 5, 32]
    assert lit == pytest.approx(np.full(3, 0.5 * lux * math.sin(elevation) / math.pi), rel=0.02)
    # The wall's shadow falls to +y, 3 m / tan(40 deg) long: at y = -2 + 1.5 the ground is dark.
    rays = pixel_rays(seen_by) @ view.world_from_camera[0, :3, :3].T
    at = view.world_from_camera[0, :3, 3] + rays * view.depth_m[0][..., None]
    on_ground = np.abs(at[..., 2]) < 0.01
    shade = on_ground & (np.abs(at[..., 0] - 10) < 2) & (np.abs(at[..., 1] + 0.3) < 0.6)
    assert shade.sum() > 10
    assert view.luminance_cd_m2[0][shade].max() < 0.02 * lit.max()


def test_depth_is_exact_to_a_kilometre():
    seen_by = camera(101, 41, 60.0)
    distances = (5.0, 50.0, 500.0, 999.0)
    walls = [
        quad((d, 0.0, 0.0), (0, d * (0.9 - 0.2 * k), 0), (0, 0, 0.3 * d), object_id=k + 1)
        for k, d in enumerate(reversed(distances))
    ]
    slopes = [replace(wall, vertices_m=wall.vertices_m) for wall in walls]
    place = world(slopes, [matte(0.5)])
    view = one_view(standing(place, AGENT), seen_by)
    for number, distance in enumerate(reversed(distances)):
        shown = view.depth_m[0][view.object_id[0] == number + 1]
        assert len(shown) > 10
        assert shown == pytest.approx(np.full(len(shown), distance), rel=1e-5)
    assert np.isinf(view.depth_m[0]).any()


@pytest.mark.parametrize("read_back", ["direct", "buffered"])
@pytest.mark.parametrize("antialiasing", ["edges", "none"])
def test_things_that_move_are_seen_where_they_are(read_back, antialiasing):
    seen_by = camera(200, 60, 100.0)
    view = one_view(moving_plate(), seen_by, read_back=read_back, antialiasing=antialiasing)
    for frame in range(3):
        rows, columns = np.nonzero(view.object_id[frame] == 1)
        # 1 m wide at 10 m and 100 px focal length: 10 px, its middle 10 px further right each second.
        assert columns.mean() == pytest.approx(99.5 + 10 * frame, abs=0.51)
        assert len(columns) == pytest.approx(100, abs=21)
        assert view.depth_m[frame][rows, columns] == pytest.approx(np.full(len(rows), 10.0), rel=1e-5)
        assert view.luminance_cd_m2[frame][rows, columns].mean() > 80


def test_what_moves_is_blurred_by_its_own_motion():
    seen_by = camera(200, 60, 1000.0)
    episode = moving_plate(2)[1:]  # its left edge at 150 px
    sharp = one_view(episode, seen_by, antialiasing="none")
    blurred = one_view(episode, seen_by, antialiasing="none", motion_samples=8)

    def grey(view):
        row = view.luminance_cd_m2[0, 30, :, 0]
        return np.flatnonzero((row > 1) & (row < 99))

    assert len(grey(sharp)) == 0
    # 1 m/s over 40 ms at 10 m and 1000 px: 4 px.
    assert 3 <= len(grey(blurred)) <= 5
    assert grey(blurred).mean() == pytest.approx(149.5, abs=1.0)


def test_cube_maps_are_not_used_where_things_move():
    seen_by = camera(200, 60, 100.0)
    direct = one_view(moving_plate(), seen_by)
    reused = one_view(moving_plate(), seen_by, reuse="cube-map")
    assert np.array_equal(direct.object_id, reused.object_id)


def test_only_things_that_say_so_may_move():
    episode = moving_plate()
    with pytest.raises(ValueError, match="not one that moves"):
        replace(episode, movers=(Mover(0, episode.movers[0].trajectory),))


def test_coarse_parts_get_fewer_texels_and_the_same_light():
    from tacos_plugins.renderers.light.charts import find_charts
    from tacos_plugins.renderers.light.flatten import flatten

    fine = quad((0, 0, 0), (10, 0, 0), (0, 10, 0))
    texels = []
    for detail in (1.0, 0.25):
        place = world([replace(fine, light_detail=detail)], [matte(0.5)])
        charts = find_charts(flatten(place, (np.zeros((4, 3), np.float32),)), 0.5)
        texels.append(int(charts.size.prod()))
    assert texels == [41 * 41, 11 * 11]
