"""Responses and the light of pixels, from exposure times alone."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_gap.captures.targets.response import fit_response

DATA = Path(__file__).parents[5] / "shared" / "data" / "real"
TIMES_S = (0.05, 0.2, 0.8)


def codes_of(curve, level=1.0, noise_dn=1.0):
    """Codes of 20,000 pixels, log-uniform in light, at three times; clipped at `level`."""
    rng = np.random.default_rng(0)
    light = 10 ** rng.uniform(-3, 1, 20_000)
    signals = [curve(np.minimum(light * time_s, level)) * 255 for time_s in TIMES_S]
    return [np.clip(np.rint(s + rng.normal(0, noise_dn, s.size)), 0, 255) / 255 for s in signals]


def fitted(codes, below=0.97):
    return fit_response(codes, TIMES_S, [(code < below) & (code > 0) for code in codes])


@settings(max_examples=10, deadline=None)
@given(st.floats(0.4, 0.85))
def test_a_power_is_found_from_the_times(gamma):
    response = fitted(codes_of(lambda x: x**gamma))
    light = np.array([0.05, 0.1, 0.3, 0.6, 0.9])
    assert response.light_of(light**gamma) == pytest.approx(light, rel=0.03)
    assert not response.linear


def test_the_curve_of_a_display_is_found():
    response = fitted(codes_of(lambda x: np.where(x < 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)))
    code = np.array([0.2, 0.4, 0.6, 0.8])
    assert response.light_of(code) == pytest.approx(((code + 0.055) / 1.055) ** 2.4, rel=0.05)


@pytest.mark.parametrize("level", [1.0, 0.7])
def test_a_linear_camera_is_left_exactly_linear(level):
    response = fitted(codes_of(lambda x: x, level), below=0.97 * level)
    assert response.linear
    assert response.light_of(np.array([0.01, 0.5, 1.0])).tolist() == pytest.approx([0.01, 0.5, 1.0])


def test_too_few_pixels_say_nothing():
    assert fit_response([np.full(3, 0.1), np.full(3, 0.2)], (1, 2), [np.ones(3, bool)] * 2).linear


@pytest.mark.skipif(not DATA.is_dir(), reason=f"the real captures are not at {DATA}")
def test_a_processed_bracket_obeys_its_times():
    files = [DATA / "bracket_5d2" / f"IMG_260{k}.jpg" for k in range(3)]
    codes = [cv2.imread(str(file))[::3, ::3].ravel() / 255 for file in files]
    times_s = (0.125, 1.0, 8.0)
    usable = [(code < 0.97) & (code > 0.02) for code in codes]
    response = fit_response(codes, times_s, usable)
    assert not response.linear
    for k in range(2):
        both = usable[k] & usable[k + 1]
        ratio = response.light_of(codes[k + 1][both]) / response.light_of(codes[k][both])
        assert np.median(ratio) == pytest.approx(8, rel=0.1)
        assert np.median(codes[k + 1][both] / codes[k][both]) < 6
