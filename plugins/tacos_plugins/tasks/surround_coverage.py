"""View of a rig of any number of cameras around the agent."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import field_validator

from tacos_framework import Camera, FrameBatch, Scores, ScoreScale, Settings, State, View, setting
from tacos_framework.camera import pixel_rays, pixels_of_rays

_DIRECTIONS = 4000
"""Directions over the whole sphere: one for every ten square degrees, so that shares are good to 1 %."""

_PLACES = 16
"""Places along each edge of a zone."""

_STEP_RAD = 1e-4
"""Angle over which pixels to the degree are counted."""

Place = tuple[float, float, float]
Box = tuple[Place, Place]
"""The least and largest x (ahead), y (to the left) and z (up) in the agent's frame [m]."""


class SurroundCoverage:
    """View of the cameras of a rig together around the agent, and the things they see well.

    ``covered``
        Share of all directions within `elevation_deg` of the horizon that some camera has in view, with at
        least `least_px_per_deg` pixels to the degree there, in 0..1; higher is better. Geometry alone. With
        a `zone`, the share of its places instead.
    ``things_seen``
        Mean over the frames of the number of labelled things in sight, each counted by how well the camera
        sees it that sees it best: ``min(1, visible photosites / enough_pixels)``. Higher is better. A thing
        behind a wall, farther than `within_m` or outside the `zone` does not count.

    Visibility is that of the rendered ids: noise hides nothing. Pixels count as those of the camera itself,
    so that the simulation's binning changes nothing. Any number of cameras will do, and
    candidates may differ in it.
    """

    class Config(Settings):
        elevation_deg: float = setting(
            30.0, help="For covered, how far above and below the horizon counts.", unit="deg", gt=0, le=90
        )
        least_px_per_deg: float = setting(
            0.0,
            help="For covered, photosites to the degree that a direction must be seen with.",
            unit="px/deg",
            ge=0,
        )
        within_m: float = setting(
            6.0, help="For things_seen, the farthest pixels that count, by depth.", unit="m", gt=0
        )
        enough_pixels: int = setting(
            2000, help="For things_seen, photosites with which a thing counts in full.", unit="px", ge=1
        )
        zone: Box | None = setting(
            None,
            help="The field of work, as two corners (ahead, left, up) from the agent's eye: what must be in "
            "view; by default all around.",
            unit="m",
        )

        @field_validator("zone")
        @classmethod
        def _from_least_to_most(cls, zone: Box | None) -> Box | None:
            if zone is not None and not all(low < high for low, high in zip(*zone, strict=True)):
                raise ValueError("give the corner of the least ahead, left and up first")
            return zone

    needs: ClassVar[tuple[str, ...]] = ("depth", "objects")
    scores: ClassVar[tuple[str, ...]] = ("covered", "things_seen")
    score_scales: ClassVar[Mapping[str, ScoreScale]] = {"covered": "share", "things_seen": "count"}
    margins: ClassVar[Mapping[str, float]] = {"covered": 0.01, "things_seen": 0.1}
    """A strip of 3.6 deg of a whole turn; a tenth of a thing."""
    score_meanings: ClassVar[Mapping[str, str]] = {
        "covered": "share of the directions around that some camera has in view",
        "things_seen": "labelled things in sight, counted by how well they are seen",
    }

    def __init__(self, config: Config) -> None:
        self.config = config

    def begin(self, *, state: State | None = None) -> SurroundScorer:
        return SurroundScorer(self.config)


class SurroundScorer:
    """Scores one episode; keeps a number for each frame."""

    def __init__(self, config: SurroundCoverage.Config) -> None:
        self._config = config
        self._seen: list[float] = []
        self._covered: float | None = None

    def update(self, frames: FrameBatch) -> None:
        views, config = frames.capture.views, self._config
        if self._covered is None:
            cameras = [view.camera for view in views]
            self._covered = covered_share(
                cameras, config.elevation_deg, config.least_px_per_deg, zone=config.zone
            )
        count = len(frames.episode.world.objects)
        for frame in range(len(frames.episode)):
            best = np.max([_photosites(view, frame, count, config) for view in views], axis=0)
            self._seen.append(float(np.minimum(1.0, best / config.enough_pixels).sum()))

    def scores(self) -> Scores:
        """Means over the frames so far."""
        if self._covered is None:
            return {}
        return {"covered": self._covered, "things_seen": sum(self._seen) / len(self._seen)}


