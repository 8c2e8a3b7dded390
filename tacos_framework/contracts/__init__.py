"""The contract of each kind of component, one Protocol a kind.

Positional parameters are input ports, the return annotation is the output port, and keyword-only parameters
are what the framework supplies: a component asks for those it needs and leaves out the rest.

=================  ====================================================================================
keyword            what the framework supplies
=================  ====================================================================================
rng                `numpy.random.Generator`, spawned by name from the study's seed
rig                the `Rig` of the candidate
exposure           the `Exposure` of the scenario
illumination_lux   illuminance of the scenario [lux]
memory             a dictionary for what a transform must know of earlier frames of the episode
state              the state of a trainable task
budget             how much to train (`Budget`)
=================  ====================================================================================

Every component class has a ``Config`` (`tacos_framework.settings.Settings`) and is built as
``Class(Class.Config(...))``; optimizers take the design space and a generator beside it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tacos_framework.contracts.control import Controller, ControllerBase
from tacos_framework.contracts.effect import (
    FILE_STAGES,
    LIGHT_STAGES,
    STAGES,
    Effect,
    EffectBase,
    Stage,
    acts_after_noise,
    formation_order,
    moves_pixels,
)
from tacos_framework.contracts.executor import Executor, ExecutorBase, JobRunner
from tacos_framework.contracts.observed import SURE, Estimate, LookAlike, ObservedCapture, ShownBy
from tacos_framework.contracts.optimizer import (
    Asked,
    DesignProblem,
    Evaluated,
    Optimizer,
    OptimizerBase,
    ScoreScale,
)
from tacos_framework.contracts.optional import optional
from tacos_framework.contracts.procedure import Procedure, ProcedureBase
from tacos_framework.contracts.renderer import Renderer, RendererBase
from tacos_framework.contracts.rig import RigBase, RigBuilder
from tacos_framework.contracts.scene import EpisodeStore, Scene, SceneBase
from tacos_framework.contracts.sensor import Draw, Sensor, SensorBase
from tacos_framework.contracts.task import (
    WANTED_FILES,
    Budget,
    Scorer,
    Scores,
    State,
    Task,
    TaskBase,
    Trainable,
    TrainableBase,
    Wanted,
    learns,
)
from tacos_framework.contracts.transform import Transform

__all__ = [
    "BASES",
    "FILE_STAGES",
    "LIGHT_STAGES",
    "PROTOCOLS",
    "STAGES",
    "SURE",
    "VERBS",
    "WANTED_FILES",
    "Asked",
    "Budget",
    "Controller",
    "ControllerBase",
    "DesignProblem",
    "Draw",
    "Effect",
    "EffectBase",
    "EpisodeStore",
    "Estimate",
    "Evaluated",
    "Executor",
    "ExecutorBase",
    "JobRunner",
    "LookAlike",
    "ObservedCapture",
    "Optimizer",
    "OptimizerBase",
    "Procedure",
    "ProcedureBase",
    "Renderer",
    "RendererBase",
    "RigBase",
    "RigBuilder",
    "Scene",
    "SceneBase",
    "ScoreScale",
    "Scorer",
    "Scores",
    "Sensor",
    "SensorBase",
    "ShownBy",
    "Stage",
    "State",
    "Task",
    "TaskBase",
    "Trainable",
    "TrainableBase",
    "Transform",
    "Wanted",
    "acts_after_noise",
    "formation_order",
    "learns",
    "moves_pixels",
    "optional",
]

PROTOCOLS: Mapping[str, type[Any]] = {
    "scene": Scene,
    "rig": RigBuilder,
    "renderer": Renderer,
    "effect": Effect,
    "sensor": Sensor,
    "transform": Transform,
    "control": Controller,
    "task": Task,
    "optimizer": Optimizer,
    "executor": Executor,
    "procedure": Procedure,
}

BASES: Mapping[str, type[Any]] = {
    "scene": SceneBase,
    "rig": RigBase,
    "renderer": RendererBase,
    "effect": EffectBase,
    "sensor": SensorBase,
    "control": ControllerBase,
    "task": TrainableBase,
    "optimizer": OptimizerBase,
    "executor": ExecutorBase,
    "procedure": ProcedureBase,
}
"""The class that has the optional members of a kind, for kinds that have any."""

VERBS: Mapping[str, tuple[str, ...]] = {
    "scene": ("episode",),
    "rig": ("build", "derived"),
    "renderer": ("capture",),
    "effect": (),
    "sensor": ("expect", "moments", "draw", "dn_per_electron"),
    "transform": ("transform",),
    "control": ("adjust",),
    "task": ("begin",),
    "optimizer": ("ask", "tell", "stop", "state", "restore"),
    "executor": ("map", "close"),
    "procedure": ("run",),
}
"""The methods a component of each kind must have."""
