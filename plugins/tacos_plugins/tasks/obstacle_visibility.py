"""Whether obstacles come into sight before the agent steps on them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tacos_framework.contracts import Scores, State
from tacos_framework.settings import Settings, setting
from tacos_framework.values import Crossing, FrameBatch, View


class ObstacleVisibility:
    """The share of obstacles on the agent's path that were seen before they were stepped on.

    An obstacle is seen when, in any frame of the same walk taken before the agent steps on it, enough of its
    pixels are visible in any camera of the rig. Visibility is that of the rendered ids, as in the paper;
    noise does not hide an obstacle.

    ``seen_ratio``
        Seen / stepped on, in 0..1; higher is better. Obstacles stepped on outside the time the frames span
        do not count, and an episode without any has no score.

    References
    ----------
    The paper, Sec. 4.3, o_seen / o_total.
    """

    class Config(Settings):
        """Settings of the task."""

        min_pixels: int = setting(
            1,
            help="Photosites an obstacle must cover to be seen; a binned pixel counts for all it averages.",
            unit="px",
            ge=1,
        )
        before_s: float | None = setting(
            None, help="Count only frames at most this long before the step; by default any.", unit="s", gt=0
        )
        within_m: float | None = setting(
            None,
            help="Count only pixels at most this far along the optical axis; by default any.",
            unit="m",
            gt=0,
        )

    scores: ClassVar[tuple[str, ...]] = ("seen_ratio",)
    score_meanings: ClassVar[Mapping[str, str]] = {
        "seen_ratio": "share of obstacles on the path that were seen in time",
    }

    def __init__(self, config: Config) -> None:
        self.config = config

    def begin(self, *, state: State | None = None) -> ObstacleScorer:
        """A scorer for one episode."""
        return ObstacleScorer(self.config)


@dataclass(frozen=True)
class Sighting:
    """A frame's time [s] and the obstacles seen in it."""

    time_s: float
    object_ids: frozenset[int]


class ObstacleScorer:
    """Scores one episode; keeps the time of each frame and which obstacles it shows."""

    def __init__(self, config: ObstacleVisibility.Config) -> None:
        self._config = config
        self._walks: dict[int, list[Sighting]] = {}
        self._crossings: tuple[Crossing, ...] = ()

    def update(self, frames: FrameBatch) -> None:
        """Take in the next frames."""
        episode = frames.episode
        self._crossings = episode.crossings
        obstacles = sorted({crossing.object_id for crossing in episode.crossings})
        for frame in range(len(episode)):
            seen = {
                obstacle for view in frames.capture.views for obstacle in self._seen(view, frame, obstacles)
            }
            walk = self._walks.setdefault(int(episode.walk[frame]), [])
            walk.append(Sighting(float(episode.time_s[frame]), frozenset(seen)))

    def scores(self) -> Scores:
        """The share seen of the obstacles stepped on so far."""
        verdicts = [
            self._in_time(crossing, walk)
            for walk in self._walks.values()
            for crossing in self._crossings
            if walk[0].time_s <= crossing.time_s <= walk[-1].time_s
        ]
        return {"seen_ratio": sum(verdicts) / len(verdicts)} if verdicts else {}

    def _seen(self, view: View, frame: int, obstacles: Iterable[int]) -> set[int]:
        """The obstacles that cover enough of a view."""
        ids = view.object_id[frame]
        if self._config.within_m is not None:
            ids = ids[view.depth_m[frame] <= self._config.within_m]
        counts = np.bincount(ids.ravel(), minlength=max(obstacles, default=0) + 1) * view.camera.binning**2
        return {obstacle for obstacle in obstacles if counts[obstacle] >= self._config.min_pixels}

    def _in_time(self, crossing: Crossing, walk: Iterable[Sighting]) -> bool:
        """Whether an obstacle was seen in its walk before the step, and lately enough."""
        limit_s = np.inf if self._config.before_s is None else self._config.before_s
        return any(
            crossing.object_id in sighting.object_ids and 0 < crossing.time_s - sighting.time_s <= limit_s
            for sighting in walk
        )
