"""Lamps that flicker, on walls taken by a camera of another make."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tacos_framework import Plugins
from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.captures import CaptureFolder, Noise, RealCapture
from tacos_gap.hypotheses.candidates import candidates
from tests.gap.small_captures import BLACK_DN, HEIGHT, WIDTH, capture

GAIN_DN, READ_DN = 0.05, 0.9
DEPTH, PERIOD_ROWS = 0.05, 43.0


def wall(level_dn: float, name: str, rng: np.random.Generator) -> RealCapture:
    """Two frames of electrons, counted; each meets the lamp at a phase of its own."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    fall_off = 1 - 0.25 * np.hypot(rows - HEIGHT / 2, columns - WIDTH / 2) ** 2 / 1e4
    frames = []
    for phase in rng.uniform(0, 2 * np.pi, 2):
        lamp = 1 + DEPTH * np.sin(2 * np.pi * rows / PERIOD_ROWS + phase)
        electrons = rng.poisson(level_dn * fall_off * lamp / GAIN_DN)
        frames.append(GAIN_DN * electrons + rng.normal(0, READ_DN, rows.shape) + BLACK_DN)
    shown = np.clip(np.round(np.stack(frames)), 0, 255).astype(np.float32)[..., None]
    noise = Noise((GAIN_DN,), (READ_DN**2 + 1 / 12,))
    return replace(capture(name, "flat", BLACK_DN + level_dn), real_dn=shown, noise=noise)


@pytest.mark.parametrize("seed", [2, 3])
def test_a_lamp_is_named_with_its_depth_and_period_beside_the_lens(seed):
    rng = np.random.default_rng(seed)
    walls = tuple(wall(level, f"wall_{level}", rng) for level in (40, 90, 160))
    found = diagnose(CaptureFolder(Path("captures"), walls), candidates(Plugins.discover()))
    causes = {cause.effect: cause for cause in found.causes}
    assert found.verdict == "explained"
    assert set(causes) == {"flicker", "vignetting"}
    lamp = causes["flicker"]
    assert lamp.present > 0.9
    assert lamp.parameters["depth"].value == pytest.approx(DEPTH, rel=0.2)
    assert lamp.parameters["period_rows"].value == pytest.approx(PERIOD_ROWS, rel=0.15)
