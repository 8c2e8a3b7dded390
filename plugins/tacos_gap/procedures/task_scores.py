"""Scores of a perception task on captures: on the real frames, and on their simulation before and after."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from tacos_framework.fitness import mean_scores
from tacos_framework.formation import EpisodeDraws, PlacedEffect
from tacos_framework.plugins import Plugins
from tacos_framework.values import Capture as Light
from tacos_framework.values import Episode, FrameBatch, Object, Trajectory, View, World
from tacos_gap.captures import RealCapture
from tacos_gap.formation import simulate
from tacos_gap.sensing import camera_of

TASK = "orb-features"
NODE = "features"
"""What a recipe usually calls it: scores are named ``features.inliers``."""

KINDS = ("scene", "edge", "sequence")
_FULL_8_BIT = 255


def task_scores(
    captures: Sequence[RealCapture], effects: Sequence[PlacedEffect], plugins: Plugins, seed: int
) -> dict[str, dict[str, float]]:
    """Scores of ``task.orb-features`` by name: ``real``, ``sim_before`` and ``sim_after``.

    Each is the mean over the captures that show something in at least two frames; empty where there is none,
    or where the task is not installed.
    """
    shown = [c for c in captures if c.kind in KINDS and c.frames > 1 and c.expected_dn is not None]
    if not shown or not any(r.component.use == f"task.{TASK}" for r in plugins):
        return {}
    task = plugins.resolve(f"task.{TASK}", "task")
    found: dict[str, list[Mapping[str, float]]] = {"real": [], "sim_before": [], "sim_after": []}
    for capture in shown:
        draws = EpisodeDraws(seed, ("task", capture.id))
        stacks = {
            "real": capture.real_dn,
            "sim_before": simulate(capture, (), draws),
            "sim_after": simulate(capture, effects, draws),
        }
        for name, frames in stacks.items():
            scorer = task(task.Config()).begin(state=None)
            scorer.update(as_batch(capture, frames))
            found[name].append(scorer.scores())
    means = {name: mean_scores(scores) for name, scores in found.items()}
    return {
        f"{NODE}.{score}": {name: round(values[score], 3) for name, values in means.items()}
        for score in means["real"]
        if all(score in values for values in means.values())
    }


def as_batch(capture: RealCapture, frames_dn: NDArray[np.float32]) -> FrameBatch:
    """Frames of a capture as those of a simulated walk; of the world behind them nothing is known."""
    count, height, width = frames_dn.shape[:3]
    context = capture.context
    still = np.tile(np.eye(4), (count, 1, 1))
    view = View(
        camera_of(capture),
        still,
        np.broadcast_to(np.float32(0), (count, height, width, 3)),
        np.broadcast_to(np.float32(np.inf), (count, height, width)),
        np.broadcast_to(np.int32(0), (count, height, width)),
    )
    world = World("captures", (), (), (Object("background", "background"),), ("background",))
    path = Trajectory(np.zeros(1), np.eye(4)[None])
    episode = Episode(world, path, np.arange(count, dtype=np.float64), np.zeros(count, np.int32))
    narrow = context.white_level_dn <= _FULL_8_BIT
    images = frames_dn.astype(np.uint8) if narrow else frames_dn.astype(np.uint16)
    return FrameBatch(Light(episode, (view,)), (images,), context.black_level_dn, context.white_level_dn)
