"""Evaluating candidates: from design variables through the graph to scores.

==================  ========================================================================================
``simulation``      a plan brought to life, candidate by candidate
``context``         one candidate on its way through the graph: episodes, frames, the time they take
``scores``          what the tasks report of an episode
``overrides``       a candidate's values, sorted by what they set
``training``        frames for tasks that learn, and their states
``episodes``        which episode is meant, and its parts
``evaluation``      what came out for a candidate
``checked_outputs`` light and depth that mean something
``shown``           candidates beyond what a scene can show
``clock``           seconds by name
``jobs``            what other processes are asked to do
``evaluator``       does jobs, in whatever process it is unpickled
==================  ========================================================================================
"""

from __future__ import annotations

from tacos_framework.simulation.episodes import EpisodeSpec
from tacos_framework.simulation.evaluation import (
    Evaluation,
    Raised,
    failed_by,
    merged_evaluation,
    with_fitness,
)
from tacos_framework.simulation.evaluator import Evaluator
from tacos_framework.simulation.jobs import BuildJob, PrepareJob, SampleJob, ScoreJob
from tacos_framework.simulation.overrides import overrides_of
from tacos_framework.simulation.shown import notes_on_shown
from tacos_framework.simulation.simulation import Simulation, placed
from tacos_framework.simulation.training import state_key

__all__ = [
    "BuildJob",
    "EpisodeSpec",
    "Evaluation",
    "Evaluator",
    "PrepareJob",
    "Raised",
    "SampleJob",
    "ScoreJob",
    "Simulation",
    "failed_by",
    "merged_evaluation",
    "notes_on_shown",
    "overrides_of",
    "placed",
    "state_key",
    "with_fitness",
]
