"""Sensors of a diagnosis: the noise of captures.yaml, and components in its place."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tacos_framework import ProcedureRecipe, run
from tacos_framework.errors import UserError
from tacos_framework.formation import EpisodeDraws, PlacedSensor
from tacos_framework.plugins import Plugins
from tacos_gap.captures import Noise, RealCapture
from tacos_gap.captures.writer import write_captures
from tacos_gap.simulation.formation import simulate
from tacos_gap.simulation.sensors import NODE, CapturedNoise, response_of, sensor_at, with_sensor
from tests.gap.small_captures import BLACK_DN, bench, capture
from tests.gap.taken import capture as shown
from tests.gap.taken import effect, patchwork, taken

EMVA = {
    "use": "sensor.emva",
    "channels": "mono",
    "quantum_efficiency": 0.6,
    "full_well_e": 4000,
    "read_noise_e": 30,
    "dark_current_e_s": 400,
    "bit_depth": 8,
    "black_level_dn": 16,
}
GAIN = 239 / 4000


def emva(plugins: Plugins, **changes: Any) -> PlacedSensor:
    cls = plugins.resolve("sensor.emva")
    settings = {key: value for key, value in EMVA.items() if key != "use"}
    return PlacedSensor("sensor.emva", NODE, cls(cls.Config(**{**settings, **changes})))


def test_the_noise_of_captures_yaml_is_a_sensor():
    flat = capture("flat", "flat", BLACK_DN + 100, frames=40)
    sensor = sensor_at(flat)
    assert isinstance(sensor.sensor, CapturedNoise)
    assert sensor.expect(np.full((1, 1, 1, 1), 100.0, np.float32)) == pytest.approx(116.0)
    assert sensor.context.dn_per_electron == pytest.approx(0.24)
    noise, dark_dn = response_of(sensor, 1)
    assert (noise.photon_dn, noise.thermal_dn2) == (pytest.approx((0.24,)), pytest.approx((1.8,)))
    assert dark_dn == 0
    frames = simulate(flat, [], EpisodeDraws(1, ("a",)))
    assert frames.var() == pytest.approx(0.24 * 100 + 1.8 + 1 / 12, rel=0.02)
    colour = sensor_at(replace(flat, noise=Noise((0.1, 0.2, 0.3), (1.0, 1.0, 1.0))))
    assert colour.context.dn_per_electron == pytest.approx(0.2), "that of green"


def test_a_sensor_component_draws_the_noise_about_what_is_expected(plugins):
    dark, flat = (capture(kind, kind, level, frames=30) for kind, level in (("dark", 40.0), ("flat", 136.0)))
    for each in with_sensor([dark, flat], emva(plugins)):
        assert each.noise.photon_dn == pytest.approx((GAIN,), rel=1e-3)
        frames = simulate(each, [], EpisodeDraws(1, ("a",)))
        expected = float(each.expected_dn.mean())
        assert frames.mean() == pytest.approx(expected, abs=0.03), "the dark signal is in what is expected"
        variance = GAIN * (expected - 16) + (30 * GAIN) ** 2 + 1 / 12
        assert frames.var() == pytest.approx(variance, rel=0.02)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"black_level_dn": 0.0}, "sensor.emva has a black_level_dn of 0.*expected 16"),
        ({"bit_depth": 10}, "sensor.emva has a white_level_dn of 1023.*expected 255"),
        ({"channels": "rgb"}, "sensor.emva gives 3 channels.*expected 1"),
        ({"quantum_efficiency": None}, "does not know quantum_efficiency"),
    ],
)
def test_a_sensor_that_does_not_fit_the_files_is_refused(changes, said, plugins):
    with pytest.raises(UserError) as refused:
        with_sensor(bench(), emva(plugins, **changes))
    assert_said(str(refused.value), said)


def assert_said(text: str, said: str) -> None:
    first, _, second = said.partition(".*expected ")
    assert first in text
    assert second in text


def diagnosed(captures: list[RealCapture], plugins: Plugins, folder: Path, **settings: Any) -> dict[str, Any]:
    write_captures(folder / "captures", captures)
    recipe = ProcedureRecipe("procedure.diagnose", {"captures": str(folder / "captures"), **settings})
    run(recipe, out=folder / "out", plugins=plugins)
    found: dict[str, Any] = json.loads((folder / "out" / "diagnosis.json").read_text("utf-8"))
    return found


@pytest.mark.parametrize("name", ["emva", "affine-noise"])
def test_a_diagnosis_runs_with_a_sensor_component(name, plugins, tmp_path):
    affine = {"use": "sensor.affine-noise", "black_level_dn": 16, "calibration": "flea3_imx172"}
    channels = 1 if name == "emva" else 3
    sensor = EMVA if name == "emva" else affine
    cls = plugins.resolve(sensor["use"])
    config = cls.Config(**{key: value for key, value in sensor.items() if key != "use"})
    own = PlacedSensor(sensor["use"], NODE, cls(config))
    plain = [shown("dark", 8.0, channels=channels), shown("flat", 120.0, channels=channels)]
    plain.append(shown("scene", patchwork(), channels=channels))
    captures = taken(with_sensor(plain, own), [effect(plugins, "vignetting", k1=-0.3)])
    found = diagnosed([replace(c, sensor=None) for c in captures], plugins, tmp_path, sensor=sensor)
    assert [cause["effect"] for cause in found["causes"]] == ["vignetting"]
    k1 = found["causes"][0]["parameters"]["k1"]
    assert k1["value"] == pytest.approx(-0.3, abs=0.02)
