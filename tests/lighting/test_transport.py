"""Light after reflections against closed forms."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from tacos_framework.values import Light, Material
from tacos_plugins.lighting import LightTransport, bake_indirect, irradiance_at
from tacos_plugins.lighting.transport import aligned_with, cosine_fan
from tests.lighting.boxes import ceiling, panel_light, world_of

ORIGIN_UP = np.zeros((1, 3), np.float32), np.array([[0, 0, 1]], np.float32)


def furnace(reflectance: float, flux_lm: float = 1000.0) -> tuple[float, np.ndarray]:
    """A lamp in the middle of a closed white sphere: (direct, indirect at the vertices) [lux]."""
    ball = trimesh.creation.icosphere(3, 2.0)
    ball.invert()
    lamp = Light(np.zeros(3), np.full(3, flux_lm), radius_m=0.05)
    world = world_of(ball, reflectance, (lamp,))
    return flux_lm / (4 * math.pi * 2.0**2), bake_indirect(world, bounces=60)[0]


@pytest.mark.parametrize("reflectance", [0.2, 0.5, 0.8])
def test_furnace_agrees_with_the_geometric_series(reflectance: float) -> None:
    direct, indirect = furnace(reflectance)
    assert indirect.mean() == pytest.approx(direct * reflectance / (1 - reflectance), rel=0.02)
    assert indirect.std() < 0.02 * indirect.mean()


def test_light_is_neither_made_nor_lost_in_a_closed_box() -> None:
    # What the lamp sends out is what the walls absorb: sum of (1 - r) E dA = flux.
    reflectance, flux = 0.6, 800.0
    box = trimesh.creation.box((4, 3, 2.5))
    for _ in range(4):
        box = box.subdivide()
    box.invert()
    world = world_of(box, reflectance, (Light(np.array([0.5, 0.2, 0.3]), np.full(3, flux), radius_m=0.05),))
    points = box.triangles_center.astype(np.float32)
    lux = irradiance_at(world, points, box.face_normals.astype(np.float32))[:, 0]
    absorbed = float(((1 - reflectance) * lux * box.area_faces).sum())
    assert absorbed == pytest.approx(flux, rel=0.03)


def test_black_walls_reflect_nothing() -> None:
    assert furnace(0.0)[1].max() == 0


def test_colour_bleeds_by_the_reflectance_of_each_channel() -> None:
    red = replace(
        world_of(ceiling(2.0, 1.0), lights=(Light(np.zeros(3), np.full(3, 100.0)),)),
        materials=(Material("red", np.array([0.8, 0.2, 0.0])),),
    )
    found = LightTransport(red).indirect_lux(np.zeros((1, 3), np.float32), np.array([[0, 0, 1]], np.float32))[
        0
    ]
    assert found[0] == pytest.approx(4 * found[1])
    assert found[0] > 0 == found[2]


def test_a_texture_counts_with_its_mean_linear_value() -> None:
    checks = np.zeros((2, 2, 3), np.uint8)
    checks[0, 0] = checks[1, 1] = 255
    world = world_of(ceiling(2.0, 1.0), lights=(Light(np.zeros(3), np.full(3, 100.0)),))
    half = replace(world, materials=(Material("half", np.full(3, 0.5)),))
    checked = replace(world, materials=(Material("checks", np.ones(3), texture=checks),))
    place = np.zeros((1, 3), np.float32), np.array([[0, 0, 1]], np.float32)
    assert LightTransport(checked).indirect_lux(*place) == pytest.approx(
        LightTransport(half).indirect_lux(*place)
    )


def test_light_from_beyond_the_world_fills_an_empty_one() -> None:
    sky = replace(world_of(None), ambient_cd_m2=np.full(3, 10.0))
    found = irradiance_at(sky, *ORIGIN_UP)
    assert found[0] == pytest.approx([10 * math.pi] * 3)


def test_light_is_linear_in_flux() -> None:
    one = irradiance_at(world_of(ceiling(2, 3), lights=(panel_light(0.3, 0.3, 2.5, 100.0),)), *ORIGIN_UP)
    three = irradiance_at(world_of(ceiling(2, 3), lights=(panel_light(0.3, 0.3, 2.5, 300.0),)), *ORIGIN_UP)
    assert three == pytest.approx(3 * one)


def test_the_fan_has_the_density_of_the_cosine() -> None:
    fan = cosine_fan(512)
    assert np.linalg.norm(fan, axis=1) == pytest.approx(np.ones(512), abs=1e-5)
    assert fan[:, 2].mean() == pytest.approx(2 / 3, abs=0.01)
    assert fan[:, :2].mean(axis=0) == pytest.approx([0, 0], abs=0.01)


def test_fans_are_turned_onto_their_normals_without_distortion() -> None:
    normals = np.array([[0, 0, 1], [0, 0, -1], [1, 0, 0], [0.6, -0.64, 0.48]], np.float32)
    fan = cosine_fan(32)
    turned = aligned_with(fan, normals)
    assert np.einsum("nij,nj->ni", turned, normals) == pytest.approx(np.tile(fan[:, 2], (4, 1)), abs=1e-5)
    for one in turned:
        assert one @ one.T == pytest.approx(fan @ fan.T, abs=1e-5)