def covered_share(
    cameras: Sequence[Camera], elevation_deg: float, least_px_per_deg: float, *, zone: Box | None = None
) -> float:
    """Share of the directions about the horizon, or of a zone, that some camera has in view, finely enough.

    - `cameras`: all of a rig; where they sit matters to a zone alone.
    - `elevation_deg`: how far above and below the horizon counts [deg].
    - `least_px_per_deg`: photosites to the degree that a direction must be seen with, in whichever way it has
      fewest [px/deg].

    >>> from tacos_framework.testing.samples import sample_rig
    >>> share = covered_share(sample_rig().cameras, elevation_deg=20, least_px_per_deg=0)  # 90 degrees wide
    >>> abs(share - 90 / 360) < 0.01
    True
    """
    places = directions_about_horizon(elevation_deg) if zone is None else places_in(zone)
    seen = np.zeros(len(places), np.bool_)
    for camera in cameras:
        eye_m = 0.0 if zone is None else camera.agent_from_camera[:3, 3]
        rays = (places - eye_m) @ camera.agent_from_camera[:3, :3]
        pixels = pixels_of_rays(rays, camera)
        middle = (np.array([camera.width_px, camera.height_px]) - 1) / 2
        inside = np.all(np.abs(pixels - middle) <= middle + 0.5, axis=1)
        if least_px_per_deg:
            inside &= px_per_deg(rays, camera) >= least_px_per_deg
        seen |= inside
    return float(seen.mean())


def px_per_deg(rays: NDArray[np.float64], camera: Camera) -> NDArray[np.float64]:
    """Photosites to the degree about each of (N, 3) directions, in whichever way there are fewest.

    >>> camera = Camera("c", 640, 480, pixel_um=3.0, focal_length_mm=1.2)  # f / cos(a) across, more along
    >>> px_per_deg(np.array([[0.0, 0.0, 1.0], [3.0, 0.0, 4.0]]), camera).round(2).tolist()
    [6.98, 8.73]
    """
    ahead = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    across = np.cross(ahead, (0.0, 0.0, 1.0)) + np.array([1e-12, 0.0, 0.0])  # some way on the axis, too
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    at = pixels_of_rays(ahead, camera)
    steps = [
        pixels_of_rays(ahead + _STEP_RAD * way, camera) - at for way in (across, np.cross(ahead, across))
    ]
    fewest = np.min([np.linalg.norm(step, axis=1) for step in steps], axis=0)
    return np.asarray(fewest * camera.simulated_binning / math.degrees(_STEP_RAD))


def places_in(zone: Box) -> NDArray[np.float64]:
    """(N, 3) places spread evenly over a box [m]."""
    low, high = np.array(zone)
    steps = (np.arange(_PLACES) + 0.5) / _PLACES
    grid = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    return np.asarray(low + grid * (high - low))


def directions_about_horizon(elevation_deg: float) -> NDArray[np.float64]:
    """(N, 3) unit vectors of the agent's frame, spread evenly up to an elevation: a Fibonacci lattice."""
    count = _DIRECTIONS
    up = 1 - 2 * (np.arange(count) + 0.5) / count
    azimuth = np.arange(count) * math.pi * (3 - math.sqrt(5))
    level = np.sqrt(1 - up**2)
    every = np.stack([level * np.cos(azimuth), level * np.sin(azimuth), up], axis=1)
    return np.asarray(every[np.abs(up) <= math.sin(math.radians(elevation_deg))])


def _photosites(view: View, frame: int, objects: int, config: SurroundCoverage.Config) -> NDArray[np.float64]:
    """(objects,) how many photosites of a view show each thing; the background is none."""
    depth_m = view.depth_m[frame]
    near = depth_m <= config.within_m
    if config.zone is not None:
        points_m = pixel_rays(view.camera)[near] * depth_m[near][:, None]
        pose = view.camera.agent_from_camera
        places_m = points_m @ pose[:3, :3].T + pose[:3, 3]
        near[near] = np.all((places_m >= config.zone[0]) & (places_m <= config.zone[1]), axis=1)
    shown = view.object_id[frame][near]
    counts = np.bincount(shown, minlength=objects).astype(np.float64) * view.camera.simulated_binning**2
    counts[0] = 0.0
    return counts
