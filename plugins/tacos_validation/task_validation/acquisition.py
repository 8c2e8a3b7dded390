"""Frames of a target from one place after another, and what a task makes of each pair of neighbours."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Episode, Exposure, FrameBatch, Rig, Scores
from tacos_framework.formation import EpisodeDraws, captured, frames_for
from tacos_plugins.noise_calibration.bench import expose


@dataclass(frozen=True, eq=False)
class Taken:
    """Scores of one camera in one simulator."""

    scores: Mapping[str, NDArray[np.float64]]
    """Name to (settings, seeds, pairs) scores of each pair of neighbouring places; NaN where there is
    none."""
    samples: tuple[FrameBatch, ...]  # for each setting a frame from the middle of the way
    on_target_px: NDArray[np.int64]  # (places,) pixels on anything but the background
    luminance_cd_m2: float  # mean luminance of those pixels over all places [cd/m2]


def take(
    episode: Episode,
    rig: Rig,
    renderer: Any,
    sensor: Any,
    task: Any,
    exposures: Sequence[Exposure],
    *,
    seed: int,
    seeds: int,
    names: Sequence[str],
    rendered: Callable[[], None],
) -> Taken:
    """Render each place once, take frames of it with fresh noise, and score each pair of neighbours.

    Light is rendered for the first exposure alone: nothing moves while the shutter is open, so the others
    differ in what the sensor makes of the light.

    `seeds`: frames with noise of their own for every place and exposure. `names`: what the noise is for,
    besides exposure, seed and place.
    """
    places = len(episode)
    scores = {name: np.full((len(exposures), seeds, places - 1), np.nan) for name in type(task).scores}
    begun: dict[tuple[int, int], Any] = {}
    samples: list[FrameBatch] = []
    on_target, luminance = np.zeros(places, np.int64), 0.0
    for place in range(places):
        here = episode[place : place + 1]
        capture = captured(renderer, rig, partial(renderer.capture, here, exposure=exposures[0]))
        view = capture.views[0]
        target = view.object_id[0] > 0
        on_target[place] = np.count_nonzero(target)
        luminance += float(view.luminance_cd_m2[0][target].mean()) / places if target.any() else 0.0
        for setting, exposure in enumerate(exposures):
            for number in range(seeds):
                draws = EpisodeDraws(seed, (*names, setting, number))
                frame = expose(sensor, capture, exposure, draws, place)
                if place == places // 2 and number == 0:
                    samples.append(frame)
                if (last := begun.pop((setting, number), None)) is not None:
                    last.update(frames_for(task, frame))
                    _note(scores, (setting, number, place - 1), last.scores())
                if place < places - 1:
                    scorer = task.begin(state=None)
                    scorer.update(frames_for(task, frame))
                    begun[setting, number] = scorer
        rendered()
    return Taken(scores, tuple(samples), on_target, luminance)


def _note(scores: Mapping[str, NDArray[np.float64]], at: tuple[int, int, int], found: Scores) -> None:
    for name, value in found.items():
        if name in scores:
            scores[name][at] = value
