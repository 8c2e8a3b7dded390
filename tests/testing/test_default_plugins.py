"""The default plugins pass the suites that third parties are given."""

# ruff: noqa: RUF012 - settings stand as plain class attributes, as plugin authors will write them

from __future__ import annotations

from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest

from tacos_framework.testing import (
    EffectConformance,
    ExecutorConformance,
    OptimizerConformance,
    ProcedureConformance,
    RendererConformance,
    RigConformance,
    SceneConformance,
    SensorConformance,
    TaskConformance,
)
from tacos_framework.testing.samples import sample_frames
from tacos_framework.values import FrameBatch
from tacos_framework.variables.design_space import Continuous, DesignSpace
from tacos_gap.procedures.simulate_captures import SimulateCaptures
from tacos_plugins.effects.auto_exposure import AutoExposure
from tacos_plugins.effects.black_level import BlackLevel
from tacos_plugins.effects.colour_matrix import ColourMatrix
from tacos_plugins.effects.conversion_gain_error import ConversionGainError
from tacos_plugins.effects.crosstalk import Crosstalk
from tacos_plugins.effects.dark_current import DarkCurrent
from tacos_plugins.effects.defocus import Defocus
from tacos_plugins.effects.demosaic import Demosaic
from tacos_plugins.effects.denoise import Denoise
from tacos_plugins.effects.dsnu import Dsnu
from tacos_plugins.effects.exposure_error import ExposureError
from tacos_plugins.effects.flicker import Flicker
from tacos_plugins.effects.focal_length_error import FocalLengthError
from tacos_plugins.effects.illumination_gradient import IlluminationGradient
from tacos_plugins.effects.jpeg import Jpeg
from tacos_plugins.effects.lateral_chromatic_aberration import LateralChromaticAberration
from tacos_plugins.effects.lens_blur import LensBlur
from tacos_plugins.effects.lens_distortion import LensDistortion
from tacos_plugins.effects.lens_shading_correction import LensShadingCorrection
from tacos_plugins.effects.motion_blur import MotionBlur
from tacos_plugins.effects.nonlinearity import Nonlinearity
from tacos_plugins.effects.pose_error import PoseError
from tacos_plugins.effects.prnu import Prnu
from tacos_plugins.effects.quantisation import Quantisation
from tacos_plugins.effects.read_noise import ReadNoise
from tacos_plugins.effects.rolling_shutter import RollingShutter
from tacos_plugins.effects.row_noise import RowNoise
from tacos_plugins.effects.saturation import Saturation
from tacos_plugins.effects.sharpening import Sharpening
from tacos_plugins.effects.tone_curve import ToneCurve
from tacos_plugins.effects.veiling_glare import VeilingGlare
from tacos_plugins.effects.vignetting import Vignetting
from tacos_plugins.effects.white_balance import WhiteBalance
from tacos_plugins.executors.local import LocalExecutor
from tacos_plugins.executors.on_ray.executor import RayExecutor
from tacos_plugins.executors.process import ProcessExecutor
from tacos_plugins.optimizers.cma_es import CmaEs
from tacos_plugins.optimizers.genetic import Genetic
from tacos_plugins.optimizers.optuna_search import OptunaSearch
from tacos_plugins.optimizers.policy.ppo import Ppo
from tacos_plugins.optimizers.random_search import RandomSearch
from tacos_plugins.optimizers.sobol import Sobol
from tacos_plugins.renderers.analytic import AnalyticRenderer
from tacos_plugins.renderers.mitsuba.renderer import MitsubaRenderer
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer
from tacos_plugins.rigs.monocular import MonocularRig
from tacos_plugins.rigs.stereo import StereoRig
from tacos_plugins.sensors.affine_noise import AffineNoise
from tacos_plugins.sensors.emva import Emva
from tacos_plugins.tasks.obstacle_visibility import ObstacleVisibility
from tacos_plugins.tasks.orb_features import OrbFeatures
from tacos_plugins.tasks.sgbm import Sgbm
from tacos_validation.noise.calibrate import CalibrateNoise
from tacos_validation.noise.validate import ValidateNoise
from tacos_validation.task_validation.validate import ValidateTask
from tacos_worlds.bench.chessboard import Chessboard
from tacos_worlds.bench.colour_chart import ColourChart
from tacos_worlds.bench.grey_bars import GreyBars
from tacos_worlds.bench.light_box import LightBox
from tacos_worlds.bench.relief_target import ReliefTarget
from tacos_worlds.bench.slanted_edges import SlantedEdges
from tacos_worlds.bench.textured_target import TexturedTarget
from tacos_worlds.indoor.scene import IndoorScene
from tacos_worlds.street.scene import StreetScene
from tests.tasks.stereo_frames import stereo_frames

SENSOR = {"name": "test", "width_px": 640, "height_px": 480, "pixel_um": 3.0}


