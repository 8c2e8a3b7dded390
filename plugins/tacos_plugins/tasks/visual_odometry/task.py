"""The motion of a camera, estimated from its images and held against the true one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, FrameBatch, Rig, Scores, ScoreScale, Settings, State, setting
from tacos_framework.camera import invert_pose, rays_of_pixels
from tacos_plugins.tasks.chosen_camera import camera_index
from tacos_plugins.tasks.consensus import seeded
from tacos_plugins.tasks.visual_odometry.errors import MotionError, motion_error, scores_of
from tacos_plugins.tasks.visual_odometry.following import Follower, Marked, Method, follower
from tacos_plugins.tasks.visual_odometry.two_views import motion_between
from tacos_plugins.tasks.visual_odometry.with_depth import motion_of_points, triangulated

TIME_TOLERANCE_S = 1e-6
"""Frames at a stated distance in time are so far apart but for rounding [s]."""

WHERE = "task.visual-odometry"

BEYOND_CHANCE = 4.0
"""Standard errors by which more matches must agree than in an image that shows something else [1]."""


class VisualOdometry:
    """Motion of the camera from frame to frame, estimated from its images, against the known poses.

    Points are followed from each frame of a walk to the next. One camera gives a rotation and a direction by
    the essential matrix of most of them; a stereo pair triangulates its points and gives the length too.
    Motions are chained over windows of `window` frames; with one camera each step then has its true length.

    ``rotation``
        Mean grade of the rotation error: 1 up to 0.001 deg, 0 from 10 deg on, and a quarter less for ten
        times the error; higher is better. A motion that is lost counts 0, and no outlier more.
    ``direction``
        The same of the direction moved into, from 0.03 to 30 deg; a third less for ten times the error. Only
        where the camera moved by `least_step_m`.
    ``position``
        With `stereo`, the same of the error in position over the way, from 0.001 to 1.
    ``tracked``
        Share of the windows over which a motion is found in every step.
    ``within_1_deg``
        Share of the windows whose rotation is right within 1 deg.
    ``rotation_error_deg``, ``direction_error_deg``, ``drift``
        Medians of the errors; drift is in metres per metre. What is lost counts as 180 deg, or a drift of 1.

    Corners of noise are followed too, and some of their motions agree. So each motion is looked for a second
    time in the next frame upside down, and is lost unless significantly more matches agree in the true one.

    An episode without a pair of frames of one walk has no scores.

    Sources: Scaramuzza and Fraundorfer 2011, "Visual odometry"; Shi and Tomasi 1994, "Good features to
    track"; Nister 2004, "An efficient solution to the five-point relative pose problem".
    """

    class Config(Settings):
        camera: str | None = setting(
            None, help="Name of the camera, or of the left one; by default the first."
        )
        stereo: bool = setting(False, help="Use both cameras of a pair, which give lengths.")
        right: str | None = setting(None, help="Name of the right camera; by default the second.")
        features: Method = setting(
            "klt", help="Points followed: corners by their patches (klt), or ORB features by descriptors."
        )
        points: int = setting(400, help="Points of a frame, at most.", ge=8, le=10_000)
        apart: float = setting(
            0.015, help="Least distance between corners, over the width of the image.", gt=0, le=0.2
        )
        threshold_px: float = setting(
            1.0, help="Distance from its epipolar line at which a match is still an inlier.", unit="px", gt=0
        )
        confidence: float = setting(
            0.999, help="Probability that RANSAC meets a sample free of outliers.", gt=0, lt=1
        )
        seed: int = setting(0, help="Seed of RANSAC, set anew for each pair.", ge=0, le=2**31 - 1)
        least_inliers: int = setting(
            15, help="Matches that must agree with a motion; with fewer it is lost.", ge=8
        )
        window: int = setting(2, help="Frames over which motions are chained; 2 are single pairs.", ge=2)
        pair_within_s: float | None = setting(
            None,
            help="Follow only frames at most this far apart in time; by default all that follow one another.",
            unit="s",
            gt=0,
        )
        least_step_m: float = setting(
            0.02, help="Way from which on its direction and length are scored.", unit="m", gt=0
        )

    wants: ClassVar[Literal["grey"]] = "grey"
    needs: ClassVar[tuple[str, ...]] = ("poses",)
    scores: ClassVar[tuple[str, ...]] = (
        "rotation",
        "direction",
        "position",
        "tracked",
        "within_1_deg",
        "rotation_error_deg",
        "direction_error_deg",
        "drift",
    )
    score_scales: ClassVar[Mapping[str, ScoreScale]] = dict.fromkeys(scores[:5], "share")
    margins: ClassVar[Mapping[str, float]] = {
        "rotation": 0.02,
        "direction": 0.02,
        "position": 0.02,
        "tracked": 0.02,
        "within_1_deg": 0.02,
        "rotation_error_deg": 0.02,
        "direction_error_deg": 0.2,
        "drift": 0.002,
    }
    """Grades: errors that differ by a fifth. Shares: one window in fifty."""
    lower_is_better: ClassVar[frozenset[str]] = frozenset(scores[5:])
    score_meanings: ClassVar[Mapping[str, str]] = {
        "rotation": "how right the estimated turn is, 1 at 0.001 deg and 0 at 10 deg or lost",
        "direction": "how right the estimated direction of motion is, 1 at 0.03 deg and 0 at 30 deg or lost",
        "position": "how right the estimated step is, 1 at 0.1 % of the way and 0 at all of it or lost",
        "tracked": "share of windows over which a motion is found",
        "within_1_deg": "share of windows whose turn is right within 1 deg",
        "rotation_error_deg": "median error of the turn",
        "direction_error_deg": "median error of the direction of motion",
        "drift": "median error in position over the way [m/m]",
    }

    def __init__(self, config: Config) -> None:
        self.config = config

    def lacks(self, rig: Rig) -> str | None:
        """Why the cameras of a rig cannot be scored, in a sentence; None when they can."""
        if self.config.stereo and len(rig.cameras) < 2:
            return f"stereo is true, and the rig has one camera: {rig.cameras[0].name} (see rig.stereo)"
        return None

    def begin(self, *, state: State | None = None) -> OdometryScorer:
        return OdometryScorer(self.config)


Placed = tuple[NDArray[np.intp], NDArray[np.float64]]
"""(N,) indices of points of an image, and where they are in its camera's frame, (N, 3) [m]."""


