"""Fiducial markers: how far away a camera reads them, and where it believes them to be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar, Literal

import cv2
import numpy as np

from tacos_framework import (
    Camera,
    Fault,
    FrameBatch,
    Scores,
    ScoreScale,
    Settings,
    State,
    UserError,
    setting,
)
from tacos_framework.camera import invert_pose
from tacos_plugins.tasks.chosen_camera import camera_index
from tacos_plugins.tasks.fiducials.families import Tag, dictionary_of, tags_of
from tacos_plugins.tasks.fiducials.sightings import (
    Floats,
    Sighting,
    detected,
    in_field_of_work,
    in_sight,
    is_there,
    off_m,
    scores_of,
)

WHERE = "task.fiducials"


class Fiducials:
    """Reading of markers on the walls (`transform.place-tags` hangs them).

    A marker is in sight where it is whole in the image, faces the camera and is not hidden. It is read where
    OpenCV's detector finds its number about where it is; its place follows from its corners.

    Without `within_m` markers count that are in sight. With it all do that face the agent and hang no farther
    away, within `within_deg` of straight ahead: one that is out of view, or behind a wall, is missed.

    ``read``
        Share of these markers that are read.
    ``range_m``
        Distance at which half are read of those in sight, most likely: at least half of the nearest and at
        most twice the farthest; 0 where none is read.
    ``position``
        Mean grade of the error in position over distance: 1 up to 0.001, 0 from 1 on, and a third less for
        ten times the error. What is not read counts 0.
    ``position_error``
        Median of that error over the markers that are read; lower is better.

    An episode in which no marker counts has no scores; a world without markers is refused.

    Sources: Olson 2011, "AprilTag"; Garrido-Jurado et al. 2014 (ArUco), whose detector OpenCV has.
    """

    class Config(Settings):
        camera: str | None = setting(None, help="Name of the camera that reads; by default the first.")
        within_m: float | None = setting(
            None,
            help="The field of work: distance up to which markers ahead count, in view or not; by default "
            "those in sight count.",
            unit="m",
            gt=0,
        )
        within_deg: float = setting(
            90.0, help="For the field of work, the angle from straight ahead.", unit="deg", gt=0, le=180
        )
        refine: bool = setting(True, help="Refine corners to a fraction of a pixel.")

    wants: ClassVar[Literal["grey"]] = "grey"
    needs: ClassVar[tuple[str, ...]] = ("poses", "objects")
    scores: ClassVar[tuple[str, ...]] = ("read", "range_m", "position", "position_error")
    score_scales: ClassVar[Mapping[str, ScoreScale]] = {"read": "share", "position": "share"}
    margins: ClassVar[Mapping[str, float]] = {
        "read": 0.03,
        "range_m": 0.2,
        "position": 0.02,
        "position_error": 0.001,
    }
    """One marker in thirty; a hand's width; errors that differ by 15 %."""
    lower_is_better: ClassVar[frozenset[str]] = frozenset({"position_error"})
    score_meanings: ClassVar[Mapping[str, str]] = {
        "read": "share of the markers in sight, or within the stated distance ahead, that are read",
        "range_m": "distance at which half of the markers are read [m]",
        "position": "how right markers are placed, 1 at 0.1 % of the distance and 0 at all of it or not read",
        "position_error": "median error in position over distance, of markers that are read",
    }

    def __init__(self, config: Config) -> None:
        self.config = config

    def begin(self, *, state: State | None = None) -> FiducialsScorer:
        return FiducialsScorer(self.config)


class FiducialsScorer:
    """Scores one episode; frames stand for themselves, so batches may cut anywhere."""

    def __init__(self, config: Fiducials.Config) -> None:
        self._config = config
        self._sightings: list[Sighting] = []
        self._missed = 0

    def update(self, frames: FrameBatch) -> None:
        index = camera_index(frames, self._config.camera, where=WHERE)
        view = frames.capture.views[index]
        tags = list(tags_of(frames.episode.world))
        if not tags:
            what = "there is nothing to read: no marker hangs in this world"
            fix = "Put a node {use: transform.place-tags, in: {episode: world}} between scene and renderer."
            raise UserError(Fault(WHERE, what, "objects of the class tag", fix))
        parameters = cv2.aruco.DetectorParameters()
        if self._config.refine:
            parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        detectors = {
            family: cv2.aruco.ArucoDetector(dictionary_of(family), parameters)
            for family in dict.fromkeys(tag.family for tag in tags)
        }
        for at, pose in enumerate(view.world_from_camera):
            seen = {
                tag: distance_m
                for tag in tags
                if (distance_m := in_sight(tag, view.camera, pose, view.depth_m[at])) is not None
            }
            asked = self._asked(tags, pose, view.camera)
            self._missed += sum(tag not in seen for tag in asked)
            if not seen:
                continue
            grey = np.asarray(frames.images[index][at, ..., 0], np.uint8)
            found = {family: detected(detector, grey) for family, detector in detectors.items()}
            for tag, distance_m in seen.items():
                corners_px = found[tag.family].get(tag.number)
                in_field = self._config.within_m is None or tag in asked
                if corners_px is None or not is_there(tag, corners_px, view.camera, pose):
                    self._sightings.append(Sighting(distance_m, read=False, in_field=in_field))
                else:
                    off = off_m(tag, corners_px, view.camera, pose)
                    self._sightings.append(Sighting(distance_m, read=True, off_m=off, in_field=in_field))

    def scores(self) -> Scores:
        """The scores of all markers that counted so far."""
        return scores_of(self._sightings, missed=self._missed)

    def _asked(self, tags: Sequence[Tag], world_from_camera: Floats, camera: Camera) -> list[Tag]:
        """The markers of the field of work; none where it is not stated."""
        config = self._config
        if config.within_m is None:
            return []
        agent = world_from_camera @ invert_pose(camera.agent_from_camera)
        eye_m = world_from_camera[:3, 3]
        return [
            tag for tag in tags if in_field_of_work(tag, eye_m, agent, config.within_m, config.within_deg)
        ]
