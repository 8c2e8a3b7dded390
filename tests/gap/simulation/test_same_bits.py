"""Frames of a study and of the diagnosis come from one image formation: they are the same bits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pytest

from tacos_framework.camera.exposure import exposure_per_luminance
from tacos_framework.contracts import Stage
from tacos_framework.formation import EpisodeDraws, PlacedEffect, PlacedSensor
from tacos_framework.formation.views import light_context
from tacos_framework.plan import Plan, make_plan
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Recipe
from tacos_framework.settings import Settings, setting
from tacos_framework.simulation import EpisodeSpec, Simulation
from tacos_framework.values import Camera, Exposure, FrameBatch, ImageContext, ImageGeometry
from tacos_gap.captures import Noise, RealCapture
from tacos_gap.simulation.formation import simulate
from tacos_gap.simulation.sensors import NODE, sensor_at, with_sensor
from tests.gap.small_captures import BLACK_DN, capture, placed, squares

FRAMES = 3
SCENARIO = {"illumination_lux": 500, "gain_db": 15, "exposure_ms": 10, "f_number": 2.0}
LUX_S = exposure_per_luminance(0.010, 2.0)

# A study's effects on light act on cd/m2, those of a diagnosis on DN. The two are the same bits where going
# from one to the other is exact: a power of two of DN per cd/m2, no pedestal or dark signal to round with.
DN_PER_LUMINANCE = 0.5
AFFINE = {"use": "sensor.affine-noise", "responsivity_dn_per_lux_s": DN_PER_LUMINANCE / LUX_S}
EMVA = {
    "use": "sensor.emva",
    "full_well_e": 20_000,
    "read_noise_e": 3,
    "dark_current_e_s": 0,
    "quantum_efficiency": 0.6,
    "bit_depth": 8,
}
EFFECTS: tuple[dict[str, Any], ...] = (
    {"use": "effect.lens"},
    {"use": "effect.vignetting", "k1": -0.3},
    {"use": "effect.defocus", "radius_px": 1.2},
    {"use": "effect.flicker", "depth": 0.1, "period_rows": 20.0},
    {"use": "effect.prnu", "sigma": 0.02},
    {"use": "effect.conversion-gain-mode", "from_db": 12.0, "noise_scale": 0.5},
    {"use": "effect.read-noise", "sigma_dn": 1.5, "after_gain_dn": 2.0},
    {"use": "effect.row-noise", "sigma_dn": 1.0},
    {"use": "effect.jpeg", "quality": 80},
)


def study(sensor: Mapping[str, Any], effects: tuple[dict[str, Any], ...], plugins: Plugins) -> Plan:
    described = {
        "name": "same bits",
        "seed": 3,
        "rig": {
            "use": "rig.monocular",
            "focal_length_mm": 0.4,
            "sensor": {"name": "small", "width_px": 64, "height_px": 48, "pixel_um": 3.0},
        },
        "design": {"pitch_deg": {"between": [-30, 30]}},
        "scenario": SCENARIO,
        "nodes": {
            "world": {"use": "scene.textured-target", "texture_px": 64, "frames": FRAMES, "speed_m_s": 0.1},
            "capture": {"use": "renderer.analytic", "in": {"episode": "world"}},
            NODE: {**sensor, "in": {"capture": "capture"}},
            "features": {"use": "task.orb-features", "in": {"frames": NODE}},
        },
        "effects": list(effects),
        "fitness": [{"score": "features.inliers", "weight": 1}],
        "optimizer": {"use": "optimizer.genetic"},
    }
    return make_plan(Recipe.model_validate(described), plugins)


def frames_of(plan: Plan, spec: EpisodeSpec) -> list[FrameBatch]:
    return list(Simulation(plan).batches("features", {"pitch_deg": 0.0}, spec))


def of_study(batches: list[FrameBatch], sensor: PlacedSensor) -> RealCapture:
    """What the diagnosis would be given of a study's episode: its expectation, without any effect."""
    views = [batch.capture.views[0] for batch in batches]
    camera = views[0].camera
    plain = RealCapture(
        id="study",
        kind="scene",
        real_dn=np.zeros((len(views), camera.height_px, camera.width_px, 3), np.float32),
        expected_dn=None,
        valid=np.ones((camera.height_px, camera.width_px), bool),
        geometry=ImageGeometry.of_camera(camera),
        context=ImageContext(
            exposure_s=0.010,
            gain_db=15,
            f_number=2.0,
            white_level_dn=255,
            depth_m=np.concatenate([view.depth_m for view in views]),
        ),
        noise=Noise((1.0,), (1.0,)),
    )
    light = np.concatenate([view.luminance_cd_m2 for view in views])
    expected = sensor_at(replace(plain, sensor=sensor)).expect(light)
    (simulated,) = with_sensor([replace(plain, expected_dn=expected)], sensor)
    return simulated


def exact_emva(plugins: Plugins) -> dict[str, Any]:
    """An electron model whose DN per cd/m2 is a power of two as well."""
    cls = plugins.resolve("sensor.emva")
    sensor = cls(cls.Config(**{key: value for key, value in EMVA.items() if key != "use"}))
    camera = Camera("camera", 64, 48, 3.0, 0.4)
    exposure = Exposure(0.010, 2.0, 15.0)
    per_luminance = sensor.electrons_per_luminance(camera, exposure)
    gain = DN_PER_LUMINANCE / per_luminance / exposure.gain
    return {**EMVA, "system_gain_dn_per_e": gain}


