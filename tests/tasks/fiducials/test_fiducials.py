"""Markers in frames that OpenCV warps them into, where all is known."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tacos_framework.camera import agent_from_camera, project
from tacos_framework.errors import UserError
from tacos_framework.testing import TaskConformance
from tacos_framework.testing.samples import sample_capture, sample_episode, sample_world
from tacos_framework.values import Camera, Capture, FrameBatch, MeshPart, Object, Trajectory, View
from tacos_plugins.tasks.fiducials.families import CLASS_NAME, cells_of, dictionary_of, tags_of
from tacos_plugins.tasks.fiducials.sightings import (
    Sighting,
    in_field_of_work,
    in_sight,
    range_m,
    scores_of,
)
from tacos_plugins.tasks.fiducials.task import Fiducials

FAMILY = "apriltag_36h11"
SHEET_M = 0.25
CAMERA = Camera(
    "camera", 640, 480, pixel_um=3.0, focal_length_mm=1.2, agent_from_camera=agent_from_camera((0, 0, 0), 0)
)


def world_with(numbers=(7,), turn_deg: float = 0.0):
    """Markers side by side on sheets at x = 0, read from where x is below 0."""
    world = sample_world()
    turn = cv2.Rodrigues(np.array([0.0, 0.0, np.radians(turn_deg)]))[0]
    half = SHEET_M / 2
    parts, objects = [], []
    for place, number in enumerate(numbers):
        # from the lower left counter-clockwise as who looks along +x sees it: left is +y
        sheet = np.array([[0, half, -half], [0, -half, -half], [0, -half, half], [0, half, half]]) @ turn.T
        parts.append(
            MeshPart(
                (sheet + np.array([0.0, 0.4 * place, 0.0])).astype(np.float32),
                np.tile(turn @ (-1.0, 0, 0), (4, 1)).astype(np.float32),
                np.zeros((4, 2), np.float32),
                np.array([[0, 1, 2], [0, 2, 3]], np.int32),
                0,
                len(world.objects) + place,
            )
        )
        objects.append(Object(f"{FAMILY} {number}", CLASS_NAME))
    return replace(
        world,
        parts=tuple(parts),
        objects=(*world.objects, *objects),
        class_names=(*world.class_names, CLASS_NAME),
    )


def frames_of(world, distances_m, *, noise_dn: float = 1.0, hidden: bool = False) -> FrameBatch:
    """One frame from each distance, looking along +x."""
    poses = np.tile(np.eye(4), (len(distances_m), 1, 1))
    poses[:, 0, 3] = -np.asarray(distances_m)
    times_s = np.arange(len(distances_m), dtype=float)
    episode = replace(
        sample_episode(len(poses)),
        world=world,
        trajectory=Trajectory(times_s, poses),
        time_s=times_s,
        walk=np.zeros(len(poses), np.int32),
    )
    seen = poses @ CAMERA.agent_from_camera
    rng = np.random.default_rng(0)
    images = []
    for pose in seen:
        image = np.full((CAMERA.height_px, CAMERA.width_px), 120, np.uint8)
        for tag, part in zip(tags_of(world), world.parts, strict=True):
            image = _drawn(image, tag.number, part.vertices_m[[3, 2, 1, 0]], pose)
        noisy = image + noise_dn * rng.standard_normal(image.shape)
        images.append(np.clip(np.rint(noisy), 0, 255).astype(np.uint8)[..., None])
    size = (len(poses), CAMERA.height_px, CAMERA.width_px)
    depth = np.full(size, 0.3 if hidden else np.inf, np.float32)
    view = View(CAMERA, seen, np.zeros((*size, 3), np.float32), depth, np.zeros(size, np.int32))
    return FrameBatch(Capture(episode, (view,)), (np.stack(images),))


def _drawn(image: np.ndarray, number: int, corners_m: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """The image with a sheet in it, at four times its size and averaged."""
    paper = cv2.aruco.generateImageMarker(dictionary_of(FAMILY), number, cells_of(FAMILY) * 16)
    paper = np.pad(paper, 16, constant_values=255)
    end, fine = len(paper) - 0.5, 4
    ends = np.array([[-0.5, -0.5], [end, -0.5], [end, end], [-0.5, end]], np.float32)
    corners_px = (project(corners_m, CAMERA, pose)[0] + 0.5) * fine - 0.5
    warp = cv2.getPerspectiveTransform(ends, corners_px.astype(np.float32))
    shape = (CAMERA.width_px * fine, CAMERA.height_px * fine)
    drawn = np.repeat(np.repeat(image, fine, 0), fine, 1)
    cv2.warpPerspective(paper, warp, shape, drawn, cv2.INTER_LINEAR, cv2.BORDER_TRANSPARENT)
    return cv2.resize(drawn, image.shape[::-1], interpolation=cv2.INTER_AREA)


def score(frames: FrameBatch, **config):
    scorer = Fiducials(Fiducials.Config(**config)).begin(state=None)
    scorer.update(frames)
    return scorer.scores()


class TestFiducials(TaskConformance):
    component = Fiducials

    def frames(self) -> FrameBatch:
        return frames_of(world_with(), [0.5, 0.8, 1.0, 1.5])


@pytest.mark.parametrize("turn_deg", [0, 30])
def test_near_markers_are_read_and_placed(turn_deg):
    scores = score(frames_of(world_with((3, 12), turn_deg), [0.8, 1.0]))
    assert scores["read"] == 1
    assert scores["position_error"] < 0.02


def test_far_markers_are_not_read_and_the_range_lies_between():
    scores = score(frames_of(world_with(), [0.6, 0.8, 1.0, 1.2, 12.0, 14.0, 16.0]))
    assert scores["read"] == pytest.approx(4 / 7)
    assert 1.2 < scores["range_m"] < 12


def test_noise_costs_range():
    distances = np.geomspace(0.6, 8, 12)
    quiet, loud = (score(frames_of(world_with(), distances, noise_dn=noise)) for noise in (1, 60))
    assert quiet["range_m"] > 1.2 * loud["range_m"]
    assert quiet["position"] > loud["position"]


def test_what_is_hidden_turned_away_or_outside_does_not_count():
    assert score(frames_of(world_with(), [1.0], hidden=True)) == {}
    (tag,) = tags_of(world_with())
    depth = np.full((480, 640), np.inf, np.float32)
    before = agent_from_camera((-1.0, 0, 0), 0)
    assert in_sight(tag, CAMERA, before, depth) == pytest.approx(1.0, abs=1e-6)
    assert in_sight(tag, CAMERA, agent_from_camera((1.0, 0, 0), 0, yaw_deg=180), depth) is None
    assert in_sight(tag, CAMERA, agent_from_camera((-1.0, 0, 0), 0, yaw_deg=45), depth) is None


def test_a_world_without_markers_is_refused_with_what_to_do():
    capture = sample_capture()
    image = np.zeros((*capture.views[0].depth_m.shape, 1), np.uint8)
    with pytest.raises(UserError, match=r"no marker hangs[\s\S]*transform.place-tags"):
        score(FrameBatch(capture, (image,) * len(capture.views)))


@given(half_m=st.floats(1.5, 6.0), seed=st.integers(0, 50))
def test_the_range_is_that_which_made_the_readings(half_m, seed):
    rng = np.random.default_rng(seed)
    distances = rng.uniform(0.7, 10, 400)
    read = rng.uniform(size=400) < 1 / (1 + (distances / half_m) ** 6)
    found = range_m([Sighting(d, bool(r)) for d, r in zip(distances, read, strict=True)])
    assert found == pytest.approx(half_m, rel=0.15)


def test_what_is_not_read_counts_as_badly_placed():
    scores = scores_of([Sighting(1.0, True, 0.001), Sighting(4.0, False)])
    assert scores["position"] == pytest.approx(0.5)
    assert scores["position_error"] == pytest.approx(0.001)
    assert scores_of([]) == {}


def test_markers_out_of_view_are_missed_where_the_field_of_work_is_stated():
    world = world_with((3, 12))  # the second .4 m to the left of the first
    near, far = frames_of(world, [0.8]), frames_of(world, [0.3])
    assert score(near, within_m=2)["read"] == score(near)["read"] == 1
    assert score(far)["read"] == 1
    assert score(far, within_m=2)["read"] == 0.5
    assert score(far, within_m=2)["position"] < 0.6 * score(far)["position"] + 1e-9
    assert score(frames_of(world, [0.8], hidden=True), within_m=2)["read"] == 0
    assert score(near, within_m=0.1) == {}


def test_what_hangs_behind_or_looks_away_is_not_in_the_field_of_work():
    (tag,) = tags_of(world_with())
    ahead, behind = agent_at(-1.0), agent_at(-1.0, yaw_deg=180)
    assert in_field_of_work(tag, ahead[:3, 3], ahead, 2, 90)
    assert not in_field_of_work(tag, ahead[:3, 3], ahead, 0.5, 90)
    assert not in_field_of_work(tag, ahead[:3, 3], behind, 2, 90)
    aside = agent_at(-1.0) @ agent_at(0.0, yaw_deg=60)
    assert in_field_of_work(tag, ahead[:3, 3], aside, 2, 61)
    assert not in_field_of_work(tag, ahead[:3, 3], aside, 2, 59)
    assert not in_field_of_work(tag, agent_at(1.0)[:3, 3], agent_at(1.0, yaw_deg=180), 2, 90)  # its back


def agent_at(x_m: float, *, yaw_deg: float = 0) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("z", yaw_deg, degrees=True).as_matrix()
    pose[0, 3] = x_m
    return pose


def test_a_number_that_is_read_elsewhere_is_not_the_marker():
    frames = frames_of(world_with(), [0.8])
    moved = np.roll(frames.images[0], 120, axis=2)
    assert score(replace(frames, images=(moved,)))["read"] == 0


def test_nothing_read_has_no_range():
    frames = frames_of(world_with(), [0.8, 1.0])
    blank = replace(frames, images=(np.full_like(frames.images[0], 90),))
    assert score(blank) == {"read": 0, "range_m": 0, "position": 0}
