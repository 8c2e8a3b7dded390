"""Direct light against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_framework.values import Light
from tacos_plugins.lighting import LightTransport, irradiance_at
from tests.lighting.boxes import panel_light, world_of

UP = np.array([[0, 0, 1]], np.float32)


def form_factor_of_corner(a: float, b: float, c: float) -> float:
    """From a small element to a parallel a x b rectangle, one corner of which lies c above it (Howell)."""
    x, y = a / c, b / c
    first = x / math.hypot(1, x) * math.atan(y / math.hypot(1, x))
    second = y / math.hypot(1, y) * math.atan(x / math.hypot(1, y))
    return (first + second) / (2 * math.pi)


@pytest.mark.parametrize(("half_u", "half_v", "height"), [(0.5, 0.3, 2.0), (0.3, 0.3, 0.8), (0.6, 0.15, 1.0)])
def test_rectangle_agrees_with_its_form_factor(half_u: float, half_v: float, height: float) -> None:
    flux = 1000.0
    world = world_of(None, lights=(panel_light(half_u, half_v, height, flux),))
    exitance = flux / (4 * half_u * half_v)
    expected = exitance * 4 * form_factor_of_corner(half_u, half_v, height)
    found = irradiance_at(world, np.zeros((1, 3), np.float32), UP)
    assert found[0] == pytest.approx([expected] * 3, rel=0.003)


@given(
    distance=st.floats(0.5, 5.0),
    tilt=st.floats(0.0, 1.5),
    radius=st.floats(0.02, 0.2),
    flux=st.floats(1, 5000),
)
@settings(max_examples=40, deadline=None)
def test_sphere_follows_the_inverse_square_and_cosine_laws(
    distance: float, tilt: float, radius: float, flux: float
) -> None:
    lamp = Light(np.array([0, 0, distance]), np.full(3, flux), radius_m=radius)
    normal = np.array([[math.sin(tilt), 0, math.cos(tilt)]], np.float32)
    found = irradiance_at(world_of(None, lights=(lamp,)), np.zeros((1, 3), np.float32), normal)
    assert found[0, 0] == pytest.approx(flux / (4 * math.pi * distance**2) * math.cos(tilt), rel=1e-4)


def test_nothing_arrives_from_behind_a_panel_or_behind_the_surface() -> None:
    world = world_of(None, lights=(panel_light(0.3, 0.3, 2.0, 1000.0),))
    above = np.array([[0, 0, 3.0]], np.float32)
    assert irradiance_at(world, above, -UP).max() == 0
    assert irradiance_at(world, np.zeros((1, 3), np.float32), -UP).max() == 0


def test_a_body_between_light_and_point_casts_a_shadow() -> None:
    light = panel_light(0.1, 0.1, 2.0, 1000.0)
    slab = trimesh.creation.box((1, 1, 0.1), trimesh.transformations.translation_matrix([0, 0, 1]))
    points = np.array([[0, 0, 0], [3, 0, 0]], np.float32)
    direct = LightTransport(world_of(slab, lights=(light,))).direct_lux(points, np.repeat(UP, 2, axis=0))
    open_air = LightTransport(world_of(None, lights=(light,))).direct_lux(points, np.repeat(UP, 2, axis=0))
    assert direct[0].max() == 0
    assert direct[1] == pytest.approx(open_air[1])


def test_a_shade_inside_the_sphere_of_its_lamp_blocks_nothing() -> None:
    lamp = Light(np.array([0, 0, 1.0]), np.full(3, 500.0), radius_m=0.2)
    shade = trimesh.creation.cylinder(
        0.14, 0.2, transform=trimesh.transformations.translation_matrix([0, 0, 1])
    )
    angle = np.linspace(0, 2 * math.pi, 9)
    points = np.column_stack([2 * np.cos(angle), 2 * np.sin(angle), np.zeros(9)]).astype(np.float32)
    normals = np.repeat(UP, 9, axis=0)
    shaded = LightTransport(world_of(shade, lights=(lamp,))).direct_lux(points, normals)
    assert shaded == pytest.approx(LightTransport(world_of(None, lights=(lamp,))).direct_lux(points, normals))
