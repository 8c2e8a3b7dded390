"""The path-traced reference: light known in closed form, and where both renderers must agree."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError
from small_worlds import box, camera, matte, moving, panel, pose, quad, rig, room, standing, world

from tacos_framework.camera.geometry import agent_from_camera, pixel_rays, project
from tacos_framework.errors import UserError
from tacos_framework.values import Exposure, Light, Material
from tacos_plugins.renderers.mitsuba import library
from tacos_plugins.renderers.mitsuba.renderer import MitsubaRenderer
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer

pytest.importorskip("mitsuba", reason="the extra mitsuba is not installed")

TRACED = MitsubaRenderer(MitsubaRenderer.Config(samples=256))
RASTERISED = ModernglRenderer(ModernglRenderer.Config())
BOTH = [pytest.param(TRACED, id="mitsuba"), pytest.param(RASTERISED, id="moderngl", marks=pytest.mark.gl)]

SMALL = camera(16, 12, 15.0)
DOWN = pose((0.0, 0.0, 2.0), (1e-3, 0.0, -1.0))  # two metres above the floor, looking down
FLOOR = quad((0, 0, 0), (3, 0, 0), (0, 3, 0))


def seen(renderer, place, at=DOWN, seen_by=SMALL):
    capture = renderer.capture(standing(place, at), rig=rig(seen_by), exposure=Exposure())
    return capture.views[0].luminance_cd_m2[0].astype(np.float64)


def warm_panel(height_m, edge_m=0.2, flux_lm=500.0):
    return panel((0, 0, height_m), edge_m / 2, np.array([1.0, 0.8, 0.5]) * flux_lm)


def tiled(side, count):
    """A rectangle of `small_worlds` in count x count tiles: baked light is known at vertices alone."""
    corner, across, along = side.vertices_m[0], *(side.vertices_m[[1, 3]] - side.vertices_m[0])
    steps = np.linspace(0, 1, count + 1)
    u, v = (grid.reshape(-1, 1) for grid in np.meshgrid(steps, steps, indexing="ij"))
    first = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).reshape(-1, 1)
    a, b, c, d = first, first + count + 1, first + count + 2, first + 1
    triangles = np.vstack([np.hstack([a, b, c]), np.hstack([a, c, d])])
    facing = np.cross(across, along) @ side.normals[0] > 0
    return replace(
        side,
        vertices_m=corner + u * across + v * along,
        normals=np.tile(side.normals[0], (len(u), 1)),
        uv_m=np.zeros((len(u), 2)),
        triangles=triangles if facing else triangles[:, ::-1],
    )


@pytest.mark.parametrize("renderer", BOTH)
def test_lambertian_plane_under_a_small_panel(renderer):
    light = warm_panel(2.5)
    picture = seen(renderer, world([FLOOR], [matte(0.6)], [light]))
    irradiance = light.flux_lm / (np.pi * 2.5**2)  # E = I / d^2 with I = flux / pi straight below
    np.testing.assert_allclose(picture[5:7, 7:9].mean(axis=(0, 1)), 0.6 * irradiance / np.pi, rtol=0.02)


@pytest.mark.parametrize("renderer", BOTH)
def test_lambertian_plane_under_a_sphere(renderer):
    light = Light(np.array([0, 0, 2.5]), np.array([900.0, 700.0, 400.0]), radius_m=0.05)
    picture = seen(renderer, world([FLOOR], [matte(0.6)], [light]))
    irradiance = light.flux_lm / (4 * np.pi * 2.5**2)
    np.testing.assert_allclose(picture[5:7, 7:9].mean(axis=(0, 1)), 0.6 * irradiance / np.pi, rtol=0.02)


@pytest.mark.parametrize("renderer", BOTH)
def test_a_glowing_panel_lights_as_much_as_its_light(renderer):
    # The lamp stands in the world twice, as a light and as what cameras see of it.
    light = warm_panel(2.5)
    shown = quad((0, 0, 2.501), (0, 0.1, 0), (0.1, 0, 0), material=1)
    glow = matte(0.8, emission_cd_m2=light.flux_lm / (np.pi * 0.04))
    picture = seen(renderer, world([FLOOR, shown], [matte(0.6), glow], [light]))
    irradiance = light.flux_lm / (np.pi * 2.5**2)
    np.testing.assert_allclose(picture[5:7, 7:9].mean(axis=(0, 1)), 0.6 * irradiance / np.pi, rtol=0.02)


@pytest.mark.parametrize("renderer", BOTH)
def test_white_furnace(renderer):
    # Under a sky of luminance 3 a surface of reflectance r that sees nothing else has the luminance 3 r.
    picture = seen(renderer, world([FLOOR], [matte(0.7)], indirect_lux=None, ambient_cd_m2=3.0))
    np.testing.assert_allclose(picture.mean(), 0.7 * 3.0, rtol=0.01)


@pytest.mark.parametrize("renderer", BOTH)
def test_integrating_box(renderer):
    # In a closed box of reflectance r and area A, a lamp of flux F in its middle settles at a mean
    # illuminance of F / A / (1 - r), exact in an integrating sphere (CIE 084) and close in a cube, whose six
    # sides are alike. The camera sees one side whole, each pixel an equal area of it.
    reflectance, edge_m = 0.6, 2.0
    lamp = Light(np.zeros(3), np.array([500.0, 400.0, 250.0]), radius_m=0.02)
    cube = [tiled(side, 8) for side in room(np.full(3, -edge_m / 2), np.full(3, edge_m / 2))]
    place = world(cube, [matte(reflectance)], [lamp], indirect_lux=None)
    side = seen(renderer, place, pose((0.05, 0.0, 0.0)), camera(16, 16, 8.0 * 0.95))
    illuminance = lamp.flux_lm / (6 * edge_m**2) / (1 - reflectance)
    np.testing.assert_allclose(side.mean(axis=(0, 1)), reflectance * illuminance / np.pi, rtol=0.04)


def furnished():
    lamp = warm_panel(2.39, edge_m=0.6, flux_lm=1500.0)
    walls = [tiled(side, 6) for side in room((-2, -2, 0), (2, 2, 2.4))]
    parts = [*walls, *box((0.6, -0.3, 0), (1.1, 0.3, 0.8), material=1, object_id=1)]
    return world(parts, [matte(0.6), matte(0.3)], [lamp], indirect_lux=None)


@pytest.mark.gl
def test_both_agree_on_a_furnished_room():
    place, at, through = furnished(), pose((-1.6, 0.4, 1.3), (1.0, -0.2, -0.3)), camera(48, 36, 40.0)
    traced, rasterised = (
        renderer.capture(standing(place, at), rig=rig(through), exposure=Exposure()).views[0]
        for renderer in (TRACED, RASTERISED)
    )
    same = traced.object_id == rasterised.object_id
    assert same.mean() > 0.99
    assert set(np.unique(traced.object_id)) == {0, 1}
    np.testing.assert_allclose(traced.depth_m[same], rasterised.depth_m[same], rtol=1e-3)
    error = rasterised.luminance_cd_m2[..., 1] / traced.luminance_cd_m2[..., 1] - 1
    assert abs(np.median(error)) < 0.05
    assert np.median(np.abs(error)) < 0.08


@pytest.mark.gl
def test_both_show_a_texture_the_same_way_round_and_as_bright():
    image = np.full((64, 64, 3), 40, np.uint8)
    image[:32, :32] = 220  # first quarter: low u, low v
    wall = quad((2.0, 0.0, 0.0), (0, -1, 0), (0, 0, 1), 0)
    material = matte(0.8, texture=image, texture_size_m=2.0)
    sky = {"indirect_lux": None, "ambient_cd_m2": 2.0}
    traced, rasterised = (
        seen(renderer, world([wall], [material], **sky), pose((0, 0, 0)), camera(32, 32, 30.0))[..., 0]
        for renderer in (TRACED, RASTERISED)
    )
    inner = np.s_[4:14, 4:14], np.s_[4:14, 18:28], np.s_[18:28, 4:14], np.s_[18:28, 18:28]
    np.testing.assert_allclose(
        [traced[part].mean() for part in inner], [rasterised[part].mean() for part in inner], rtol=0.03
    )
    assert traced[inner[1]].mean() > 5 * traced[inner[0]].mean()


@pytest.mark.parametrize("centre_px", [None, (20.0, 30.0)])
def test_a_glowing_patch_is_seen_where_geometry_puts_it(centre_px):
    patch = quad((4.0, 0.5, 0.3), (0, -0.1, 0), (0, 0, 0.1))
    place = world([patch], [matte(0.0, emission_cd_m2=np.full(3, 5.0))])
    through = camera(64, 48, 60.0, principal_point_px=centre_px)
    view = TRACED.capture(standing(place), rig=rig(through), exposure=Exposure()).views[0]
    rows, columns = np.indices((48, 64))
    light = view.luminance_cd_m2[0, ..., 0]
    found = (light * columns).sum() / light.sum(), (light * rows).sum() / light.sum()
    expected, _ = project(np.array([4.0, 0.5, 0.3]), through, view.world_from_camera[0])
    np.testing.assert_allclose(found, expected, atol=0.05)
    area_px = (0.2 / 4.0 * 60.0) ** 2
    assert light.sum() == pytest.approx(5.0 * area_px, rel=0.03)


def test_motion_smears_over_the_exposure():
    patch = quad((4.0, 0.0, 0.0), (0, -0.1, 0), (0, 0, 0.1))
    place = world([patch], [matte(0.0, emission_cd_m2=np.full(3, 5.0))])
    aside = moving(place, pose((0, -1.0, 0)), pose((0, 1.0, 0)))  # 2 m/s, so 0.4 m within 0.2 s
    blurred = MitsubaRenderer(MitsubaRenderer.Config(samples=64, motion_samples=16))
    widths = [
        (renderer.capture(aside, rig=rig(camera()), exposure=Exposure(time_s=0.2)).views[0].luminance_cd_m2)[
            0, 24, :, 0
        ]
        for renderer in (TRACED, blurred)
    ]
    sharp, smeared = ((row > 0.01).sum() for row in widths)
    assert sharp <= 4
    assert smeared == pytest.approx(sharp + 0.4 / 4.0 * 60.0, abs=1.5)


def test_noise_falls_with_samples_and_follows_the_seed():
    place = furnished()
    at = pose((-1.6, 0.4, 1.3), (1.0, -0.2, -0.3))
    few, same, other, many = (
        seen(MitsubaRenderer(MitsubaRenderer.Config(samples=samples, seed=seed)), place, at)
        for samples, seed in ((16, 1), (16, 1), (16, 2), (1024, 1))
    )
    np.testing.assert_array_equal(few, same)
    assert not np.array_equal(few, other)
    assert few.mean() == pytest.approx(many.mean(), rel=0.05)


def test_polished_metal_mirrors_its_surroundings():
    metal = Material("metal", np.full(3, 0.9), roughness=0.1, metallic=1.0)
    place = world([FLOOR], [metal], ambient_cd_m2=4.0)
    np.testing.assert_allclose(seen(TRACED, place)[6, 8], 0.9 * 4.0, rtol=0.02)


def panorama(rows=64):
    """Red tells the angle from the zenith, green that from +x, blue which side of it: +y or -y."""
    zenith = (np.arange(rows) + 0.5) / rows
    azimuth = (np.arange(2 * rows) + 0.5) / (2 * rows)
    red, green = np.meshgrid(180 * zenith, 180 * (1 - np.abs(1 - 2 * azimuth)), indexing="ij")
    return np.stack([red, green, np.broadcast_to(azimuth < 0.5, red.shape) * 10.0], axis=-1).astype(
        np.float32
    )


@pytest.mark.parametrize("turn_deg", [0.0, 75.0, -140.0])
def test_the_sky_is_seen_in_its_direction(turn_deg):
    through = camera(24, 16, 40.0, agent_from_camera=agent_from_camera((0, 0, 0), 20.0, turn_deg))
    below = quad((0, 0, -1), (1, 0, 0), (0, 1, 0))
    place = replace(world([below], [matte(0.5)]), sky_cd_m2=panorama())
    view = TRACED.capture(standing(place, pose((0, 0, 2))), rig=rig(through), exposure=Exposure()).views[0]
    rays = pixel_rays(through) @ view.world_from_camera[0, :3, :3].T
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    away = np.abs(rays[..., 1]) > 0.1  # from the seam, where green and blue are not linear
    seen, up = view.luminance_cd_m2[0][away], rays[away]
    assert away.sum() > 100
    assert seen[:, 0] == pytest.approx(np.degrees(np.arccos(up[:, 2])), abs=0.2)
    assert seen[:, 1] == pytest.approx(np.degrees(np.arctan2(np.abs(up[:, 1]), up[:, 0])), abs=0.2)
    assert seen[:, 2] == pytest.approx(np.where(up[:, 1] > 0, 10.0, 0.0), abs=0.1)


def test_a_sky_lights_from_where_it_is_bright():
    """The wall's side that faces +y is lit by a sky that shines from there alone, the other is not."""
    azimuth = (np.arange(64) + 0.5) / 64
    towards_y = np.where(azimuth < 0.5, 10.0, 0.0)
    sky = np.broadcast_to(towards_y[None, :, None], (32, 64, 3)).astype(np.float32)
    wall = quad((0, 0, 0), (3, 0, 0), (0, 0, 3))
    place = replace(world([wall], [matte(0.5)]), sky_cd_m2=sky)
    lit, dark = (seen(TRACED, place, pose((0, y, 0), (1e-3, -y, 0.0))).mean() for y in (2.0, -2.0))
    assert lit == pytest.approx(5.0, rel=0.02)  # a half space of 10 cd/m2 on a reflectance of a half
    assert dark < 0.01  # what the columns between bright and dark send along the wall


