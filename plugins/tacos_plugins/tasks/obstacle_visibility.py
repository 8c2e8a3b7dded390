"""Sight of obstacles before the agent steps on them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tacos_framework import Crossing, FrameBatch, Scores, ScoreScale, Settings, State, View, setting

VIEW = ("pitch_deg", "hfov_deg", "vfov_deg", "log2_width_px", "log2_height_px")
"""Dependences of the scores: view and pixels; light and noise hide no obstacle."""


class ObstacleVisibility:
    """Obstacles on the agent's path seen before they were stepped on: how many, how early, how well.

    An obstacle is seen when, in any frame of the same walk taken before the agent steps on it, enough of its
    pixels are visible in any camera of the rig. Visibility is that of the rendered ids, as in the paper;
    noise does not hide an obstacle. Pixels count as those of the camera itself, so that the simulation's
    binning changes nothing; those of a camera that bins by itself are fewer.

    ``seen_ratio``
        Seen / stepped on, in 0..1; higher is better. The paper's score.
    ``seen_early``
        Mean over the steps of how well the obstacle was in sight over the last `horizon_s` before the step:
        the mean over these frames of ``min(1, visible photosites / enough_pixels)``, in 0..1; higher is
        better. It grows with the time an obstacle is in sight and with the pixels on it, and so tells
        cameras apart that all see every obstacle at some time. A step without a frame in that time has none.

    A step that names its walk (`Crossing.walk`) belongs to that; others count in the walk whose frames lie
    around them, and outside the time the frames span not at all. An episode without any has no score.

    Source: the paper, Sec. 4.3, o_seen / o_total. Holst, "Electro-optical imaging system performance": P =
    (N/N50)^E / (1 + (N/N50)^E) with E = 2.7 + 0.7 N/N50 and N50 = 4 for recognition.

    What it takes to recognise a thing is counted in line pairs across its shorter side, of two pixels each:
    half of all observers recognise it with 4, and 98 % with 10 (Johnson's criterion, with the transfer
    function of the reference). A threshold two metres ahead looks seven times as wide as deep, so 20 pixels
    across are 20 x 140 in all, about the 3000 of `enough_pixels`. For compact things 400 are right.
    """

    class Config(Settings):
        min_pixels: int = setting(
            1, help="For seen_ratio, photosites an obstacle must cover to be seen.", unit="px", ge=1
        )
        before_s: float | None = setting(
            None,
            help="For seen_ratio, count only frames at most this long before the step; by default any.",
            unit="s",
            gt=0,
        )
        within_m: float | None = setting(
            None,
            help="For seen_ratio, count only pixels of at most this depth; by default any.",
            unit="m",
            gt=0,
        )
        horizon_s: float = setting(
            2.0,
            help="For seen_early, the time before the step in which an obstacle should be in sight.",
            unit="s",
            gt=0,
        )
        enough_pixels: int = setting(
            3000,
            help="For seen_early, photosites with which an obstacle is as good as sure to be recognised.",
            unit="px",
            ge=1,
        )

    needs: ClassVar[tuple[str, ...]] = ("objects",)
    scores: ClassVar[tuple[str, ...]] = ("seen_ratio", "seen_early")
    score_scales: ClassVar[Mapping[str, ScoreScale]] = {"seen_ratio": "share", "seen_early": "share"}
    margins: ClassVar[Mapping[str, float]] = {"seen_ratio": 0.02, "seen_early": 0.02}
    """One obstacle in fifty."""
    depends_on: ClassVar[Mapping[str, Sequence[str]]] = {"seen_ratio": VIEW, "seen_early": VIEW}
    score_meanings: ClassVar[Mapping[str, str]] = {
        "seen_ratio": "share of obstacles on the path that were seen in time",
        "seen_early": "how early, and over how many pixels, obstacles on the path were in sight, of 1",
    }

    def __init__(self, config: Config) -> None:
        self.config = config

    def begin(self, *, state: State | None = None) -> ObstacleScorer:
        return ObstacleScorer(self.config)


@dataclass(frozen=True)
class Sighting:
    time_s: float
    """Its time [s]."""
    photosites: Mapping[int, float]
    """Those each obstacle covers, in the camera that shows most of it."""
    near: Mapping[int, float]
    """The same within `within_m`."""


class ObstacleScorer:
    """Scores one episode; keeps the time of each frame and how much of each obstacle it shows."""

    def __init__(self, config: ObstacleVisibility.Config) -> None:
        self._config = config
        self._walks: dict[int, list[Sighting]] = {}
        self._crossings: tuple[Crossing, ...] = ()

    def update(self, frames: FrameBatch) -> None:
        episode = frames.episode
        self._crossings = episode.crossings
        obstacles = sorted({crossing.object_id for crossing in episode.crossings})
        for frame in range(len(episode)):
            photosites, near = _most_photosites(
                frames.capture.views, frame, obstacles, within_m=self._config.within_m
            )
            sighting = Sighting(float(episode.time_s[frame]), photosites, near)
            self._walks.setdefault(int(episode.walk[frame]), []).append(sighting)

    def scores(self) -> Scores:
        """Means over the obstacles stepped on so far."""
        steps = [
            (crossing, walk)
            for number, walk in self._walks.items()
            for crossing in self._crossings
            if _belongs(crossing, number, walk)
        ]
        shares: dict[str, list[float]] = {
            "seen_ratio": [float(self._in_time(*step)) for step in steps],
            "seen_early": [share for step in steps if (share := self._in_sight(*step)) is not None],
        }
        return {name: sum(values) / len(values) for name, values in shares.items() if values}

    def _in_time(self, crossing: Crossing, walk: Iterable[Sighting]) -> bool:
        """True if an obstacle was seen in its walk before the step, and lately enough."""
        limit_s = np.inf if self._config.before_s is None else self._config.before_s
        return any(
            sighting.near[crossing.object_id] >= self._config.min_pixels
            for sighting in _within(walk, crossing.time_s, limit_s)
        )

    def _in_sight(self, crossing: Crossing, walk: Iterable[Sighting]) -> float | None:
        """Degree to which an obstacle was in sight shortly before the step, in 0..1; None where no frame
        says.
        """
        shares = [
            min(1.0, sighting.photosites[crossing.object_id] / self._config.enough_pixels)
            for sighting in _within(walk, crossing.time_s, self._config.horizon_s)
        ]
        return sum(shares) / len(shares) if shares else None


def _most_photosites(
    views: Sequence[View], frame: int, obstacles: Sequence[int], *, within_m: float | None
) -> tuple[dict[int, float], dict[int, float]]:
    """Number of photosites each obstacle covers in the view that shows most of it: all, and those near."""
    most, most_near = dict.fromkeys(obstacles, 0.0), dict.fromkeys(obstacles, 0.0)
    if not obstacles:
        return most, most_near
    lowest, highest = min(obstacles), max(obstacles)
    for view in views:
        # A few pixels of millions: all else is done with those alone.
        ids = view.object_id[frame].ravel()
        shown = np.flatnonzero((ids >= lowest) & (ids <= highest))
        ids = ids[shown]
        near = ids if within_m is None else ids[view.depth_m[frame].ravel()[shown] <= within_m]
        for found, counted in ((ids, most), (near, most_near)):
            pixels = np.bincount(found - lowest, minlength=highest - lowest + 1)
            for obstacle in obstacles:
                photosites = float(pixels[obstacle - lowest] * view.camera.simulated_binning**2)
                counted[obstacle] = max(counted[obstacle], photosites)
    return most, most_near


def _belongs(crossing: Crossing, number: int, walk: Sequence[Sighting]) -> bool:
    """True if a step was taken on a walk."""
    if crossing.walk is not None:
        return crossing.walk == number
    return walk[0].time_s <= crossing.time_s <= walk[-1].time_s


def _within(walk: Iterable[Sighting], step_s: float, limit_s: float) -> Iterator[Sighting]:
    """The sightings before a step, and at most so long before it [s]."""
    return (sighting for sighting in walk if 0 < step_s - sighting.time_s <= limit_s)