class TestIndoorScene(SceneConformance):
    component = IndoorScene
    config = {"size_m": (11.0, 5.5), "frames": 8, "clutter": 0.0}


class TestGreyBars(SceneConformance):
    component = GreyBars


class TestLightBox(SceneConformance):
    component = LightBox


class TestSlantedEdges(SceneConformance):
    component = SlantedEdges


class TestChessboard(SceneConformance):
    component = Chessboard
    config = {"tilt_deg": 20.0, "turn_deg": -10.0}


class TestColourChart(SceneConformance):
    component = ColourChart


class TestStreetScene(SceneConformance):
    component = StreetScene
    config = {"blocks": 1, "reach_m": 60, "frames": 3, "driving_cars": 1, "texture_px": 64}


class TestTexturedTarget(SceneConformance):
    component = TexturedTarget
    config = {"texture_px": 128, "speed_m_s": 0.1, "frames": 3}


class TestReliefTarget(SceneConformance):
    component = ReliefTarget
    config = {"blocks": 2, "texture_px": 128, "wall_m": 1.0, "frames": 3}


@pytest.mark.gl
class TestModernglRenderer(RendererConformance):
    component = ModernglRenderer


class TestAnalyticRenderer(RendererConformance):
    component = AnalyticRenderer


class TestMitsubaRenderer(RendererConformance):
    component = MitsubaRenderer
    config = {"samples": 16}

    @pytest.fixture(autouse=True)
    def _needs_mitsuba(self):
        pytest.importorskip("mitsuba", reason="the extra mitsuba is not installed")


class TestMonocularRig(RigConformance):
    component = MonocularRig
    variables = {"focal_length_mm": 2.0, "sensor": SENSOR}


class TestStereoRig(RigConformance):
    component = StereoRig
    variables = {"baseline_m": 0.1, "hfov_deg": 80.0, "sensor": SENSOR}


class TestVignetting(EffectConformance):
    component = Vignetting
    config = {"k1": -0.4}


class TestExposureError(EffectConformance):
    component = ExposureError
    config = {"scale": 1.3}


class TestIlluminationGradient(EffectConformance):
    component = IlluminationGradient
    config = {"gx": 0.2, "gy": -0.1}


class TestFocalLengthError(EffectConformance):
    component = FocalLengthError
    config = {"scale": 1.05, "dx_px": 1.5, "dy_px": -0.5}


class TestLensDistortion(EffectConformance):
    component = LensDistortion
    config = {"k1": -0.1, "k2": 0.02, "p1": 0.003}


class TestLensDistortionFisheye(EffectConformance):
    component = LensDistortion
    config = {"model": "fisheye", "k1": 0.05}


class TestLateralChromaticAberration(EffectConformance):
    component = LateralChromaticAberration
    config = {"red": 0.004, "blue": -0.003, "red_r2": 0.002}


class TestDefocus(EffectConformance):
    component = Defocus
    config = {"radius_px": 2.5}


class TestDefocusByDepth(EffectConformance):
    component = Defocus
    config = {"focus_m": 0.5}


class TestLensBlur(EffectConformance):
    component = LensBlur
    config = {"sigma_px": 1.2, "growth": 0.8}


class TestLensBlurByDiffraction(EffectConformance):
    component = LensBlur
    config = {"wavelength_nm": 2000.0}


class TestMotionBlur(EffectConformance):
    component = MotionBlur
    config = {"length_px": 5.0, "angle_deg": 30.0}


class TestRollingShutter(EffectConformance):
    component = RollingShutter
    config = {"row_time_us": 300.0}


class TestFlicker(EffectConformance):
    component = Flicker
    config = {"depth": 0.3, "period_rows": 20.0}


class TestVeilingGlare(EffectConformance):
    component = VeilingGlare
    config = {"share": 0.05}


class TestVeilingGlareNearby(EffectConformance):
    component = VeilingGlare
    config = {"share": 0.05, "spread": 0.2}


class TestPoseError(EffectConformance):
    component = PoseError
    config = {"rx": 1.0, "ry": -0.5, "rz": 2.0}


class TestPoseErrorWithAShift(EffectConformance):
    component = PoseError
    config = {"tx": 100.0, "tz": 50.0}


class TestAutoExposure(EffectConformance):
    component = AutoExposure
    config = {"target_mlx_s": 15.0, "lag_frames": 2.0}


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

    def sample(self) -> FrameBatch:
        """Frames with noise, as there is none to take away from others."""
        frames = super().sample()
        rng = np.random.default_rng(2)
        noisy = [np.clip(np.rint(rng.normal(i, 3.0)), 0, 255).astype(np.uint8) for i in frames.images]
        return replace(frames, images=tuple(noisy))


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
    begins_at_once = True


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


class TestSgbm(TaskConformance):
    component = Sgbm

    def frames(self):
        return stereo_frames(sky_rows=4)


class TestGenetic(OptimizerConformance):
    component = Genetic
    config = {"population": 6, "keep": 2, "parents": 3, "generations": 5}


