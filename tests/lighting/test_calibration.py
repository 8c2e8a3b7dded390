"""Emitters, and scaling light to lux."""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest

from tacos_plugins.lighting import (
    emitter_luminance_cd_m2,
    irradiance_at,
    photopic,
    scale_light,
    white_at,
    with_illuminance,
)
from tests.lighting.boxes import ceiling, panel_light, world_of


def plane() -> np.ndarray:
    x, y = np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 9))
    return np.column_stack([x.ravel(), y.ravel(), np.ones(81)]).astype(np.float32)


@pytest.mark.parametrize("lux", [2.0, 20.0, 500.0])
def test_the_plane_gets_the_illuminance_asked_for(lux: float) -> None:
    lamp = panel_light(0.3, 0.3, 2.4, 900.0)
    lit = with_illuminance(world_of(ceiling(3, 2.5), 0.7, (lamp,)), lux, plane(), key="lit")
    up = np.tile(np.array([0, 0, 1], np.float32), (81, 1))
    assert photopic(irradiance_at(lit, plane(), up)).mean() == pytest.approx(lux, rel=1e-3)
    assert lit.key == "lit"
    assert lit.indirect_lux is not None


def test_scaling_multiplies_every_kind_of_light() -> None:
    lamp = panel_light(0.3, 0.3, 2.4, 900.0)
    lit = with_illuminance(world_of(ceiling(3, 2.5), 0.7, (lamp,)), 10.0, plane(), key="lit")
    double = scale_light(lit, 2.0, key="double")
    assert double.lights[0].flux_lm == pytest.approx(2 * lit.lights[0].flux_lm)
    assert double.indirect_lux is not None
    assert lit.indirect_lux is not None
    assert double.indirect_lux[0] == pytest.approx(2 * lit.indirect_lux[0])


def test_a_world_without_light_cannot_be_calibrated() -> None:
    with pytest.raises(ValueError, match="no light reaches the plane"):
        with_illuminance(world_of(ceiling(3, 2.5)), 20.0, plane(), key="dark")


def test_white_of_6504_k_has_equal_channels_and_luminance_one() -> None:
    assert white_at(6504) == pytest.approx(np.ones(3), abs=0.01)
    for temperature_k in (2700, 4000, 10000):
        assert photopic(white_at(temperature_k)) == pytest.approx(1.0)
    assert white_at(3000)[0] > 1.5 > 0.4 > white_at(3000)[2]


@pytest.mark.parametrize("temperature_k", [1667, 2222, 2223, 3999, 4000, 7000, 7001, 25000])
def test_white_is_that_of_colour_science(temperature_k: float) -> None:
    colour = pytest.importorskip("colour")
    method = "CIE Illuminant D Series" if temperature_k >= 4000 else "Kang 2002"
    xy = colour.CCT_to_xy(temperature_k, method=method)
    linear = np.maximum(colour.XYZ_to_RGB(colour.xy_to_XYZ(xy), "sRGB"), 0.0)
    assert white_at(temperature_k) == pytest.approx(linear / photopic(linear), rel=1e-12)


def test_colour_temperature_out_of_range_says_the_range() -> None:
    with pytest.raises(ValueError, match="from 1667 to 25000 K, not 900"):
        white_at(900)


def test_luminance_of_a_lambertian_emitter() -> None:
    assert emitter_luminance_cd_m2(np.full(3, math.pi), 0.5) == pytest.approx([2.0] * 3)
    with pytest.raises(ValueError, match="area above 0"):
        emitter_luminance_cd_m2(np.ones(3), 0.0)


def test_importing_the_package_leaves_colour_science_alone() -> None:
    code = "import sys, tacos_plugins.lighting; sys.exit('colour' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
