"""Frames over time: anti-aliasing, motion blur, repeatability, memory."""

from __future__ import annotations

import multiprocessing

import numpy as np
import pytest
from small_worlds import camera, matte, moving, pose, quad, rig, standing, world

from tacos_framework.camera.geometry import agent_from_camera
from tacos_framework.values import Exposure, Light
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer

pytestmark = pytest.mark.gl
WALL = quad((2.0, 0.0, 0.0), (0, -0.5, 0), (0, 0, 0.5))
GLOWING = matte(emission_cd_m2=np.ones(3))


def frames(episode, seen_by=None, exposure=None, **settings):
    renderer = ModernglRenderer(ModernglRenderer.Config(**settings))
    return renderer.capture(episode, rig=rig(seen_by or camera()), exposure=exposure or Exposure()).views[0]


def test_edges_are_averaged_over_the_pixel():
    # An edge a little off the vertical: each row's brightness is the covered width, to the sub-pixel.
    slanted = quad((2.0, 1.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.1, 1.0))
    view = frames(standing(world([slanted], [GLOWING])), camera(64, 48, 60.0))
    light = view.luminance_cd_m2[0, ..., 0].astype(np.float64)
    rows = np.arange(48)
    edge_m = 0.1 * -(rows - 23.5) / 30.0  # y of the right edge at the row's height, at 2 m
    expected = 31.5 - 30.0 * edge_m + 0.5  # pixels from the left border to the edge
    covered = light.sum(axis=1)
    partial = ((light > 0.05) & (light < 0.95)).any(axis=1)
    assert partial.mean() > 0.5
    inside = (rows > 2) & (rows < 45)
    assert np.abs(covered - expected)[inside].max() < 0.3
    assert np.abs(covered - expected)[inside].mean() < 0.1


def test_motion_blur_averages_over_the_exposure():
    start, end = pose((0, 0.2, 0)), pose((0, -0.2, 0))
    exposure = Exposure(time_s=0.5)
    sharp = frames(moving(world([WALL], [GLOWING]), start, end), exposure=exposure)
    blurred = frames(moving(world([WALL], [GLOWING]), start, end), exposure=exposure, motion_samples=16)
    row_sharp, row_blurred = (view.luminance_cd_m2[0, 24, :, 0] for view in (sharp, blurred))
    # 0.2 m of travel at 2 m is 6 px of ramp on both edges, and no light is lost.
    ramp = ((row_blurred > 0.05) & (row_blurred < 0.95)).sum()
    assert 10 <= ramp <= 14
    assert ((row_sharp > 0.05) & (row_sharp < 0.95)).sum() <= 2
    assert row_blurred.sum() == pytest.approx(row_sharp.sum(), rel=0.02)
    np.testing.assert_array_equal(sharp.depth_m, blurred.depth_m)  # truth is that of the middle


def a_lit_world():
    lamp = Light(np.array([0.5, 0.3, 1.0]), np.array([100.0, 90.0, 80.0]))
    return world(
        [WALL, quad((1, 0, -0.5), (2, 0, 0), (0, 2, 0), 1)], [matte(0.7), matte(0.5, roughness=0.2)], [lamp]
    )


def test_equal_frames_for_equal_input_whatever_the_batches():
    episode = moving(a_lit_world(), pose((0, 0.2, 0)), pose((0, -0.2, 0)), frames=4)
    whole, first, rest = frames(episode), frames(episode[:1]), frames(episode[1:])
    for name in ("luminance_cd_m2", "depth_m", "object_id"):
        joined = np.concatenate([getattr(first, name), getattr(rest, name)])
        np.testing.assert_array_equal(getattr(whole, name), joined)


@pytest.mark.parametrize(
    "settings", [{"antialiasing": "multisampling", "samples": 4}, {"antialiasing": "none"}]
)
@pytest.mark.parametrize("motion_samples", [1, 3])
def test_reading_through_buffers_changes_nothing(settings, motion_samples):
    episode = moving(a_lit_world(), pose((0, 0.2, 0)), pose((0, -0.2, 0)), frames=3)
    direct, buffered = (
        frames(episode, read_back=way, motion_samples=motion_samples, **settings)
        for way in ("direct", "buffered")
    )
    assert not np.array_equal(direct.luminance_cd_m2[0], direct.luminance_cd_m2[1])
    for name in ("luminance_cd_m2", "depth_m", "object_id"):
        np.testing.assert_array_equal(getattr(direct, name), getattr(buffered, name))


def picture_of_a_lit_world() -> bytes:
    return frames(standing(a_lit_world())).luminance_cd_m2.tobytes()


def _send_picture(connection):
    connection.send_bytes(picture_of_a_lit_world())


def test_another_process_renders_the_same():
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    worker = context.Process(target=_send_picture, args=(sender,))
    worker.start()
    theirs = receiver.recv_bytes()
    worker.join()
    assert theirs == picture_of_a_lit_world()


def test_memory_stays_flat_over_many_frames_and_sizes():
    place = a_lit_world()

    def render(sizes):
        for width in sizes:
            frames(standing(place, frames=3), camera(width, 160, 60.0))

    render(range(200, 230, 2))
    before = _resident_bytes()
    for _ in range(4):
        render(range(200, 230, 2))
    assert _resident_bytes() - before < 30e6


def _resident_bytes():
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * 4096


def test_worlds_used_long_ago_are_let_go_and_come_back_the_same():
    first = a_lit_world()
    before = frames(standing(first)).luminance_cd_m2
    for _ in range(3):
        frames(standing(a_lit_world()))
    np.testing.assert_array_equal(frames(standing(first)).luminance_cd_m2, before)


def test_light_depends_on_optics_and_pose_and_not_on_names_or_gain():
    episode = standing(a_lit_world())
    base = frames(episode, camera())
    unread = frames(episode, camera(name="other"), Exposure(f_number=8.0, gain_db=12.0))
    np.testing.assert_array_equal(base.luminance_cd_m2, unread.luminance_cd_m2)
    for change in (
        {"focal_px": 61.0},
        {"principal_point_px": (31.0, 23.0)},
        {"agent_from_camera": agent_from_camera((0, 0, 0), 1.0)},
    ):
        assert not np.array_equal(base.luminance_cd_m2, frames(episode, camera(**change)).luminance_cd_m2)
