"""The default plugins pass the suites that third parties are given."""

# ruff: noqa: RUF012 - settings stand as plain class attributes, as plugin authors will write them

from __future__ import annotations

from importlib.util import find_spec

import pytest

from tacos_framework.testing import (
    ExecutorConformance,
    OptimizerConformance,
    ProcedureConformance,
    RendererConformance,
    RigConformance,
    SceneConformance,
    TaskConformance,
)
from tacos_framework.variables.design_space import Continuous, DesignSpace
from tacos_gap.procedures.simulate_captures import SimulateCaptures
from tacos_plugins.executors.local import LocalExecutor
from tacos_plugins.executors.on_ray.executor import RayExecutor
from tacos_plugins.executors.process import ProcessExecutor
from tacos_plugins.noise_calibration.calibrate import CalibrateNoise
from tacos_plugins.optimizers.cma_es import CmaEs
from tacos_plugins.optimizers.genetic import Genetic
from tacos_plugins.optimizers.optuna_search import OptunaSearch
from tacos_plugins.optimizers.physical_gp.optimizer import PhysicalGp
from tacos_plugins.optimizers.policy.ppo import Ppo
from tacos_plugins.optimizers.random_search import RandomSearch
from tacos_plugins.optimizers.sobol import Sobol
from tacos_plugins.renderers.analytic import AnalyticRenderer
from tacos_plugins.renderers.mitsuba.renderer import MitsubaRenderer
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer
from tacos_plugins.rigs.monocular import MonocularRig
from tacos_plugins.rigs.stereo import StereoRig
from tacos_plugins.tasks.obstacle_visibility import ObstacleVisibility
from tacos_plugins.tasks.orb_features import OrbFeatures
from tacos_plugins.tasks.sgbm import Sgbm
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


class TestPhysicalGp(OptimizerConformance):
    component = PhysicalGp
    config = {"evaluations": 7, "starts": 3}


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
    config = {"sampler": "gp", "evaluations": 8, "batch": 2, "initial": 4}

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
