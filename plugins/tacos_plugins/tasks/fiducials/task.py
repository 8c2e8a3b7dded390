"""Fiducial markers: how far away a camera reads them, and where it believes them to be."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal

import cv2
import numpy as np

from tacos_framework import Fault, FrameBatch, Scores, ScoreScale, Settings, State, UserError, setting
from tacos_plugins.tasks.chosen_camera import camera_index
from tacos_plugins.tasks.fiducials.families import dictionary_of, tags_of
from tacos_plugins.tasks.fiducials.sightings import Sighting, detected, in_sight, off_m, scores_of

WHERE = "task.fiducials"


class Fiducials:
    """Reading of markers on the walls (`transform.place-tags` hangs them).

    A marker counts where it is whole in the image, faces the camera and is not hidden. It is read where
    OpenCV's detector finds its number; its place follows from its corners.

    ``read``
        Share of the markers in sight that are read.
    ``range_m``
        Distance at which half of them are read, most likely by those in sight: at least half of the nearest
        and at most twice the farthest.
    ``position``
        Mean grade of the error in position over distance: 1 up to 0.001, 0 from 1 on, and a third less for
        ten times the error. What is not read counts 0.
    ``position_error``
        Median of that error over the markers that are read; lower is better.

    An episode in which no marker comes in sight has no scores; a world without markers is refused.

    Sources: Olson 2011, "AprilTag"; Garrido-Jurado et al. 2014 (ArUco), whose detector OpenCV has.
    """

    class Config(Settings):
        camera: str | None = setting(None, help="Name of the camera that reads; by default the first.")
        refine: bool = setting(True, help="Whether corners are found to a part of a pixel.")

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
        "read": "share of the markers in sight that are read",
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
            if not seen:
                continue
            grey = np.asarray(frames.images[index][at, ..., 0], np.uint8)
            found = {family: detected(detector, grey) for family, detector in detectors.items()}
            for tag, distance_m in seen.items():
                corners_px = found[tag.family].get(tag.number)
                read = corners_px is not None
                off = None if corners_px is None else off_m(tag, corners_px, view.camera, pose)
                self._sightings.append(Sighting(distance_m, read, off))

    def scores(self) -> Scores:
        """The scores of all markers in sight so far."""
        return scores_of(self._sightings)
