"""A whole study as those see it who analyse it: every camera that was scored, episode by episode."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from tacos_framework.contracts import DesignProblem, Scores
from tacos_framework.quantities import Objective
from tacos_framework.recipe import Recipe
from tacos_framework.study.sequential import PairedInterval
from tacos_framework.variables.design_space import DesignSpace

Values = Mapping[str, Any]
"""Plain values of a camera's design variables."""


@dataclass(frozen=True)
class ScoredEpisode:
    """The scores of a camera in one episode."""

    camera: Values
    """Plain values of its variables."""
    episode: str
    """Names the scene: equal names are equal worlds, paths and draws of noise."""
    scores: Scores
    """By ``node.score``; with several scenarios by ``scenario/node.score``."""
    stage: Literal["design", "final", "test", "analysis"]
    """Purpose of the scoring: the search, the choice among the finalists, the test, or an analysis."""
    generation: int
    """The generation of the search, from 0; of later stages the number of generations."""


@dataclass(frozen=True)
class StudiedCamera:
    """The designed camera, or a product."""

    name: str
    title: str
    """Name in results, and title for people."""
    camera: Values | None
    """Plain values of its variables; None where no candidate of it could be scored."""
    free: tuple[str, ...]
    """The variables that were searched for it."""


@dataclass(frozen=True)
class StudyRecord:
    """The input of an analysis, which changes none of it."""

    recipe: Recipe
    space: DesignSpace
    problem: DesignProblem
    """The design problem."""
    designed: str
    """Name of the designed camera among `cameras`."""
    cameras: tuple[StudiedCamera, ...]
    """The designed camera first, then the products."""
    episodes: tuple[ScoredEpisode, ...]
    """Everything that was scored, in the order in which it was."""
    derived: Callable[[Values], Mapping[str, float]]
    coordinates: Callable[[Values], Mapping[str, float]]
    """The rig's derived quantities for plain values, and what images depend on."""
    broken: Callable[[Values], Mapping[str, float]]
    """By how much plain values break each constraint; empty where they keep all."""
    unknown: Callable[[Values], tuple[str, ...]]
    """Bounded quantities that nobody states for plain values, and that their constraints let pass."""
    score: Callable[[Sequence[Values], int], list[list[ScoredEpisode]]]
    """Score further cameras in as many fresh episodes, the same for all; they are rendered now and count.
    Gives the scores of each camera's episodes, none for one that fails.
    """
    comparisons: Mapping[str, PairedInterval] = field(default_factory=dict)
    """Differences on the test scenes of the designed camera less each product that was scored on them, by
    name.
    """
    failed: Mapping[str, str] = field(default_factory=dict)
    """Cameras without a score, and why in a sentence."""
    degenerate: str | None = None
    """Why no winner may be named, in a sentence; None where one may."""
    objectives: tuple[Objective, ...] = ()
    """Aims to be traded off against each other; none where the fitness alone counts."""

    @property
    def products(self) -> tuple[StudiedCamera, ...]:
        return tuple(camera for camera in self.cameras if camera.name != self.designed)
