"""Noise that captures at two gains tell apart is withheld, and found with its value."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tacos_framework.plugins import Plugins
from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.answer.transfer import patch
from tacos_gap.captures import read_captures
from tacos_gap.hypotheses.candidates import candidates
from tacos_validation.blind.generators.acquisitions import new_camera, two_gains
from tacos_validation.blind.generators.folders import write_folder
from tacos_validation.blind.generators.injected_effect import InjectedEffect
from tacos_validation.blind.generators.sensor_effects import InjectedConversionGainMode, InjectedReadNoise

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("withheld", "parameter", "absent"),
    [
        (InjectedReadNoise(sigma_dn=2.0), "sigma_dn", "after_gain_dn"),
        (InjectedReadNoise(after_gain_dn=3.0), "after_gain_dn", "sigma_dn"),
        (InjectedConversionGainMode(noise_scale=0.5, from_db=6.0), "noise_scale", ""),
    ],
)
def test_noise_before_and_after_the_gain_and_a_mode_are_told_apart(
    withheld: InjectedEffect, parameter: str, absent: str, tmp_path: Path
) -> None:
    rng = np.random.default_rng(7)
    camera = new_camera(rng, 160, 120, 1)
    write_folder(tmp_path / "captures", camera, two_gains(camera, rng), [withheld], rng, sensor_seed=3)
    found = diagnose(read_captures(tmp_path / "captures"), candidates(Plugins.discover()).effects, seed=0)
    assert [cause.effect for cause in found.causes] == [withheld.name]
    (cause,) = found.causes
    value = cause.parameters[parameter]
    assert value.interval is not None
    assert value.interval[0] <= getattr(withheld, parameter) <= value.interval[1], value
    assert cause.settings.get(absent, 0.0) == 0.0
    assert patch([cause])[0]["use"] == f"effect.{withheld.name}"
