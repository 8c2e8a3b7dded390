"""Which probes places mirror, and that reflections jump nowhere but where things end."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from small_worlds import box, camera, matte, pose, quad, rig, room, standing, world

from tacos_framework.values import Exposure, Light, Material
from tacos_plugins.renderers.light.probe_map import ProbeMap, map_probes, two_heaviest
from tacos_plugins.renderers.light.rays import RayTracer
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer

SIDES = np.array([[1.0, 1.0, 1.0], [5.0, 1.0, 1.0]])  # probes on either side of a wall at x = 3
WALL = np.array([[(3, -1, -1), (3, 9, -1), (3, -1, 9)]], np.float32)


def test_a_place_mirrors_the_probe_it_sees_rather_than_the_nearer_one():
    mapped = map_probes(SIDES, np.zeros(3), np.array([10.0, 4.0, 2.0]), RayTracer(WALL))
    column = int(2.8 / mapped.cell_m)
    assert (mapped.first[:, :column] == 0).all()
    assert (mapped.first[:, int(3.2 / mapped.cell_m) :] == 1).all()
    assert (mapped.share == 0).all()


def test_between_probes_in_sight_of_one_another_one_passes_into_the_other():
    mapped = map_probes(SIDES, np.zeros(3), np.array([6.0, 2.0, 2.0]), RayTracer(WALL + np.float32(100)))
    of_second = np.where(mapped.first == 1, 1 - mapped.share, mapped.share)[len(mapped.share) // 2]
    assert of_second[0] == 0
    assert of_second[-1] == 1
    assert (np.diff(of_second) >= 0).all()
    assert np.diff(of_second).max() < 0.15


@given(arrays(np.float64, (4, 3), elements=st.floats(0, 10)), st.integers(0, 2), st.floats(1e-9, 1e-6))
def test_shares_change_little_where_weights_do(weight, probe, change):
    def shares(weights):
        first, second, share = two_heaviest(weights)
        out = np.zeros_like(weights)
        np.add.at(out, (np.arange(len(out)), first), 1 - share)
        np.add.at(out, (np.arange(len(out)), second), share)
        return out

    weight = weight + 1.0
    weight[:, 0] += 1.0  # a heaviest one far enough above the third
    other = weight.copy()
    other[:, probe] += change
    top = np.sort(weight, axis=1)
    clear = top[:, 2] - top[:, 0] > 1e-2
    np.testing.assert_allclose(shares(weight)[clear], shares(other)[clear], atol=1e-3)


def test_a_map_survives_being_packed_into_single_numbers():
    rng = np.random.default_rng(0)
    first, second = rng.integers(0, 24, (2, 9, 7), dtype=np.int32)
    share = rng.uniform(0, 0.5, (9, 7)).astype(np.float32)
    packed = ProbeMap(first, second, share, np.zeros(2), 0.1).packed().astype(np.int64)
    np.testing.assert_array_equal(packed & 31, first)
    np.testing.assert_array_equal(packed >> 5 & 31, second)
    np.testing.assert_allclose((packed >> 10) / 1023, share, atol=1e-3)


@pytest.mark.gl
def test_a_polished_floor_through_two_rooms_has_no_edges_of_its_triangles():
    # A bright and a dim room share a floor of two triangles, each with corners in both.
    floor = quad((0, 0, 0.01), (6, 0, 0), (0, 2, 0))
    shell = room((-6, -2, 0), (6, 2, 2.5), 1)
    divide = box((-0.05, -2, 0), (0.05, 2, 2.5), material=1)
    lamps = [
        Light(np.array([x, 0, 2.3]), np.full(3, flux), radius_m=0.1) for x, flux in ((-3, 50.0), (3, 5000.0))
    ]
    polished = Material("polished", np.full(3, 0.2), roughness=0.3)
    view = pose((-5.0, 0.0, 1.2), (1.0, 0.0, -0.4))
    renderer = ModernglRenderer(ModernglRenderer.Config())
    place = world([floor, *shell, *divide], [polished, matte(0.5)], lamps)
    capture = renderer.capture(standing(place, view), rig=rig(camera(160, 120, 100.0)), exposure=Exposure())
    light = capture.views[0].luminance_cd_m2[0].mean(axis=-1)
    jump = np.abs(np.diff(np.log(light[90:115]), axis=1)).max()  # on the floor of the dim room alone
    assert jump < 0.05