@pytest.mark.parametrize("name", ["affine", "emva"])
@pytest.mark.parametrize("count", [0, 1, 4, len(EFFECTS)])
def test_a_study_and_a_diagnosis_simulate_the_same_bits(name, count, plugins):
    sensor = AFFINE if name == "affine" else exact_emva(plugins)
    effects = EFFECTS[:count]
    spec = EpisodeSpec(11, ("design", 2), FRAMES)
    plan = study(sensor, effects, plugins)
    frames = np.concatenate([batch.images[0] for batch in frames_of(plan, spec)])
    part = plan.nodes[NODE]
    own = PlacedSensor(part.use, NODE, part.make())
    expected = of_study(frames_of(study(sensor, (), plugins), spec), own)
    same = [PlacedEffect(p.use, getattr(p, "name", "") or p.use, p.cls, p.config) for p in plan.effects]
    simulated = simulate(expected, same, EpisodeDraws(spec.seed, spec.name))
    assert frames.min() < 0.5 * frames.max() < 120, "levels apart, and nothing saturates"
    np.testing.assert_array_equal(simulated, frames.astype(np.float32))


MOTIONS: tuple[dict[str, Any], ...] = (
    {"use": "effect.motion"},
    {"use": "effect.motion", "shutter": "rolling", "row_time_us": 100.0},
)


@pytest.mark.parametrize("motion", MOTIONS, ids=["global", "rolling"])
@pytest.mark.parametrize("known", ["motion", "velocity_px_s"])
def test_motion_is_the_same_by_poses_and_but_for_rounding_by_velocities(motion, known, plugins):
    """A study knows poses, captures a velocity of each pixel; the first frame of both."""
    spec = EpisodeSpec(11, ("design", 2), FRAMES)
    plan = study(AFFINE, (motion, {"use": "effect.lens"}), plugins)
    files = frames_of(plan, spec)[0].images[0].astype(np.float32)
    still = frames_of(study(AFFINE, (), plugins), spec)[:1]
    part = plan.nodes[NODE]
    expected = of_study(still, PlacedSensor(part.use, NODE, part.make()))
    of_view = light_context(still[0].capture.views[0], still[0].capture.episode, Exposure(0.010, 2.0, 15.0))
    moving = replace(
        expected.context, reference_row=of_view.reference_row, **{known: getattr(of_view, known)}
    )
    if known == "velocity_px_s":
        moving = replace(moving, velocity_px_s=moving.known_velocity_px_s("effect.motion"))
    same = [PlacedEffect(p.use, getattr(p, "name", "") or p.use, p.cls, p.config) for p in plan.effects]
    simulated = simulate(replace(expected, context=moving), same, EpisodeDraws(spec.seed, spec.name))
    assert np.abs(simulated - files).max() <= (0 if known == "motion" else 1)
    assert (simulated != files).mean() < 1e-3
    unmoved = simulate(expected, same[1:], EpisodeDraws(spec.seed, spec.name))
    assert np.abs(unmoved - files).max() > 3


# frames of a still ----------------------------------------------------------------------------------------


class Wavering:
    """Brightens light by what it draws, or by how many frames it has seen."""

    class Config(Settings):
        draws: float = setting(0.0, help="How much it draws.")
        remembers: float = setting(0.0, help="How much each frame adds.")

    stage: ClassVar[Stage] = "optics"
    neutral: ClassVar[Mapping[str, Any]] = {"draws": 0.0, "remembers": 0.0}
    calls: ClassVar[list[int]] = []

    def __init__(self, config: Config) -> None:
        self.config = config

    def on_array(self, samples, *, geometry, context, rng):
        self.calls.append(len(samples))
        factor = 1.0
        if self.config.draws:
            factor += self.config.draws * rng.random()
        if self.config.remembers:
            context.memory["seen"] = context.memory.get("seen", 0) + 1
            factor += self.config.remembers * context.memory["seen"]
        return samples * np.float32(factor)


@pytest.mark.parametrize(
    ("settings", "calls"),
    [({}, 1), ({"draws": 0.2}, 1 + FRAMES), ({"remembers": 0.1}, 1 + FRAMES)],
)
def test_frames_of_a_still_share_what_is_the_same_for_all_of_them(settings, calls, plugins):
    still = capture("edges", "edge", squares(), frames=FRAMES)
    alike = replace(still, expected_dn=np.repeat(still.expected_dn, FRAMES, axis=0))
    effects = [
        placed("wavering", Wavering, **settings),
        placed("vignetting", plugins.resolve("effect.vignetting"), k1=-0.2),
        placed("dsnu", plugins.resolve("effect.dsnu"), sigma_dn=2.0),
        placed("jpeg", plugins.resolve("effect.jpeg"), quality=70),
    ]
    Wavering.calls.clear()
    shared = simulate(still, effects, EpisodeDraws(5, ("a",)))
    assert len(Wavering.calls) == calls
    np.testing.assert_array_equal(shared, simulate(alike, effects, EpisodeDraws(5, ("a",))))
    if settings:
        levels = shared.mean(axis=(1, 2, 3))
        assert np.ptp(levels) > 1
        if "remembers" in settings:
            assert (np.diff(levels) > 3).all()


def test_nothing_is_remembered_from_one_simulation_to_the_next():
    still = capture("flat", "flat", BLACK_DN + 50, frames=FRAMES)
    effects, draws = [placed("wavering", Wavering, remembers=0.1)], EpisodeDraws(5, ("a",))
    np.testing.assert_array_equal(simulate(still, effects, draws), simulate(still, effects, draws))


def test_an_effect_that_needs_what_is_not_known_is_left_out(plugins):
    still = capture("edges", "edge", squares())
    shutter = placed("rolling-shutter", plugins.resolve("effect.rolling-shutter"), row_time_us=50.0)
    draws = EpisodeDraws(5, ("a",))
    np.testing.assert_array_equal(simulate(still, [shutter], draws), simulate(still, [], draws))
