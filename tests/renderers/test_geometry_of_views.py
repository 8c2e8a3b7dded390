"""Where things appear, how far, and whose they are: renderers against OpenCV and by hand."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from small_worlds import camera, disc, matte, pose, quad, rig, standing, world

from tacos_framework.camera.geometry import agent_from_camera, invert_pose, pixel_rays, world_from_camera
from tacos_framework.values import Exposure
from tacos_plugins.renderers.analytic import AnalyticRenderer
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer

MODERNGL = ModernglRenderer(ModernglRenderer.Config(light_texel_m=0.2))
ANALYTIC = AnalyticRenderer(AnalyticRenderer.Config())
GLOWING = matte(emission_cd_m2=np.ones(3))
AGENT = pose((1.0, -2.0, 1.6), (0.8, 0.5, 0.0))

CAMERAS = {
    "level": camera(320, 240, 300.0),
    "off-centre": camera(320, 240, 300.0, principal_point_px=(100.3, 160.8)),
    "pitched": camera(320, 240, 250.0, agent_from_camera=agent_from_camera((0.1, 0.0, 0.05), -20.0)),
    "stereo": camera(320, 240, 300.0, agent_from_camera=agent_from_camera((0.0, -0.3, 0.0), 5.0)),
    "odd": camera(201, 133, 150.0),
}


def one_view(renderer, episode, seen_by):
    (view,) = renderer.capture(episode, rig=rig(seen_by), exposure=Exposure()).views
    return view


@pytest.mark.gl
@pytest.mark.parametrize("name", CAMERAS)
def test_small_things_appear_where_opencv_projects_them(name):
    seen_by = CAMERAS[name]
    to_world = world_from_camera(AGENT, seen_by.agent_from_camera)
    right, down = to_world[:3, 0], to_world[:3, 1]
    wanted_px = np.array([[40.0, 30.0], [seen_by.width_px - 33.3, 40.6], [90.4, seen_by.height_px - 35.2]])
    depths = np.array([2.0, 3.1, 7.7])
    rays = np.column_stack([(wanted_px - seen_by.centre_px) / seen_by.focal_length_px, np.ones(3)])
    centres = (rays * depths[:, None]) @ to_world[:3, :3].T + to_world[:3, 3]
    radii = 9.0 * depths / seen_by.focal_length_px
    discs = [
        disc(c, right, -down, r, object_id=i + 1) for i, (c, r) in enumerate(zip(centres, radii, strict=True))
    ]
    view = one_view(MODERNGL, standing(world(discs, [GLOWING]), AGENT), seen_by)

    from_world = invert_pose(to_world)
    expected, _ = cv2.projectPoints(
        centres, cv2.Rodrigues(from_world[:3, :3])[0], from_world[:3, 3], seen_by.intrinsics, None
    )
    light = view.luminance_cd_m2[0, ..., 0].astype(np.float64)
    rows, columns = np.indices(light.shape)
    for thing, (x, y) in enumerate(expected[:, 0], start=1):
        near = np.hypot(columns - x, rows - y) < 12
        weight = light * near
        centroid = np.array([(weight * columns).sum(), (weight * rows).sum()]) / weight.sum()
        np.testing.assert_allclose(centroid, (x, y), atol=0.05)
        assert view.object_id[0, round(y), round(x)] == thing
        assert view.depth_m[0, round(y), round(x)] == pytest.approx(depths[thing - 1], rel=1e-4)


@pytest.mark.parametrize(
    "renderer",
    [pytest.param(MODERNGL, marks=pytest.mark.gl, id="moderngl"), pytest.param(ANALYTIC, id="analytic")],
)
@pytest.mark.parametrize("name", ["off-centre", "pitched"])
def test_depth_is_that_of_the_plane(renderer, name):
    seen_by = CAMERAS[name]
    floor = quad((0.0, 0.0, 0.0), (40.0, 0.0, 0.0), (0.0, 40.0, 0.0))
    view = one_view(renderer, standing(world([floor]), AGENT), seen_by)
    to_world = world_from_camera(AGENT, seen_by.agent_from_camera)
    falls = pixel_rays(seen_by) @ to_world[2, :3]
    with np.errstate(divide="ignore"):
        expected = np.where(falls < 0, -to_world[2, 3] / falls, np.inf)
    seen = np.isfinite(view.depth_m[0])
    assert seen.mean() > 0.25
    np.testing.assert_allclose(view.depth_m[0][seen], expected[seen], rtol=1e-5)
    assert (expected[~seen] > 25).all()  # beyond the plane's edge, or above the horizon


@pytest.mark.gl
def test_disparity_is_focal_length_times_baseline_over_depth():
    left, right = (
        CAMERAS["level"],
        camera(320, 240, 300.0, name="right", agent_from_camera=agent_from_camera((0.0, -0.12, 0.0), 0.0)),
    )
    target = disc((4.0, 0.0, 0.0), (0, -1, 0), (0, 0, 1), 0.12)
    capture = MODERNGL.capture(
        standing(world([target], [GLOWING])), rig=rig(left, right), exposure=Exposure()
    )
    columns = [
        float(
            (view.luminance_cd_m2[0, ..., 0].sum(axis=0) * np.arange(320)).sum()
            / view.luminance_cd_m2[0, ..., 0].sum()
        )
        for view in capture.views
    ]
    assert columns[0] - columns[1] == pytest.approx(300.0 * 0.12 / 4.0, abs=0.03)


@pytest.mark.gl
def test_cameras_of_different_sizes_share_a_rig():
    small, large = camera(31, 17, 20.0, name="small"), camera(200, 160, 100.0, name="large")
    wall = quad((2.0, 0.0, 0.0), (0, -5, 0), (0, 0, 5))
    views = MODERNGL.capture(
        standing(world([wall]), frames=2), rig=rig(small, large), exposure=Exposure()
    ).views
    assert [view.depth_m.shape for view in views] == [(2, 17, 31), (2, 160, 200)]
    for view in views:
        np.testing.assert_allclose(view.depth_m, 2.0, rtol=1e-6)


@pytest.mark.gl
def test_an_empty_world_is_ambient_light_without_depth():
    view = one_view(MODERNGL, standing(world([], ambient_cd_m2=3.0)), camera())
    assert (view.luminance_cd_m2 == 3.0).all()
    assert np.isinf(view.depth_m).all()
    assert (view.object_id == 0).all()


@pytest.mark.gl
def test_both_sides_of_an_open_sheet_are_seen_and_hide_what_is_behind():
    away = quad((2.0, 0.0, 0.0), (0, 5, 0), (0, 0, 5), object_id=1)
    behind = quad((3.0, 0.0, 0.0), (0, -5, 0), (0, 0, 5), object_id=2)
    view = one_view(MODERNGL, standing(world([behind, away])), camera())
    assert (view.object_id == 1).all()
