"""Effects in a recipe: each acts at its place, whatever the order in the file."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
import yaml
from toy_study import run, toy_recipe

from tacos_framework.cli import run_main
from tacos_framework.contracts import acts_after_noise, formation_order
from tacos_framework.plugins import Plugins

RECIPE = """\
tacos: 1
name: every stage
seed: 7
rig: {use: rig.monocular, sensor: {name: tiny, width_px: 96, height_px: 72, pixel_um: 30}}
design: {focal_length_mm: {between: [1.5, 3]}}
nodes:
  world: {use: scene.indoor, frames: 2, size_m: [11, 6]}
  capture: {use: renderer.analytic, in: {episode: world}}
  frames: {use: sensor.affine-noise, in: {capture: capture}, black_level_dn: 16}
  features: {use: task.orb-features, in: {frames: frames}, fast_threshold: 5}
fitness: [{score: features.inliers, weight: 1}]
optimizer: {use: optimizer.random, evaluations: 1}
"""
EFFECTS = """\
- {use: effect.jpeg, quality: 90}
- {use: effect.tone-curve, gamma: 0.45}
- {use: effect.demosaic, method: bilinear}
- {use: effect.white-balance, red: 1.5, blue: 1.3}
- {use: effect.quantisation, step_dn: 2}
- {use: effect.row-noise, sigma_dn: 0.5}
- {use: effect.crosstalk, share: 0.02}
- {use: effect.saturation, level_dn: 240}
- {use: effect.conversion-gain-error, scale: 1.2}
- {use: effect.dark-current, rate_dn_s: 20, hot_share: 0.001}
- {use: effect.prnu, sigma: 0.01}
- {use: effect.vignetting, k1: -0.3}
"""
FORMATION = """\
Image formation
  scene: -
  optics: effect.vignetting
  exposure: -
  pixel: effect.prnu, effect.dark-current, effect.conversion-gain-error
  (noise)
  pixel, after the noise: effect.saturation, effect.crosstalk
  readout: effect.row-noise, effect.quantisation
  isp: effect.white-balance, effect.demosaic, effect.tone-curve
  codec: effect.jpeg
"""


@pytest.fixture
def recipe(tmp_path: Path) -> Path:
    path = tmp_path / "every_stage.yaml"
    path.write_text(RECIPE)
    (tmp_path / "effects.yaml").write_text(EFFECTS)
    return path


def test_explain_shows_where_each_effect_acts(recipe, capsys):
    assert run_main([str(recipe), "--explain", "--with", str(recipe.parent / "effects.yaml")]) == 0
    assert FORMATION in capsys.readouterr().out


def test_set_can_list_effects(recipe, capsys):
    assert run_main([str(recipe), "--explain", "--set", "effects=[{use: effect.denoise, strength: 1}]"]) == 0
    assert "isp: effect.denoise" in capsys.readouterr().out


def brightness(toys: Plugins, out: Path, effects: list[dict[str, Any]]) -> float:
    """Mean of the frames of the best camera of a study with effects [DN]."""
    frames = {"use": "sensor.affine-noise", "in": {"capture": "capture"}, "black_level_dn": 16}
    recipe = toy_recipe(nodes={"frames": frames}, effects=effects, optimizer={"generations": 1})
    return run(recipe, toys, out)["test"]["designed"]["width.brightness"]


def test_a_study_runs_with_effects_of_every_stage(toys, tmp_path):
    plain = brightness(toys, tmp_path / "plain", [])
    every = brightness(toys, tmp_path / "every", yaml.safe_load(EFFECTS))
    assert every > plain + 10  # brightened most by the tone curve


def test_effects_act_in_the_order_of_image_formation_not_of_the_list(toys, tmp_path):
    listed = [{"use": "effect.tone-curve", "gamma": 0.45}, {"use": "effect.black-level", "offset_dn": 10}]
    one, other = (
        brightness(toys, tmp_path / name, effects) for name, effects in (("a", listed), ("b", listed[::-1]))
    )
    assert one == other


def test_a_wrong_setting_of_an_effect_is_named(recipe, capsys):
    assert run_main([str(recipe), "--check", "--set", "effects=[{use: effect.jpeg, quality: 0}]"]) == 2
    assert "quality" in capsys.readouterr().err


def test_effects_that_correlate_noise_come_after_it_and_no_two_contend_for_a_place():
    offered = [registered.component for registered in Plugins.discover()]
    effects = {
        c.name: c.load() for c in offered if c.kind == "effect" and c.target.startswith("tacos_plugins.")
    }
    late = {name for name, cls in effects.items() if cls.stage == "pixel" and acts_after_noise(cls)}
    assert late == {"crosstalk", "saturation"}
    behind_light = [cls for cls in effects.values() if formation_order(cls)[0] >= 3]
    ordered = sorted(behind_light, key=formation_order)
    assert all(formation_order(first) < formation_order(second) for first, second in pairwise(ordered))
