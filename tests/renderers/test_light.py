"""How bright things are: radiometry, shadows, textures, highlights."""

from __future__ import annotations

import numpy as np
import pytest
from small_worlds import box, camera, matte, panel, pose, quad, rig, room, standing, world

from tacos_framework.values import Exposure, Light, Material
from tacos_plugins.renderers.analytic import AnalyticRenderer
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer

MODERNGL = ModernglRenderer(ModernglRenderer.Config())
ANALYTIC = AnalyticRenderer(AnalyticRenderer.Config())
BOTH = [pytest.param(MODERNGL, marks=pytest.mark.gl, id="moderngl"), pytest.param(ANALYTIC, id="analytic")]

DOWN = pose((0.0, 0.0, 2.0), (1e-3, 0.0, -1.0))  # two metres above the floor, looking down
FLOOR = quad((0, 0, 0), (3, 0, 0), (0, 3, 0))


def luminance(renderer, place, at=DOWN, seen_by=None):
    capture = renderer.capture(standing(place, at), rig=rig(seen_by or camera()), exposure=Exposure())
    return capture.views[0].luminance_cd_m2[0].astype(np.float64)


def bulb(*position_m, flux_lm=1000.0):
    return Light(np.array(position_m), np.array([1.0, 0.8, 0.5]) * flux_lm, radius_m=0.02)


@pytest.mark.parametrize("renderer", BOTH)
def test_lambertian_plane_under_a_small_sphere(renderer):
    light = bulb(0.0, 0.0, 2.5)
    seen = luminance(renderer, world([FLOOR], [matte(0.6)], [light]))
    irradiance = light.flux_lm / (4 * np.pi * 2.5**2)
    np.testing.assert_allclose(seen[24, 32], 0.6 * irradiance / np.pi, rtol=0.01)


@pytest.mark.parametrize("renderer", BOTH)
def test_lambertian_plane_under_a_rectangle(renderer):
    light = panel((0, 0, 2.5), 0.5, 500.0)
    seen = luminance(renderer, world([FLOOR], [matte(1.0)], [light]))
    # Form factor of a rectangle from a point below its corner, four times (Howell, catalogue B-4).
    a = 0.5 / 2.5
    corner = 2 * (a / np.sqrt(1 + a * a) * np.arctan(a / np.sqrt(1 + a * a))) / (2 * np.pi)
    radiated = 500.0 / (np.pi * 1.0)  # luminance of one square metre
    np.testing.assert_allclose(seen[24, 32], radiated * 4 * corner, rtol=0.01)


@pytest.mark.parametrize("renderer", BOTH)
def test_a_lamp_that_all_but_touches_a_surface_leaves_light_finite(renderer):
    seen = luminance(renderer, world([FLOOR], [matte(0.6)], [bulb(0.0, 0.0, 0.021, flux_lm=1e5)]))
    assert np.isfinite(seen).all()
    assert seen[24, 32].min() > seen[24, 60].max()


@pytest.mark.parametrize("renderer", BOTH)
def test_indirect_light_is_reflected_as_irradiance(renderer):
    seen = luminance(renderer, world([FLOOR], [matte(0.5)], indirect_lux=40.0))
    np.testing.assert_allclose(seen[24, 32], 0.5 * 40.0 / np.pi, rtol=0.005)


@pytest.mark.parametrize("renderer", BOTH)
def test_emission_is_seen_as_it_is(renderer):
    seen = luminance(renderer, world([FLOOR], [matte(0.5, emission_cd_m2=np.array([3.0, 2.0, 1.0]))]))
    np.testing.assert_allclose(seen[24, 32], [3.0, 2.0, 1.0], rtol=1e-3)


@pytest.mark.gl
def test_indirect_light_is_baked_where_a_world_has_none():
    # In a closed white room almost all light has been reflected: walls out of the lamp's sight are lit too.
    lamp = panel((0, 0, 2.4), 0.3, 900.0)
    place = world(room((-2, -2, 0), (2, 2, 2.5)), [matte(0.7)], [lamp], indirect_lux=None)
    ceiling = luminance(MODERNGL, place, pose((0.0, 1.0, 1.0), (1e-3, 0, 1.0)))
    assert ceiling[24, 32].min() > 1.0


@pytest.mark.gl
def test_renderers_agree_where_nothing_is_shaded():
    place = world(
        [FLOOR, *box((-0.3, -0.2, 0.0), (0.2, 0.3, 0.3), 1, 1)],
        [matte(0.5), matte(0.8)],
        [bulb(0.0, 0.0, 3.0)],
        indirect_lux=5.0,
    )
    seen_by, exposure = camera(80, 60, 50.0), Exposure()
    ours, theirs = (
        renderer.capture(standing(place, DOWN), rig=rig(seen_by), exposure=exposure).views[0]
        for renderer in (MODERNGL, ANALYTIC)
    )
    same = ours.object_id == theirs.object_id
    assert same.mean() > 0.99
    np.testing.assert_allclose(ours.depth_m[same], theirs.depth_m[same], rtol=1e-4)
    top = (theirs.depth_m < 1.71) & same
    inner = top & np.roll(top, 1, 1) & np.roll(top, -1, 1) & np.roll(top, 1, 2) & np.roll(top, -1, 2)
    assert inner.sum() > 50
    np.testing.assert_allclose(ours.luminance_cd_m2[inner], theirs.luminance_cd_m2[inner], rtol=0.03)


