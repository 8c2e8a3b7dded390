"""Obstacle visibility: which obstacle counts, and when it counts as seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.testing.samples import sample_episode, sample_rig
from tacos_framework.values import Capture, Crossing, FrameBatch, View
from tacos_plugins.tasks.obstacle_visibility import ObstacleVisibility

OBSTACLE = 1
HEIGHT, WIDTH = 6, 8


def frames_of(pixels, *, crossings, walk=None, depth_m=2.0, binning=1.0, time_s=None) -> FrameBatch:
    """One frame a second; in frame i the obstacle covers ``pixels[i]`` pixels."""
    count = len(pixels)
    camera = replace(sample_rig(width_px=WIDTH, height_px=HEIGHT).cameras[0], binning=binning)
    ids = np.zeros((count, HEIGHT * WIDTH), np.int32)
    for frame, covered in enumerate(pixels):
        ids[frame, :covered] = OBSTACLE
    depth = np.broadcast_to(np.reshape(depth_m, (-1, 1, 1)), (count, HEIGHT, WIDTH)).astype(np.float32)
    view = View(
        camera,
        np.tile(np.eye(4), (count, 1, 1)),
        np.ones((count, HEIGHT, WIDTH, 3), np.float32),
        depth,
        ids.reshape(count, HEIGHT, WIDTH),
    )
    episode = replace(
        sample_episode(max(count, 1)),
        time_s=np.arange(count, dtype=float) if time_s is None else np.array(time_s, float),
        walk=np.zeros(count, np.int32) if walk is None else np.array(walk, np.int32),
        crossings=tuple(c if isinstance(c, Crossing) else Crossing(OBSTACLE, c) for c in crossings),
    )
    return FrameBatch(Capture(episode, (view,)), (np.zeros((count, HEIGHT, WIDTH, 3), np.uint8),))


def score(frames: FrameBatch, name: str, **config) -> float | None:
    scorer = ObstacleVisibility(ObstacleVisibility.Config(**config)).begin(state=None)
    scorer.update(frames)
    return scorer.scores().get(name)


def seen_ratio(frames: FrameBatch, **config) -> float | None:
    return score(frames, "seen_ratio", **config)


def seen_early(frames: FrameBatch, **config) -> float | None:
    return score(frames, "seen_early", **{"enough_pixels": 10, **config})


def test_seen_before_the_step():
    assert seen_ratio(frames_of([0, 3, 0, 0], crossings=[2.5])) == 1.0


def test_seen_only_after_the_step():
    assert seen_ratio(frames_of([0, 0, 0, 3], crossings=[2.5])) == 0.0


def test_seen_at_the_moment_of_the_step_is_too_late():
    assert seen_ratio(frames_of([0, 0, 3, 0], crossings=[2.0])) == 0.0


def test_each_step_on_the_same_obstacle_counts():
    assert seen_ratio(frames_of([0, 0, 3, 0], crossings=[1.5, 2.5])) == 0.5


def test_steps_outside_the_time_of_the_frames_do_not_count():
    assert seen_ratio(frames_of([3, 3, 3], crossings=[-0.5, 2.5])) is None
    assert seen_ratio(frames_of([3, 3, 3], crossings=[-0.5, 1.5, 2.5])) == 1.0


def test_what_an_earlier_walk_saw_does_not_count():
    assert seen_ratio(frames_of([3, 3, 0, 0], walk=[0, 0, 1, 1], crossings=[2.5])) == 0.0


def test_a_step_between_two_walks_belongs_to_neither():
    assert seen_ratio(frames_of([3, 3, 3, 3], walk=[0, 0, 1, 1], crossings=[1.5])) is None


@pytest.mark.parametrize(("min_pixels", "ratio"), [(4, 1.0), (5, 0.0)])
def test_enough_pixels_must_show_in_one_frame(min_pixels, ratio):
    assert seen_ratio(frames_of([2, 4, 1, 0], crossings=[2.5]), min_pixels=min_pixels) == ratio


@pytest.mark.parametrize(("binning", "ratio"), [(2.0, 1.0), (1.9, 0.0)])
def test_pixels_count_as_the_photosites_they_average(binning, ratio):
    assert seen_ratio(frames_of([3, 0], crossings=[0.5], binning=binning), min_pixels=12) == ratio


@pytest.mark.parametrize(("before_s", "ratio"), [(2.5, 1.0), (2.4, 0.0)])
def test_a_glimpse_long_ago_may_be_ruled_out(before_s, ratio):
    assert seen_ratio(frames_of([3, 0, 0, 0], crossings=[2.5]), before_s=before_s) == ratio


@pytest.mark.parametrize(("within_m", "ratio"), [(5.0, 1.0), (4.9, 0.0)])
def test_a_glimpse_from_afar_may_be_ruled_out(within_m, ratio):
    assert seen_ratio(frames_of([3, 0], crossings=[0.5], depth_m=5.0), within_m=within_m) == ratio


def test_without_a_step_there_is_no_score():
    assert seen_ratio(frames_of([3, 3], crossings=[])) is None


def test_any_camera_of_the_rig_may_see_it():
    frames = frames_of([0, 0, 0], crossings=[1.5])
    blind = frames.capture.views[0]
    seeing = frames_of([3, 0, 0], crossings=[1.5]).capture.views[0]
    seeing = replace(seeing, camera=replace(seeing.camera, name="right"))
    both = FrameBatch(Capture(frames.episode, (blind, seeing)), frames.images * 2)
    assert seen_ratio(both) == 1.0


def test_a_step_is_judged_when_its_frames_come_in_several_batches():
    first = frames_of([0, 3], time_s=[0, 1], crossings=[2.5])
    second = frames_of([0, 0], time_s=[2, 3], crossings=[2.5])
    scorer = ObstacleVisibility(ObstacleVisibility.Config()).begin(state=None)
    scorer.update(first)
    assert scorer.scores() == {}
    scorer.update(second)
    assert scorer.scores() == {"seen_ratio": 1.0, "seen_early": 3 / 3000 / 2}


def test_a_step_that_names_its_walk_needs_no_frame_after_it():
    after = [Crossing(OBSTACLE, 5.0, walk=0)]
    assert seen_ratio(frames_of([0, 3], crossings=after)) == 1.0
    assert seen_ratio(frames_of([3, 3, 0, 0], walk=[1, 1, 0, 0], crossings=after)) == 0.0


def test_a_step_that_names_another_walk_does_not_count_though_frames_lie_around_it():
    assert seen_ratio(frames_of([3, 3], crossings=[Crossing(OBSTACLE, 0.5, walk=7)])) is None


def test_in_sight_is_the_mean_over_the_frames_shortly_before_the_step():
    # enough in one frame, half enough in the next, nothing in the last; the first lies beyond the horizon
    frames = frames_of([10, 10, 5, 0, 10], crossings=[3.5])
    assert seen_early(frames, horizon_s=2.5) == pytest.approx((1 + 0.5 + 0) / 3)


def test_more_than_enough_is_enough():
    assert seen_early(frames_of([48, 48], crossings=[0.5])) == 1.0


def test_binned_pixels_are_as_many_photosites_in_sight():
    binned, whole = frames_of([2, 0], crossings=[0.5], binning=2.0), frames_of([8, 0], crossings=[0.5])
    assert seen_early(binned) == seen_early(whole) == 0.8


def test_a_step_without_a_frame_shortly_before_it_says_nothing_of_how_early():
    frames = frames_of([3, 0, 0], time_s=[0, 10, 20], crossings=[15.0])
    assert seen_early(frames) is None
    assert seen_ratio(frames) == 1.0


@given(pixels=st.lists(st.integers(0, 30), min_size=2, max_size=8), data=st.data())
def test_more_pixels_in_any_frame_never_lower_a_score(pixels, data):
    frame = data.draw(st.integers(0, len(pixels) - 1))
    more = [*pixels[:frame], pixels[frame] + data.draw(st.integers(0, 18)), *pixels[frame + 1 :]]
    crossings = [len(pixels) - 1.5]
    for metric in (seen_ratio, seen_early):
        fewer = metric(frames_of(pixels, crossings=crossings))
        assert 0 <= fewer <= metric(frames_of(more, crossings=crossings)) <= 1


@given(first=st.integers(0, 7), pixels=st.integers(1, 48))
def test_the_earlier_an_obstacle_comes_into_sight_the_better(first, pixels):
    def coming_at(frame):
        return [0] * frame + [pixels] * (9 - frame)

    earlier, later = (
        seen_early(frames_of(coming_at(frame), crossings=[7.5]), horizon_s=10) for frame in (first, first + 1)
    )
    assert earlier > later
