"""Levels at which files end."""

from __future__ import annotations

from pathlib import Path

import pytest

from tacos_framework.plugins import Plugins
from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.captures import CaptureFolder
from tests.gap.small_captures import BLACK_DN, capture, placed, taken


@pytest.mark.parametrize("level_dn", [180.45, 179.55])
def test_a_level_is_known_to_the_code_that_files_round_it_to(level_dn):
    """No noise is left above a level, and none tells where between two codes it lies."""
    saturation = Plugins.discover().resolve("effect.saturation")
    flats = [capture(f"flat_{light}", "flat", BLACK_DN + light) for light in (40, 120, 165, 200)]
    full = taken(flats, [placed("saturation", saturation, level_dn=level_dn)])
    found = diagnose(CaptureFolder(Path("captures"), tuple(full)), {"saturation": saturation}, seed=3)
    level = found.causes[0].parameters["level_dn"]
    low, high = level.interval
    assert low <= level_dn <= high
    assert high - low >= 1.0