class TestGeneticThatRedraws(OptimizerConformance):
    component = Genetic
    config = {"population": 4, "keep": 1, "parents": 2, "generations": 4, "discrete_mutation": "redraw"}


class TestRandomSearch(OptimizerConformance):
    component = RandomSearch
    config = {"evaluations": 10, "batch": 4}


class TestSobol(OptimizerConformance):
    component = Sobol
    config = {"evaluations": 10, "batch": 4}


class TestCmaEs(OptimizerConformance):
    component = CmaEs
    config = {"evaluations": 30, "initial": 6}


class TestCmaEsThatStartsAnywhere(OptimizerConformance):
    component = CmaEs
    config = {"evaluations": 30, "initial": 0, "population": 4, "restarts": "ipop"}


class TestCmaEsOfNumbers(OptimizerConformance):
    component = CmaEs
    config = {"evaluations": 33, "initial": 6}

    def space(self):
        return DesignSpace([Continuous("pitch_deg", -30, 30, "deg"), Continuous("cameras", 1, 8, "1")])


class TestPpo(OptimizerConformance):
    component = Ppo
    config = {"evaluations": 22, "cameras": 4, "steps": 3, "rollout": 8, "minibatch": 4, "epochs": 2}

    @pytest.fixture(autouse=True)
    def _needs_stable_baselines(self):
        pytest.importorskip("stable_baselines3", reason="the extra rl is not installed")


class TestPpoRewardedByGain(TestPpo):
    config = {**TestPpo.config, "reward": "gain", "hidden": (8,)}


class TestOptunaTpe(OptimizerConformance):
    component = OptunaSearch
    config = {"evaluations": 24, "batch": 4, "initial": 8}

    @pytest.fixture(autouse=True)
    def _needs_optuna(self):
        pytest.importorskip("optuna", reason="the extra optuna is not installed")


class TestOptunaGp(OptimizerConformance):
    component = OptunaSearch
    config = {"sampler": "gp", "evaluations": 10, "batch": 2, "initial": 4}

    @pytest.fixture(autouse=True)
    def _needs_optuna_and_torch(self):
        pytest.importorskip("optuna", reason="the extra optuna is not installed")
        pytest.importorskip("torch", reason="torch is not installed")


BENCH = {"renderer": {"use": "renderer.analytic"}, "frames": 4}
BENCH_CAMERA = {
    "rig": {
        "use": "rig.monocular",
        "focal_length_mm": 1.2,
        "sensor": {"name": "test", "width_px": 200, "height_px": 80, "pixel_um": 1.55},
    },
    "sensor": {"use": "sensor.affine-noise", "responsivity_dn_per_lux_s": 68},
}


class TestCalibrateNoise(ProcedureConformance):
    component = CalibrateNoise
    config = {"rendering": {**BENCH_CAMERA, "exposure": {"exposure_ms": 30, "gain_db": 15}, "bench": BENCH}}
    files = ("calibration.yaml", "report.html")


class TestSimulateCaptures(ProcedureConformance):
    component = SimulateCaptures
    config = {
        "rig": {
            "use": "rig.monocular",
            "focal_length_mm": 0.2,
            "sensor": {"name": "test", "width_px": 32, "height_px": 24, "pixel_um": 3.0},
        },
        "renderer": {"use": "renderer.analytic"},
        "sensor": {"use": "sensor.affine-noise", "black_level_dn": 16},
        "captures": (
            {"id": "dark", "kind": "dark"},
            {"id": "flat", "kind": "flat", "scene": {"use": "scene.light-box"}},
        ),
    }
    files = ("captures.yaml",)


class TestValidateNoise(ProcedureConformance):
    component = ValidateNoise
    config = {
        "bench": BENCH,
        "cameras": ({**BENCH_CAMERA, "title": "test", "settings": ({"exposure_ms": 30, "gain_db": 15},)},),
    }
    files = ("report.html",)


class TestValidateTask(ProcedureConformance):
    component = ValidateTask
    config = {
        "scene": {"use": "scene.textured-target", "texture_px": 128, "speed_m_s": 0.1, "frames": 3},
        "simulator": {"use": "renderer.analytic"},
        "reference": {"use": "renderer.analytic"},
        "fixed": {"binning": 40},
        "seeds": 2,
    }
    files = ("report.html",)


class TestLocalExecutor(ExecutorConformance):
    component = LocalExecutor


class TestProcessExecutor(ExecutorConformance):
    component = ProcessExecutor
    config = {"workers": 2}


@pytest.mark.slow
class TestRayExecutor(ExecutorConformance):
    component = RayExecutor
    config = {"workers": 2, "cpus_per_worker": 0.25}  # so that two executors have room side by side

    @pytest.fixture(autouse=True)
    def _needs_ray(self):
        if find_spec("ray") is None:
            pytest.skip("the extra ray is not installed")