@dataclass(frozen=True, eq=False)
class Moment:
    """A frame: its walk, time [s], true pose (4, 4), the images of the camera, or of both, and the first of
    them upside down."""

    walk: int
    time_s: float
    world_from_camera: NDArray[np.float64]
    images: tuple[Marked, ...]
    upside_down: Marked


class OdometryScorer:
    """Scores one episode; keeps the last frame, so batches may cut anywhere."""

    def __init__(self, config: VisualOdometry.Config) -> None:
        self._config = config
        self._last: Moment | None = None
        self._steps: list[tuple[NDArray[np.float64] | None, NDArray[np.float64]]] = []
        self._errors: list[MotionError] = []

    def update(self, frames: FrameBatch) -> None:
        config = self._config
        views = frames.capture.views
        chosen = [camera_index(frames, config.camera, where=WHERE)]
        if config.stereo:
            chosen.append(1 if config.right is None else camera_index(frames, config.right, where=WHERE))
        cameras = [views[index].camera for index in chosen]
        points = follower(config.features, points=config.points, apart_px=config.apart * cameras[0].width_px)
        for at in range(len(frames.episode)):
            grey = [np.asarray(frames.images[index][at, ..., 0], np.uint8) for index in chosen]
            moment = Moment(
                int(frames.episode.walk[at]),
                float(frames.episode.time_s[at]),
                views[chosen[0]].world_from_camera[at],
                tuple(points.marked(image) for image in grey),
                points.upside_down(grey[0]),
            )
            self._take(moment, points, cameras)
            self._last = moment

    def scores(self) -> Scores:
        """Means and medians over all windows so far."""
        return scores_of(self._errors)

    def _take(self, moment: Moment, points: Follower, cameras: list[Camera]) -> None:
        config, last = self._config, self._last
        limit_s = np.inf if config.pair_within_s is None else config.pair_within_s + TIME_TOLERANCE_S
        if last is None or last.walk != moment.walk or moment.time_s - last.time_s > limit_s:
            self._steps.clear()
            return
        truth = invert_pose(moment.world_from_camera) @ last.world_from_camera
        self._steps.append((self._estimate(last, moment, points, cameras, truth), truth))
        if len(self._steps) == config.window - 1:
            found = [estimate for estimate, _ in self._steps]
            lost = any(estimate is None for estimate in found)
            self._errors.append(
                motion_error(
                    None if lost else _chained(found),
                    _chained([true for _, true in self._steps]),
                    least_step_m=config.least_step_m,
                    with_length=config.stereo,
                )
            )
            del self._steps[0]

    def _estimate(
        self,
        first: Moment,
        second: Moment,
        points: Follower,
        cameras: list[Camera],
        truth: NDArray[np.float64],
    ) -> NDArray[np.float64] | None:
        """(4, 4) second_from_first [m]; with one camera its length is that of the truth."""
        config = self._config
        placed = self._placed(first, points, cameras) if config.stereo else None
        found = self._motion(first, second.images[0], points, cameras[0], placed)
        if found is None or found[1] < config.least_inliers:
            return None
        by_chance = self._motion(first, second.upside_down, points, cameras[0], placed)
        if not is_beyond_chance(found[1], 0 if by_chance is None else by_chance[1]):
            return None
        motion = found[0]
        if not config.stereo:
            motion[:3, 3] *= np.linalg.norm(truth[:3, 3])
        return motion

    def _motion(
        self, first: Moment, second: Marked, points: Follower, camera: Camera, placed: Placed | None
    ) -> tuple[NDArray[np.float64], int] | None:
        """The motion that most matches agree with, and how many."""
        config = self._config
        consensus = seeded(threshold_px=config.threshold_px, confidence=config.confidence, seed=config.seed)
        index, seen_px = points.matches(first.images[0], second)
        after = rays_of_pixels(seen_px, camera)
        if placed is None:
            before = rays_of_pixels(first.images[0].points_px[index], camera)
            found = motion_between(before, after, camera.focal_length_px, consensus)
        else:
            _, seen, of_placed = np.intersect1d(index, placed[0], return_indices=True)
            found = motion_of_points(placed[1][of_placed], after[seen], camera.focal_length_px, consensus)
        return None if found is None else (found[0], int(np.count_nonzero(found[1])))

    def _placed(self, first: Moment, points: Follower, cameras: list[Camera]) -> Placed:
        """Points of the first image that both cameras see."""
        left, right = cameras
        index, right_px = points.matches(*first.images)
        places, valid = triangulated(
            rays_of_pixels(first.images[0].points_px[index], left),
            rays_of_pixels(right_px, right),
            invert_pose(left.agent_from_camera) @ right.agent_from_camera,
            self._config.threshold_px / left.focal_length_px,
        )
        return index[valid], places[valid]


def is_beyond_chance(agreeing: int, by_chance: int) -> bool:
    """Whether one of two Poisson counts is larger by more than `BEYOND_CHANCE` standard errors.

    >>> [is_beyond_chance(*counts) for counts in ((127, 125), (300, 20), (16, 0))]
    [False, True, False]
    """
    return agreeing - by_chance > BEYOND_CHANCE * (agreeing + by_chance) ** 0.5


def _chained(steps: list[Any]) -> NDArray[np.float64]:
    """(4, 4) last_from_first of steps, each second_from_first."""
    return reduce(lambda done, step: step @ done, steps)
