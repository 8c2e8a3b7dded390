"""View of a rig of any number of cameras around the agent."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, FrameBatch, Scores, ScoreScale, Settings, State, View, setting

_DIRECTIONS = 4000
"""Directions over the whole sphere: one for every ten square degrees, so that shares are good to 1 %."""


class SurroundCoverage:
    """View of the cameras of a rig together around the agent, and the things they see well.

    ``covered``
        Share of all directions within `elevation_deg` of the horizon that some camera has in view, with at
        least `least_px_per_deg` pixels to the degree there, in 0..1; higher is better. Geometry alone.
    ``things_seen``
        Mean over the frames of the number of labelled things in sight, each counted by how well the camera
        sees it that sees it best: ``min(1, visible photosites / enough_pixels)``. Higher is better. A thing
        behind a wall, or farther than `within_m`, does not count.

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
            self._covered = covered_share(cameras, config.elevation_deg, config.least_px_per_deg)
        count = len(frames.episode.world.objects)
        for frame in range(len(frames.episode)):
            best = np.max([_photosites(view, frame, count, config.within_m) for view in views], axis=0)
            self._seen.append(float(np.minimum(1.0, best / config.enough_pixels).sum()))

    def scores(self) -> Scores:
        """Means over the frames so far."""
        if self._covered is None:
            return {}
        return {"covered": self._covered, "things_seen": sum(self._seen) / len(self._seen)}


def covered_share(cameras: Sequence[Camera], elevation_deg: float, least_px_per_deg: float) -> float:
    """Share of the directions about the horizon that some camera has in view, finely enough.

    - `cameras`: all of a rig; where they sit does not matter, only where they look.
    - `elevation_deg`: how far above and below the horizon counts [deg].
    - `least_px_per_deg`: photosites to the degree that a direction must be seen with. A pinhole image has ``f
      / cos(a)`` to the radian across the radius, at an angle a from its axis, and more along it [px/deg].

    Examples
    --------
    >>> from tacos_framework.testing.samples import sample_rig
    >>> share = covered_share(sample_rig().cameras, elevation_deg=20, least_px_per_deg=0)  # 90 degrees wide
    >>> abs(share - 90 / 360) < 0.01
    True
    """
    directions = directions_about_horizon(elevation_deg)
    seen = np.zeros(len(directions), np.bool_)
    for camera in cameras:
        right, down, ahead = (directions @ camera.agent_from_camera[:3, :3]).T
        focal_px, (centre_x, centre_y) = camera.focal_length_px, camera.centre_px
        with np.errstate(divide="ignore", invalid="ignore"):
            x = focal_px * right / ahead + centre_x
            y = focal_px * down / ahead + centre_y
            px_per_deg = math.radians(focal_px * camera.simulated_binning) / ahead
        inside = (np.abs(x + 0.5 - camera.width_px / 2) <= camera.width_px / 2) & (
            np.abs(y + 0.5 - camera.height_px / 2) <= camera.height_px / 2
        )
        seen |= (ahead > 0) & inside & (px_per_deg >= least_px_per_deg)
    return float(seen.mean())


def directions_about_horizon(elevation_deg: float) -> NDArray[np.float64]:
    """(N, 3) unit vectors of the agent's frame, spread evenly up to an elevation: a Fibonacci lattice."""
    count = _DIRECTIONS
    up = 1 - 2 * (np.arange(count) + 0.5) / count
    azimuth = np.arange(count) * math.pi * (3 - math.sqrt(5))
    level = np.sqrt(1 - up**2)
    every = np.stack([level * np.cos(azimuth), level * np.sin(azimuth), up], axis=1)
    return np.asarray(every[np.abs(up) <= math.sin(math.radians(elevation_deg))])


def _photosites(view: View, frame: int, objects: int, within_m: float) -> NDArray[np.float64]:
    """(objects,) how many photosites of a view show each thing; the background is none."""
    near = view.object_id[frame][view.depth_m[frame] <= within_m]
    counts = np.bincount(near, minlength=objects).astype(np.float64) * view.camera.simulated_binning**2
    counts[0] = 0.0
    return counts