@pytest.mark.gl
def test_shadow_is_dark_in_its_core_and_soft_at_its_edge():
    lamp = panel((0, 0, 3.0), 0.3, 1000.0)
    blocker = box((-0.5, -0.5, 1.0), (0.5, 0.5, 1.05), object_id=1)
    from_below = pose((0.0, 0.0, 0.9), (1e-3, 0.0, -1.0))
    shaded, open_to_light = (
        luminance(MODERNGL, world(parts, lights=[lamp]), from_below, camera(200, 40, 40.0))[20, :, 0]
        for parts in ([FLOOR, *blocker], [FLOOR])
    )
    share = shaded / open_to_light
    assert share[100] == pytest.approx(0.0, abs=1e-3)
    assert share[[5, -5]] == pytest.approx(1.0, abs=1e-2)
    assert (np.diff(share[100:]) > -0.01).all()
    # The lamp is 2 m above the blocker and the floor 1 m below: 0.3 m from dark to lit.
    width_m = ((share > 0.1) & (share < 0.9)).sum() / 2 * 0.9 / 40
    assert width_m == pytest.approx(0.8 * 0.3, rel=0.25)


@pytest.mark.gl
def test_lamps_do_not_shade_their_own_light():
    housing = box((-0.4, -0.4, 2.45), (0.4, 0.4, 2.55), material=1)
    light = panel((0, 0, 2.5), 0.4, 500.0)
    glowing = matte(emission_cd_m2=np.full(3, 100.0))
    bare = luminance(MODERNGL, world([FLOOR], [matte()], [light]))
    housed = luminance(MODERNGL, world([FLOOR, *housing], [matte(), glowing], [light]))
    np.testing.assert_allclose(housed[24, 32], bare[24, 32], rtol=1e-3)


def checkered(size=64):
    squares = np.indices((size, size)).sum(axis=0) % 2
    return np.repeat((squares * 255).astype(np.uint8)[..., None], 3, axis=2)


@pytest.mark.gl
@pytest.mark.parametrize("tilt", [-1.0, -0.4])
def test_distant_texture_keeps_its_mean_reflectance_and_does_not_alias(tilt):
    tiles = matte(1.0, texture=checkered(), texture_size_m=0.16)  # squares of 2.5 mm, far below a pixel
    seen = luminance(
        MODERNGL,
        world([quad((0, 0, 0), (30, 0, 0), (0, 30, 0))], [tiles], indirect_lux=10.0),
        pose((0.0, 0.0, 2.0), (1.0, 0.0, tilt)),
        camera(64, 24, 60.0),
    )[..., 0]
    assert seen.mean() == pytest.approx(0.5 * 10.0 / np.pi, rel=0.02)
    assert seen.std() < 0.03 * seen.mean()


@pytest.mark.gl
def test_texture_scale_and_orientation():
    image = np.full((64, 64, 3), 40, np.uint8)
    image[:32, :32] = 220  # first quarter: low u, low v
    material = matte(1.0, texture=image, texture_size_m=2.0)
    wall = quad((2.0, 0.0, 0.0), (0, -1, 0), (0, 0, 1), 0)  # u to the right, v up, seen from the origin
    seen = luminance(
        MODERNGL, world([wall], [material], indirect_lux=10.0), pose((0, 0, 0)), camera(64, 64, 60.0)
    )
    # The middle of the wall is uv = 0: right and above it is the first quarter.
    assert seen[22, 42, 0] > 5 * seen[42, 22, 0]
    assert seen[22, 42, 0] > 5 * seen[22, 22, 0]
    assert seen[22, 42, 0] > 5 * seen[42, 42, 0]


@pytest.mark.gl
def test_normal_map_brightens_slopes_that_face_the_light():
    tilted = np.full((64, 64, 3), 128, np.uint8)
    tilted[:, :32, 0], tilted[:, 32:, 0] = 168, 88  # slopes towards +u, then -u
    tilted[..., 2] = 245
    material = matte(0.8, normal_map=tilted, texture_size_m=2.0)
    seen = luminance(MODERNGL, world([FLOOR], [material], [bulb(6.0, 0.0, 3.0)]))
    # Looking down with x up in the image; u grows along x, so the first half of a tile lies above the middle.
    facing, averted = seen[16, 32, 0], seen[32, 32, 0]
    assert facing > 1.2 * averted


@pytest.mark.gl
def test_polished_metal_mirrors_the_lamp_and_matte_paint_does_not():
    lamp = panel((2.0, 0, 2.0), 0.2, 300.0)
    metal = Material("metal", np.full(3, 0.9), roughness=0.1, metallic=1.0)
    looking = pose((0.0, 0.0, 2.0), (1.0, 0.0, -2.0))  # meets the floor midway: the lamp's reflection
    peaks = {}
    for name, material in (("metal", metal), ("matte", matte(0.9))):
        walls = room((-3, -3, 0), (5, 3, 2.2), 1)
        place = world([quad((1, 0, 0.01), (3, 0, 0), (0, 3, 0)), *walls], [material, matte(0.5)], [lamp])
        peaks[name] = luminance(MODERNGL, place, looking)[16:32, 24:40, 0]
    lamp_luminance = 300.0 / (np.pi * 0.16)
    assert peaks["metal"].max() > 0.3 * lamp_luminance
    assert peaks["metal"].max() < 1.2 * lamp_luminance
    assert peaks["matte"].max() < 0.05 * lamp_luminance


@pytest.mark.gl
def test_metal_reflects_its_surroundings_rather_than_black():
    metal = Material("metal", np.full(3, 0.9), roughness=0.3, metallic=1.0)
    place = world(
        [quad((0, 0, 0.5), (1, 0, 0), (0, 1, 0)), *room((-3, -3, 0), (3, 3, 2.2), 1)],
        [metal, matte(0.8)],
        indirect_lux=50.0,
    )
    seen = luminance(MODERNGL, place)[24, 32]
    np.testing.assert_allclose(seen, 0.9 * 0.8 * 50.0 / np.pi, rtol=0.3)
