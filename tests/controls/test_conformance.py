"""The shipped exposure controls keep the contract."""

from __future__ import annotations

from tacos_framework.testing import ControlConformance
from tacos_plugins.controls.gradient import Gradient
from tacos_plugins.controls.mean_level import MeanLevel


class TestMeanLevel(ControlConformance):
    component = MeanLevel


class TestGradient(ControlConformance):
    component = Gradient
