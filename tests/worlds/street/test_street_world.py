"""The world of scene.street: one seed one world, light in lux, what the renderer makes of it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError

from tacos_framework.camera.geometry import agent_from_camera, pixel_rays
from tacos_framework.values import Camera, Episode, Exposure, Rig
from tacos_plugins.lighting import LightTransport, photopic
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer
from tacos_worlds.kit.sky import cosine_mean, draw_daylight
from tacos_worlds.street.assembly import CLASS_NAMES, measuring_plane
from tacos_worlds.street.city import draw_town
from tacos_worlds.street.scene import StreetScene

LUX = 20_000.0


def tiny(seed: int, lux: float = LUX) -> Episode:
    scene = StreetScene(StreetScene.Config(blocks=1, reach_m=60, frames=3, driving_cars=1, texture_px=64))
    return scene.episode(rng=np.random.default_rng(seed), illumination_lux=lux)


def forward_camera(width_px: int = 200, height_px: int = 100, hfov_deg: float = 80.0) -> Camera:
    focal_px = width_px / 2 / math.tan(math.radians(hfov_deg / 2))
    pose = agent_from_camera((0.0, 0.0, 0.0), 0.0)
    return Camera("c", width_px, height_px, 1.0, focal_px * 1e-3, agent_from_camera=pose)


def test_more_light_changes_nothing_but_the_light() -> None:
    # That one seed gives one world, and another another, is shown by the conformance suite.
    first, brighter = tiny(3), tiny(3, 2 * LUX)
    assert first.world.key != brighter.world.key
    assert np.array_equal(first.trajectory.world_from_agent, brighter.trajectory.world_from_agent)
    for a, b in zip(first.world.parts, brighter.world.parts, strict=True):
        assert np.array_equal(a.vertices_m, b.vertices_m)
    assert brighter.world.lights[0].flux_lm == pytest.approx(2 * first.world.lights[0].flux_lm, rel=1e-5)
    assert brighter.world.sky_cd_m2 == pytest.approx(2 * first.world.sky_cd_m2, rel=1e-5)


def test_illuminance_agrees_with_an_independent_estimate(small_drive: Episode) -> None:
    # Other points, more rays and finer places than those the calibration used, along the four inner streets.
    world = small_drive.world
    town = draw_town(np.random.default_rng(5).spawn(6)[0], blocks=1, reach_m=100)
    plane = measuring_plane(town)
    low, high = plane.min(axis=0), plane.max(axis=0)
    rng = np.random.default_rng(9)
    points = rng.uniform(low, high, (40_000, 3)).astype(np.float32)
    nearest = np.minimum(
        np.abs(points[:, :1] - np.array(town.street_x_m)).min(axis=1),
        np.abs(points[:, 1:2] - np.array(town.street_y_m)).min(axis=1),
    )
    points = points[nearest < 9.3][:4000]
    up = np.tile(np.array([0, 0, 1], np.float32), (len(points), 1))
    transport = LightTransport(world, rays=64, merge_m=1.0, longest_edge_m=6.0)
    lux = photopic(transport.direct_lux(points, up) + transport.indirect_lux(points, up))
    assert lux.mean() == pytest.approx(LUX, rel=0.06)
    assert lux.max() > 1.1 * LUX  # in the sun
    assert lux.min() < 0.5 * LUX  # in shadow


def test_daylight_gives_open_ground_one_lux() -> None:
    light = draw_daylight(np.random.default_rng(1), elevation_deg=40, sun_share=0.7, clouds=0.4)
    towards = light.sun.position_m / np.linalg.norm(light.sun.position_m)
    assert math.degrees(math.asin(towards[2])) == pytest.approx(40, abs=0.01)
    facing = light.sun.flux_lm / (4 * math.pi * np.linalg.norm(light.sun.position_m) ** 2)
    assert float(photopic(facing)) * towards[2] == pytest.approx(0.7, rel=1e-4)
    assert math.pi * float(photopic(light.ambient_cd_m2)) == pytest.approx(0.3, rel=1e-4)
    assert cosine_mean(light.sky_cd_m2) == pytest.approx(light.ambient_cd_m2, rel=1e-4)
    assert light.sky_cd_m2.min() > 0


def test_objects_and_classes(small_drive: Episode) -> None:
    world = small_drive.world
    assert world.class_names == CLASS_NAMES
    assert {part.object_id for part in world.parts} == set(range(1, len(world.objects)))
    moving = [k for k, thing in enumerate(world.objects) if thing.moves]
    assert [mover.object_id for mover in small_drive.movers] == moving
    classes = [world.objects[k].class_name for k in moving]
    assert classes[:4] == ["car"] * 4
    assert set(classes[4:]) == {"person"}


@pytest.mark.gl
def test_depth_agrees_with_rays_far_away(small_drive: Episode) -> None:
    camera = forward_camera()
    renderer = ModernglRenderer(ModernglRenderer.Config(near_m=0.3, light_texel_m=2.0, antialiasing="none"))
    (view,) = renderer.capture(small_drive[:2], rig=Rig((camera,)), exposure=Exposure()).views
    transport = LightTransport(small_drive.world, longest_edge_m=1e4)
    for frame in range(2):
        pose = view.world_from_camera[frame]
        rays = pixel_rays(camera) @ pose[:3, :3].T
        moved = {mover.object_id for mover in small_drive.movers}
        still = ~np.isin(view.object_id[frame], list(moved))
        origins = np.tile(pose[:3, 3], (rays[..., 0].size, 1)).astype(np.float32)
        hits = transport.occlusion.first_hits(origins, rays.reshape(-1, 3).astype(np.float32))
        traced = np.where(hits.triangle >= 0, hits.distance_m, np.inf).reshape(still.shape)
        drawn = view.depth_m[frame]
        both = np.isfinite(traced) & np.isfinite(drawn) & still
        close = np.isclose(drawn[both], traced[both], rtol=1e-3, atol=0)
        assert both.mean() > 0.5
        assert close.mean() > 0.985  # the rest are pixels on edges
        assert np.mean((np.isfinite(drawn) == np.isfinite(traced))[still]) > 0.99
        assert drawn[both].max() > 60


@pytest.mark.gl
def test_the_picture_shows_sky_above_and_road_below(small_drive: Episode) -> None:
    camera = forward_camera(120, 60)
    renderer = ModernglRenderer(ModernglRenderer.Config(near_m=0.3, light_texel_m=2.0))
    (view,) = renderer.capture(small_drive[10:11], rig=Rig((camera,)), exposure=Exposure()).views
    classes = small_drive.world.class_of_object[view.object_id[0]]
    named = np.array(CLASS_NAMES)[classes]
    assert np.mean(np.isin(named[-5:], ["road", "pavement"])) > 0.9
    sky = ~np.isfinite(view.depth_m[0])
    assert (named[sky] == "background").all()
    luminance = view.luminance_cd_m2[0]
    assert np.isfinite(luminance).all()
    # Grey roads under 20,000 lux, in sun or shadow: between 3 and 40 percent of a white surface.
    road = luminance[named == "road"].mean(axis=-1)
    assert 0.03 * LUX / np.pi < road.mean() < 0.4 * LUX / np.pi


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"sun_elevation_deg": (60, 30)}, "must rise"),
        ({"sun_elevation_deg": (0, 30)}, "must rise from 5"),
        ({"blocks": 0}, "greater than or equal to 1"),
        ({"camera_height_m": 0.1}, "greater than"),
        ({"trees": 3}, "Extra inputs"),
    ],
)
def test_wrong_settings_are_refused_in_a_sentence(given: dict[str, object], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        StreetScene.Config.model_validate(given)


def test_darkness_is_refused() -> None:
    with pytest.raises(ValueError, match="above 0, not 0"):
        tiny(1, 0.0)
