"""Conformance suites: what a component of each kind must do, as pytest classes to inherit from.

A plugin author names the component, and pytest runs what the framework relies on::

    from tacos_framework.testing import SensorConformance
    from my_plugin.sensor import MySensor


    class TestMySensor(SensorConformance):
        component = MySensor
        config = {"full_well_e": 9000}

Needs pytest, which ``pip install tacos-framework[testing]`` brings.
"""

from __future__ import annotations

import pytest

_SUITES = (
    "component",
    "control",
    "effect",
    "executor",
    "optimizer",
    "procedure",
    "renderer",
    "rig",
    "scene",
    "sensor",
    "task",
    "transform",
)
pytest.register_assert_rewrite(*(f"{__name__}.{suite}" for suite in _SUITES))

from tacos_framework.testing.component import ComponentConformance  # noqa: E402
from tacos_framework.testing.control import ControlConformance  # noqa: E402
from tacos_framework.testing.effect import EffectConformance  # noqa: E402
from tacos_framework.testing.executor import ExecutorConformance  # noqa: E402
from tacos_framework.testing.optimizer import OptimizerConformance  # noqa: E402
from tacos_framework.testing.procedure import ProcedureConformance  # noqa: E402
from tacos_framework.testing.renderer import RendererConformance  # noqa: E402
from tacos_framework.testing.rig import RigConformance  # noqa: E402
from tacos_framework.testing.scene import SceneConformance  # noqa: E402
from tacos_framework.testing.sensor import SensorConformance  # noqa: E402
from tacos_framework.testing.task import TaskConformance, TrainableConformance  # noqa: E402
from tacos_framework.testing.transform import TransformConformance  # noqa: E402

__all__ = [
    "ComponentConformance",
    "ControlConformance",
    "EffectConformance",
    "ExecutorConformance",
    "OptimizerConformance",
    "ProcedureConformance",
    "RendererConformance",
    "RigConformance",
    "SceneConformance",
    "SensorConformance",
    "TaskConformance",
    "TrainableConformance",
    "TransformConformance",
]
