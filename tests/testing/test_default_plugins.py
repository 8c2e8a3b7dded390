"""The default plugins pass the suites that third parties are given."""

# ruff: noqa: RUF012 - settings stand as plain class attributes, as plugin authors will write them

from __future__ import annotations

from dataclasses import replace

import numpy as np
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
from tacos_framework.testing.samples import sample_frames
from tacos_plugins.effects.black_level import BlackLevel
from tacos_plugins.effects.colour_matrix import ColourMatrix
from tacos_plugins.effects.conversion_gain_error import ConversionGainError
from tacos_plugins.effects.crosstalk import Crosstalk
from tacos_plugins.effects.dark_current import DarkCurrent
from tacos_plugins.effects.demosaic import Demosaic
from tacos_plugins.effects.denoise import Denoise
from tacos_plugins.effects.dsnu import Dsnu
from tacos_plugins.effects.jpeg import Jpeg
from tacos_plugins.effects.lens_shading_correction import LensShadingCorrection
from tacos_plugins.effects.nonlinearity import Nonlinearity
from tacos_plugins.effects.prnu import Prnu
from tacos_plugins.effects.quantisation import Quantisation
from tacos_plugins.effects.read_noise import ReadNoise
from tacos_plugins.effects.row_noise import RowNoise
from tacos_plugins.effects.saturation import Saturation
from tacos_plugins.effects.sharpening import Sharpening
from tacos_plugins.effects.tone_curve import ToneCurve
from tacos_plugins.effects.vignetting import Vignetting
from tacos_plugins.effects.white_balance import WhiteBalance
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
from tacos_plugins.sensors.emva import Emva
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


class TestBlackLevel(EffectConformance):
    component = BlackLevel
    config = {"offset_dn": 3.0}


class TestColourMatrix(EffectConformance):
    component = ColourMatrix
    config = {"matrix": ((1.6, -0.4, -0.2), (-0.3, 1.5, -0.2), (0.0, -0.6, 1.6))}

    def sample(self):
        grey = sample_frames()
        tinted = tuple((image * np.array([1.0, 0.7, 0.4])).astype(image.dtype) for image in grey.images)
        return replace(grey, images=tinted)


class TestConversionGainError(EffectConformance):
    component = ConversionGainError
    config = {"scale": 1.3}


class TestCrosstalk(EffectConformance):
    component = Crosstalk
    config = {"share": 0.02}


class TestDarkCurrent(EffectConformance):
    component = DarkCurrent
    config = {"rate_dn_s": 100.0, "hot_share": 0.01}


class TestDemosaic(EffectConformance):
    component = Demosaic
    config = {"method": "bilinear"}


class TestDenoise(EffectConformance):
    component = Denoise
    config = {"strength": 1.0}


class TestDsnu(EffectConformance):
    component = Dsnu
    config = {"sigma_dn": 1.0, "column_sigma_dn": 1.0}


class TestJpeg(EffectConformance):
    component = Jpeg
    config = {"quality": 70}


class TestLensShadingCorrection(EffectConformance):
    component = LensShadingCorrection
    config = {"k1": 1.0}


class TestNonlinearity(EffectConformance):
    component = Nonlinearity
    config = {"a2": -0.1}


class TestPrnu(EffectConformance):
    component = Prnu
    config = {"sigma": 0.02}


class TestQuantisation(EffectConformance):
    component = Quantisation
    config = {"step_dn": 4.0}


class TestReadNoise(EffectConformance):
    component = ReadNoise
    config = {"sigma_dn": 1.0, "tail": 0.2}


class TestRowNoise(EffectConformance):
    component = RowNoise
    config = {"sigma_dn": 1.0, "column_sigma_dn": 1.0}


class TestSaturation(EffectConformance):
    component = Saturation
    config = {"level_dn": 150.0}


class TestSharpening(EffectConformance):
    component = Sharpening
    config = {"amount": 0.5}


class TestToneCurve(EffectConformance):
    component = ToneCurve
    config = {"gamma": 0.45}


class TestWhiteBalance(EffectConformance):
    component = WhiteBalance
    config = {"red": 1.5}


class TestAffineNoise(SensorConformance):
    component = AffineNoise


class TestAffineNoiseAtTwelveBits(SensorConformance):
    component = AffineNoise
    config = {"bit_depth": 12, "black_level_dn": 64}


class TestEmva(SensorConformance):
    component = Emva
    config = {"quantum_efficiency": 0.6, "full_well_e": 1e4, "read_noise_e": 3.0, "dark_current_e_s": 10.0}


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