def test_a_dark_sky_is_dark():
    place = replace(world([FLOOR], [matte(0.5)]), sky_cd_m2=np.zeros((4, 8, 3), np.float32))
    assert not seen(TRACED, place).any()


def test_without_the_package_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "mitsuba", None)
    with pytest.raises(UserError, match=r"pip install tacos-framework\[mitsuba\]"):
        seen(TRACED, world([FLOOR]))


def test_an_old_llvm_is_refused_before_it_ends_the_process(monkeypatch):
    monkeypatch.setattr(library, "_llvm_version", lambda: (15, 0, 6))
    monkeypatch.setattr(library, "_VARIANTS", {"llvm": "scalar_rgb"})
    with pytest.raises(UserError, match=r"finds LLVM 15\.0\.6"):
        library.mitsuba_for("llvm")


def test_paths_spread_evenly_take_less_noise():
    lit = world([FLOOR], [matte(0.5)], lights=[warm_panel(2.5, edge_m=1.0)])
    spread = {}
    for sampler in ("independent", "low-discrepancy"):
        config = MitsubaRenderer.Config(samples=64, sampler=sampler)
        pictures = [seen(MitsubaRenderer(config.model_copy(update={"seed": seed})), lit) for seed in (1, 2)]
        spread[sampler] = np.std(pictures[0] - pictures[1]) / np.mean(pictures[0])
    assert spread["low-discrepancy"] < 0.5 * spread["independent"]


def test_paths_spread_evenly_come_in_powers_of_four():
    for samples, motion_samples in ((60, 1), (64, 2), (8, 1)):
        with pytest.raises(ValidationError, match="1, 4, 16, 64"):
            MitsubaRenderer.Config(samples=samples, motion_samples=motion_samples, sampler="low-discrepancy")
    MitsubaRenderer.Config(samples=64, motion_samples=4, sampler="low-discrepancy")
