"""The exponent that the greys of a chart tell, with charts of numpy's own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tacos_gap.captures import RealCapture
from tacos_plugins.effects.chart_greys import exponent_of
from tacos_plugins.effects.tone_curve import ToneCurve
from tests.gap.taken import BLACK_DN, capture

GREYS = np.array([0.9, 0.59, 0.36, 0.2, 0.09, 0.03])
COLOURS = np.array([[0.4, 0.1, 0.06], [0.1, 0.3, 0.1], [0.05, 0.1, 0.35], [0.6, 0.5, 0.05]])
REFLECTANCES = np.vstack([COLOURS, np.repeat(GREYS[:, np.newaxis], 3, axis=1)])
LIGHT = np.array([0.7, 1.0, 0.5])
SIDE_PX = 6
SPAN_DN = 255.0 - BLACK_DN


def chart(codes: np.ndarray, seed: int = 0) -> RealCapture:
    """A row of patches of codes over full scale, with noise of one code."""
    row_dn = BLACK_DN + SPAN_DN * np.clip(codes, 0, 1)
    picture = np.repeat(np.repeat(row_dn[np.newaxis], SIDE_PX, axis=0), SIDE_PX, axis=1)
    noisy = np.rint(picture + np.random.default_rng(seed).normal(0, 1, picture.shape))
    boxes = np.array([[k * SIDE_PX, 0, SIDE_PX, SIDE_PX] for k in range(len(codes))])
    expected_dn = BLACK_DN + SPAN_DN * REFLECTANCES * LIGHT
    real_dn = np.clip(noisy, 0, 255).astype(np.float32)[np.newaxis]
    return replace(capture("chart", 100.0), real_dn=real_dn, patches=(boxes, expected_dn))


def srgb(light: np.ndarray) -> np.ndarray:
    """IEC 61966-2-1."""
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize("veil", [0.0, 0.05])
def test_the_curve_of_files_for_a_display_is_seen_through_a_veil_of_light(veil):
    mixed = np.array([[0.7, 0.2, 0.1], [0.25, 0.5, 0.25], [0.05, 0.15, 0.8]])  # keeps greys
    seen = (REFLECTANCES @ mixed.T) * LIGHT * 0.9 + veil
    found = exponent_of(chart(srgb(seen)))
    assert found is not None
    assert found.value == pytest.approx(1 / 2.2, abs=0.04)
    (estimate,) = ToneCurve.estimate_from([chart(srgb(seen))])
    assert estimate.is_seen(1.0)


@pytest.mark.parametrize("veil", [0.0, 0.05, 0.3])
def test_greys_of_a_linear_camera_tell_no_curve_however_much_is_added(veil):
    assert list(ToneCurve.estimate_from([chart(REFLECTANCES * LIGHT * 0.6 + veil)])) == []


@pytest.mark.parametrize("exponent", [0.85, 1.08, 1.15])
def test_a_slight_curve_is_neither_seen_nor_excluded(exponent):
    assert list(ToneCurve.estimate_from([chart((REFLECTANCES * LIGHT) ** exponent)])) == []


def test_too_few_greys_and_charts_without_colour_tell_nothing():
    clipped = srgb(REFLECTANCES * 3.0)
    assert exponent_of(chart(clipped)) is None
    grey = chart(srgb(REFLECTANCES * LIGHT))
    assert exponent_of(replace(grey, real_dn=grey.real_dn[..., :1])) is None
