"""Shots to train on: worlds, and in each a few cameras of the design space."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tacos_framework import Fault, UserError, generator
from tacos_framework.plan import Plan
from tacos_framework.simulation import EpisodeSpec, Simulation
from tacos_plugins.pretraining.kept_frames import write_frames

log = logging.getLogger(__name__)

MOST_TRIES = 1000
"""Random candidates tried until one keeps the constraints."""


@dataclass(frozen=True)
class TrainingShot:
    """A camera's part of a trip through a world."""

    values: Mapping[str, Any]
    episode: EpisodeSpec
    """The part of the trip."""
    stem: str
    """Begins the names of the files its frames go to."""

    def files(self, folder: Path) -> list[Path]:
        """Files of its frames, batch by batch."""
        return sorted(folder.glob(f"{self.stem}_*.npz"))


@dataclass(frozen=True)
class Shooting:
    """All shots of a world, as a job: frames that are not there yet are rendered and kept."""

    task: str
    shots: tuple[TrainingShot, ...]
    folder: str

    def run(self, simulation: Simulation) -> int:
        """Number of images rendered."""
        rendered = 0
        folder = Path(self.folder)
        for shot in self.shots:
            done = folder / f"{shot.stem}.done"
            if done.exists():
                continue
            for i, frames in enumerate(simulation.batches(self.task, shot.values, shot.episode, wanted=True)):
                write_frames(folder / f"{shot.stem}_{i:03d}.npz", frames)
                rendered += len(frames.episode) * len(frames.images)
            done.touch()
        return rendered

    def lost(self, reason: str) -> int:
        """The world is left out."""
        log.warning("no images of the world of %s: %s", self.shots[0].stem, reason)
        return 0


def shots_of_worlds(
    plan: Plan, *, seed: int, purpose: str, images: int, images_per_world: int, cameras_per_world: int
) -> Iterator[tuple[TrainingShot, ...]]:
    """For each world its shots, `images` in all: every camera another one, drawn from the design space.

    Raises `UserError` when hardly any camera keeps the constraints.
    """
    for world in range(-(-images // images_per_world)):
        frames = min(images_per_world, images - world * images_per_world)
        cameras = min(cameras_per_world, frames)
        yield tuple(
            TrainingShot(
                _camera(plan, seed, purpose, world, camera),
                EpisodeSpec(seed, (purpose, world), frames, (camera, cameras)),
                f"{purpose}_{world:04d}_{camera:02d}",
            )
            for camera in range(cameras)
        )


def _camera(plan: Plan, seed: int, *name: str | int) -> dict[str, Any]:
    """A random candidate that keeps the constraints."""
    rig, rng = plan.rig.make(), generator(seed, "camera", *name)
    for _ in range(MOST_TRIES):
        values = plan.space.sample(rng).as_dict()
        derived = rig.derived(plan.rig_variables(values))
        if not plan.breaches(values, derived):
            return values
    raise UserError(
        Fault(
            "problem",
            f"none of {MOST_TRIES} random cameras keeps its constraints",
            "",
            "Relax them, or narrow the design space.",
        )
    )
