"""The target with relief: what stands where, how bright it is, and how the camera passes."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_framework.values import Exposure
from tacos_plugins.lighting import LightTransport
from tacos_plugins.renderers.analytic import AnalyticRenderer
from tacos_worlds.bench.relief_target import ReliefTarget, rectangle
from tests.small_worlds import camera, rig

SMALL = {"blocks": 3, "texture_px": 128, "wall_m": 2.0, "size_m": 0.3, "relief_m": 0.09, "distance_m": 0.5}


def target(seed: int = 1, lux: float = 1000.0, **config):
    scene = ReliefTarget(ReliefTarget.Config(**{**SMALL, **config}))
    return scene.episode(rng=np.random.default_rng(seed), illumination_lux=lux)


def seen(episode, frame: int):
    looking = rig(camera(40, 30, focal_px=33.0))
    return AnalyticRenderer(AnalyticRenderer.Config()).capture(
        episode[frame : frame + 1], rig=looking, exposure=Exposure()
    ).views[0]  # fmt: skip


def test_blocks_stand_out_by_evenly_spread_heights_before_the_wall():
    view = seen(target(frames=3), 1)
    fronts = np.unique(np.round(view.depth_m[0][view.object_id[0] == 1], 3))
    np.testing.assert_allclose(fronts.min(), 0.5, atol=1e-3)
    np.testing.assert_allclose(fronts.max(), 0.59, atol=1e-3)
    assert len(fronts) >= 9
    np.testing.assert_allclose(view.depth_m[0][view.object_id[0] == 0], 0.5 + 0.09 + 0.3, atol=1e-3)


def test_surfaces_of_blocks_face_outwards():
    world = target().world
    middle = np.array([0.5 + 0.09, 0.0, 0.0])
    for part in world.parts:
        a, b, c = part.vertices_m[part.triangles[0]]
        np.testing.assert_allclose(
            np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a)), part.normals[0], atol=1e-4
        )
    fronts = [part for part in world.parts[1:] if part.normals[0, 0] < -0.9]
    assert len(fronts) == 9
    assert all(part.vertices_m[:, 0].max() <= middle[0] + 1e-6 for part in fronts)


def test_the_camera_passes_at_even_steps_and_the_target_goes_right():
    episode = target(frames=5, way_m=0.2)
    poses = episode.trajectory.at(episode.time_s)
    np.testing.assert_allclose(poses[:, 1, 3], [-0.1, -0.05, 0.0, 0.05, 0.1], atol=1e-9)
    columns = [np.nonzero(seen(episode, i).object_id[0])[1].mean() for i in (0, 4)]
    assert columns[0] < 19.5 < columns[1]


def test_a_single_frame_stands_still():
    assert len(target(frames=1)) == 1


def test_the_front_receives_the_illuminance_asked_for_and_recesses_receive_reflected_light():
    world = target(lux=1000.0, relief_m=0.0).world
    transport = LightTransport(world)
    grid = np.linspace(-0.14, 0.14, 9)
    y, z = (each.ravel() for each in np.meshgrid(grid, grid))
    points = np.stack([np.full(y.size, 0.5 - 1e-3), y, z], 1).astype(np.float32)
    facing = np.tile(np.array([-1, 0, 0], np.float32), (len(points), 1))
    assert transport.direct_lux(points, facing).mean() == pytest.approx(1000.0, rel=0.03)
    deep = target(lux=1000.0).world
    assert deep.indirect_lux is not None
    assert max(lux.max() for lux in deep.indirect_lux[1:]) > 20.0


def test_another_seed_is_another_target_and_the_way_is_not_part_of_the_world():
    assert target(1).world.key != target(2).world.key
    assert target(1).world.key == target(1, way_m=0.4, frames=4).world.key


def test_rectangles_are_cut_no_coarser_than_asked():
    part = rectangle(np.zeros(3), np.array([0, 0.1, 0]), np.array([0, 0, 0.025]), 0, 1, 0.03)
    assert len(part.triangles) == 2 * 7 * 2
    corners = part.vertices_m[part.triangles]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    assert areas.sum() == pytest.approx(0.2 * 0.05, rel=1e-5)
