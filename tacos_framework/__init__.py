"""Design cameras for vision tasks in simulation, as a pipeline of plugins.

What stands here is for those who write recipes in Python, embed the library or write plugins: the way in
(`run`, `load_recipe`, `Plugins`), the contract of each kind of component, and the values that cross ports.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tacos_framework.components import Command as Command
    from tacos_framework.components import Component as Component
    from tacos_framework.contracts import Budget as Budget
    from tacos_framework.contracts import Controller as Controller
    from tacos_framework.contracts import Effect as Effect
    from tacos_framework.contracts import Evaluated as Evaluated
    from tacos_framework.contracts import Executor as Executor
    from tacos_framework.contracts import JobRunner as JobRunner
    from tacos_framework.contracts import LookAlike as LookAlike
    from tacos_framework.contracts import Optimizer as Optimizer
    from tacos_framework.contracts import Procedure as Procedure
    from tacos_framework.contracts import Renderer as Renderer
    from tacos_framework.contracts import RigBuilder as RigBuilder
    from tacos_framework.contracts import Scene as Scene
    from tacos_framework.contracts import Scorer as Scorer
    from tacos_framework.contracts import Scores as Scores
    from tacos_framework.contracts import Sensor as Sensor
    from tacos_framework.contracts import ShownBy as ShownBy
    from tacos_framework.contracts import Stage as Stage
    from tacos_framework.contracts import State as State
    from tacos_framework.contracts import Task as Task
    from tacos_framework.contracts import Trainable as Trainable
    from tacos_framework.contracts import Transform as Transform
    from tacos_framework.environment import EnvironmentFinding as EnvironmentFinding
    from tacos_framework.errors import CandidateFailed as CandidateFailed
    from tacos_framework.errors import Fault as Fault
    from tacos_framework.errors import UserError as UserError
    from tacos_framework.hookspecs import hookimpl as hookimpl
    from tacos_framework.plugins import Plugins as Plugins
    from tacos_framework.recipe import Recipe as Recipe
    from tacos_framework.recipe.loading import load_recipe as load_recipe
    from tacos_framework.recipe.procedure import ProcedureRecipe as ProcedureRecipe
    from tacos_framework.runner import run as run
    from tacos_framework.settings import Settings as Settings
    from tacos_framework.settings import physical as physical
    from tacos_framework.settings import setting as setting
    from tacos_framework.simulation import Evaluation as Evaluation
    from tacos_framework.study.progress import Progress as Progress
    from tacos_framework.values import Camera as Camera
    from tacos_framework.values import Capture as Capture
    from tacos_framework.values import ContextMissing as ContextMissing
    from tacos_framework.values import Crossing as Crossing
    from tacos_framework.values import Electrons as Electrons
    from tacos_framework.values import Episode as Episode
    from tacos_framework.values import Exposure as Exposure
    from tacos_framework.values import FrameBatch as FrameBatch
    from tacos_framework.values import ImageContext as ImageContext
    from tacos_framework.values import ImageGeometry as ImageGeometry
    from tacos_framework.values import Light as Light
    from tacos_framework.values import Material as Material
    from tacos_framework.values import MeshPart as MeshPart
    from tacos_framework.values import Mover as Mover
    from tacos_framework.values import Object as Object
    from tacos_framework.values import Rig as Rig
    from tacos_framework.values import Trajectory as Trajectory
    from tacos_framework.values import View as View
    from tacos_framework.values import World as World
    from tacos_framework.variables.design_space import Candidate as Candidate
    from tacos_framework.variables.design_space import DesignSpace as DesignSpace

__version__ = "0.1.0"

_HOMES = {
    "components": "Command Component",
    "contracts": (
        "Budget Controller Effect Evaluated Executor JobRunner LookAlike Optimizer Procedure Renderer "
        "RigBuilder Scene Scorer Scores Sensor ShownBy Stage State Task Trainable Transform"
    ),
    "environment": "EnvironmentFinding",
    "errors": "CandidateFailed Fault UserError",
    "hookspecs": "hookimpl",
    "plugins": "Plugins",
    "recipe": "Recipe",
    "recipe.loading": "load_recipe",
    "recipe.procedure": "ProcedureRecipe",
    "runner": "run",
    "settings": "Settings physical setting",
    "simulation": "Evaluation",
    "study.progress": "Progress",
    "values": (
        "Camera Capture ContextMissing Crossing Electrons Episode Exposure FrameBatch ImageContext "
        "ImageGeometry Light Material MeshPart Mover Object Rig Trajectory View World"
    ),
    "variables.design_space": "Candidate DesignSpace",
}
"""Module -> the public names in it, which are imported on first use."""

_HOME_OF = {name: home for home, names in _HOMES.items() for name in names.split()}

__all__ = ["__version__", *_HOME_OF]  # noqa: PLE0604 - all of them are text


if not TYPE_CHECKING:  # what is not above is an error to type checkers

    def __getattr__(name: str) -> Any:
        """Import public names on first use, so that importing the package costs nothing."""
        if name not in _HOME_OF:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return getattr(import_module(f"{__name__}.{_HOME_OF[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
