"""The default plugins pass the suites that third parties are given."""

# ruff: noqa: RUF012 - settings stand as plain class attributes, as plugin authors will write them

from __future__ import annotations

import pytest

from tacos_framework.testing import (
    EffectConformance,
    ExecutorConformance,
    OptimizerConformance,
    RendererConformance,
    RigConformance,
    SceneConformance,
    SensorConformance,
    TaskConformance,
)
from tacos_plugins.effects.vignetting import Vignetting
from tacos_plugins.executors.local import LocalExecutor
from tacos_plugins.executors.process import ProcessExecutor
from tacos_plugins.optimizers.genetic import Genetic
from tacos_plugins.optimizers.random_search import RandomSearch
from tacos_plugins.renderers.analytic import AnalyticRenderer
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer
from tacos_plugins.rigs.monocular import MonocularRig
from tacos_plugins.rigs.stereo import StereoRig
from tacos_plugins.scenes.indoor.scene import IndoorScene
from tacos_plugins.sensors.affine_noise import AffineNoise
from tacos_plugins.tasks.obstacle_visibility import ObstacleVisibility
from tacos_plugins.tasks.orb_features import OrbFeatures

SENSOR = {"name": "test", "width_px": 640, "height_px": 480, "pixel_um": 3.0}


class TestIndoorScene(SceneConformance):
    component = IndoorScene
    config = {"size_m": (11.0, 5.5), "frames": 8, "clutter": 0.0}


@pytest.mark.gl
class TestModernglRenderer(RendererConformance):
    component = ModernglRenderer


class TestAnalyticRenderer(RendererConformance):
    component = AnalyticRenderer


class TestMonocularRig(RigConformance):
    component = MonocularRig
    variables = {"focal_length_mm": 2.0, "sensor": SENSOR}


class TestStereoRig(RigConformance):
    component = StereoRig
    variables = {"baseline_m": 0.1, "hfov_deg": 80.0, "sensor": SENSOR}


class TestVignetting(EffectConformance):
    component = Vignetting
    config = {"k1": -0.4}


class TestAffineNoise(SensorConformance):
    component = AffineNoise


class TestAffineNoiseAtTwelveBits(SensorConformance):
    component = AffineNoise
    config = {"bit_depth": 12, "black_level_dn": 64}


class TestOrbFeatures(TaskConformance):
    component = OrbFeatures


class TestObstacleVisibility(TaskConformance):
    component = ObstacleVisibility


class TestGenetic(OptimizerConformance):
    component = Genetic
    config = {"population": 6, "keep": 2, "parents": 3, "generations": 5}


class TestGeneticThatRedraws(OptimizerConformance):
    component = Genetic
    config = {"population": 4, "keep": 1, "parents": 2, "generations": 4, "discrete_mutation": "redraw"}


class TestRandomSearch(OptimizerConformance):
    component = RandomSearch
    config = {"evaluations": 10, "batch": 4}


class TestLocalExecutor(ExecutorConformance):
    component = LocalExecutor


class TestProcessExecutor(ExecutorConformance):
    component = ProcessExecutor
    config = {"workers": 2}
