"""Pictures taken from cube maps equal those that are drawn, within what a recipe's scores tolerate."""

from __future__ import annotations

import numpy as np
import pytest
from small_worlds import box, camera, matte, moving, pose, quad, rig, room, standing, world

from tacos_framework.camera.geometry import agent_from_camera
from tacos_framework.values import Exposure, FrameBatch, Light
from tacos_plugins.renderers.moderngl.panorama import Face, FaceStore
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer
from tacos_plugins.renderers.moderngl.resample import fineness
from tacos_plugins.tasks.orb_features import OrbFeatures
from tacos_worlds.indoor.scene import IndoorScene

DIRECT = ModernglRenderer(ModernglRenderer.Config(light_texel_m=0.2))
REUSING = ModernglRenderer(
    ModernglRenderer.Config(light_texel_m=0.2, reuse="cube-map", reuse_face_px=512, reuse_memory_mb=200)
)


def views(episode, seen_by):
    return [
        each.capture(episode, rig=rig(seen_by), exposure=Exposure()).views[0] for each in (DIRECT, REUSING)
    ]


def a_room():
    lamp = Light(np.array([0.3, 0.2, 1.8]), np.full(3, 800.0))
    things = box((0.8, -0.4, 0.0), (1.2, 0.4, 0.6), 1, 1) + box((-0.5, 1.2, 0.0), (0.3, 1.6, 1.2), 1, 2)
    return world([*room((-2, -2, 0), (2, 2, 2.2)), *things], [matte(0.7), matte(0.3)], [lamp])


@pytest.mark.gl
@pytest.mark.parametrize("pitch_deg", [-40.0, 0.0, 25.0])
def test_light_depth_and_ids_agree_across_the_seams_of_the_faces(pitch_deg):
    seen_by = camera(160, 120, 110.0, agent_from_camera=agent_from_camera((0.1, 0.0, 0.0), pitch_deg))
    direct, reused = views(standing(a_room(), pose((-1.0, -1.0, 1.3), (1.0, 0.8, 0.0))), seen_by)
    same = direct.object_id == reused.object_id
    assert same.mean() > 0.995
    error = np.abs(reused.depth_m[same] / direct.depth_m[same] - 1)
    assert np.median(error) < 1e-5
    assert np.quantile(error, 0.99) < 0.02
    light, expected = reused.luminance_cd_m2[same], direct.luminance_cd_m2[same]
    assert np.median(np.abs(light - expected) / (expected + 1e-3)) < 0.01
    assert reused.luminance_cd_m2.mean() == pytest.approx(direct.luminance_cd_m2.mean(), rel=0.005)


@pytest.mark.gl
def test_finer_cameras_than_the_map_are_drawn():
    episode = standing(a_room(), pose((-1.0, -1.0, 1.3)))
    direct, reused = views(episode, camera(160, 120, 600.0))
    np.testing.assert_array_equal(direct.luminance_cd_m2, reused.luminance_cd_m2)
    np.testing.assert_array_equal(direct.depth_m, reused.depth_m)


@pytest.mark.gl
def test_nothing_is_infinitely_far_and_belongs_to_the_background():
    sheet = quad((2.0, 0.0, 0.0), (0, -0.4, 0), (0, 0, 0.4), object_id=1)
    direct, reused = views(standing(world([sheet], ambient_cd_m2=2.0)), camera(96, 64, 60.0))
    assert (np.isinf(reused.depth_m) == np.isinf(direct.depth_m)).mean() > 0.99
    assert reused.luminance_cd_m2[0, 0, 0] == pytest.approx(2.0)


@pytest.mark.gl
def test_orb_scores_of_furnished_rooms_agree():
    scene = IndoorScene(IndoorScene.Config(size_m=(8.0, 8.0), frames=24, frame_rate_hz=10.0))
    episode = scene.episode(rng=np.random.default_rng(3), illumination_lux=20.0)[:8]
    seen_by = camera(240, 180, 160.0)
    scores = []
    for each in (DIRECT, REUSING):
        scorer = OrbFeatures(OrbFeatures.Config(features=400, fast_threshold=7)).begin()
        capture = each.capture(episode, rig=rig(seen_by), exposure=Exposure())
        light = capture.views[0].luminance_cd_m2
        image = np.rint(np.clip(255 * light / 6.0, 0, 255)).astype(np.uint8)
        scorer.update(FrameBatch(capture, (image,)))
        scores.append(scorer.scores())
    direct, reused = scores
    assert direct["inliers"] > 50
    assert reused["inliers"] == pytest.approx(direct["inliers"], rel=0.1)
    assert reused["inlier_ratio"] == pytest.approx(direct["inlier_ratio"], abs=0.05)


@pytest.mark.gl
def test_reused_frames_do_not_depend_on_what_was_taken_before():
    place = a_room()
    seen_by = camera(96, 64, 60.0)
    episode = moving(place, pose((-1, 0, 1.2)), pose((0, -1, 1.2)), frames=2)
    first = REUSING.capture(episode, rig=rig(seen_by), exposure=Exposure()).views[0]
    REUSING.capture(standing(place, pose((1, 1, 1))), rig=rig(seen_by), exposure=Exposure())
    again = REUSING.capture(episode[1:], rig=rig(seen_by), exposure=Exposure()).views[0]
    np.testing.assert_array_equal(first.luminance_cd_m2[1:], again.luminance_cd_m2)


def test_the_map_must_be_finer_everywhere():
    level = np.eye(4)[[2, 0, 1, 3]][:3, :3].T
    assert fineness(camera(64, 48, 60.0), level, 240).min() >= 1.0
    assert fineness(camera(64, 48, 60.0), level, 240).max() == pytest.approx(2.0, rel=0.01)
    # At the rim, the pixels of a wide camera turned to an edge of the cube are finer than those of the faces.
    turned = pose((0, 0, 0), (1.0, 1.0, 0.0))[:3, :3] @ level
    assert fineness(camera(200, 48, 60.0), turned, 120).min() < 1.0


def test_faces_used_longest_ago_go_when_the_memory_is_full():
    def face():
        return Face((np.zeros((10, 10, 3), np.float32),), *np.zeros((2, 10, 10), np.float32))

    size = face().size_bytes
    store, made = FaceStore(2 * size), []

    def get(key):
        return store.get(key, lambda: made.append(key) or face())

    for key in "abacab":
        get(key)
    assert made == ["a", "b", "c", "b"]
    assert store.held_bytes == 2 * size
