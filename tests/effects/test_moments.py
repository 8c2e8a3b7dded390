"""The closed forms of mean and variance agree with what samples do."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_plugins.effects.black_level import BlackLevel
from tacos_plugins.effects.colour_matrix import ColourMatrix
from tacos_plugins.effects.crosstalk import Crosstalk
from tacos_plugins.effects.dark_current import DarkCurrent
from tacos_plugins.effects.dsnu import Dsnu
from tacos_plugins.effects.lens_shading_correction import LensShadingCorrection
from tacos_plugins.effects.nonlinearity import Nonlinearity
from tacos_plugins.effects.prnu import Prnu
from tacos_plugins.effects.quantisation import Quantisation
from tacos_plugins.effects.read_noise import ReadNoise
from tacos_plugins.effects.row_noise import RowNoise
from tacos_plugins.effects.saturation import Saturation, cut_off_moments
from tacos_plugins.effects.sharpening import Sharpening
from tacos_plugins.effects.tone_curve import ToneCurve
from tacos_plugins.effects.white_balance import WhiteBalance
from tests.effects.sample_arrays import flats, make, moments, run

FRAMES = 4000
LEVELS_DN = np.array([[[[20.0, 60.0, 100.0]], [[100.0, 150.0, 210.0]]]])  # two rows of one pixel
SIGMA_DN = 3.0

EFFECTS = {
    "black-level": make(BlackLevel, offset_dn=2.5),
    "colour-matrix": make(ColourMatrix, matrix=((1.6, -0.4, -0.2), (-0.3, 1.5, -0.2), (0.0, -0.6, 1.6))),
    "dark-current": make(DarkCurrent, rate_dn_s=100.0, hot_share=0.5),
    "dsnu": make(Dsnu, sigma_dn=2.0, column_sigma_dn=1.0),
    "lens-shading-correction": make(LensShadingCorrection, k1=0.8, k2=0.3),
    "nonlinearity": make(Nonlinearity, a2=-0.2, a3=0.05),
    "prnu": make(Prnu, sigma=0.1),
    "read-noise": make(ReadNoise, sigma_dn=2.0),
    "read-noise, heavy tails": make(ReadNoise, sigma_dn=2.0, tail=0.15),
    "row-noise": make(RowNoise, sigma_dn=1.0, column_sigma_dn=2.0),
    "saturation": make(Saturation, level_dn=102.0),
    "tone curve, gamma": make(ToneCurve, gamma=0.45),
    "tone curve, knots": make(ToneCurve, knots=((0, 0), (0.25, 0.5), (0.6, 0.8), (1, 1))),
    "white-balance": make(WhiteBalance, red=1.8, blue=0.7),
}
MIXING = {
    "crosstalk": make(Crosstalk, share=0.03),
    "sharpening": make(Sharpening, amount=1.0, radius_px=0.8),
}
"""Effects that mix neighbours; mirrored at the edges, the same noise counts twice there."""
EDGE_PX = 5


@pytest.mark.parametrize("name", EFFECTS)
def test_moments_are_those_of_many_frames(name):
    effect = EFFECTS[name]
    frames = flats(LEVELS_DN, SIGMA_DN, frames=FRAMES, height=2, width=6)
    mean = np.broadcast_to(LEVELS_DN, frames[:1].shape)
    expected_mean, expected_variance = moments(effect, mean, np.full(mean.shape, SIGMA_DN**2), frames)
    seen = run(effect, frames)
    spread = np.sqrt(np.broadcast_to(expected_variance, mean.shape))
    error_of_mean = np.abs(seen.mean(axis=0) - expected_mean) / np.maximum(spread, 1e-3) * np.sqrt(FRAMES)
    assert error_of_mean.max() < 4.5  # standard errors; 36 means
    # The relative standard error of a variance of n Gaussian samples is sqrt(2 / n), 2.2 % here.
    np.testing.assert_allclose(
        seen.var(axis=0), np.broadcast_to(expected_variance, mean.shape)[0], rtol=0.12, atol=1e-9
    )


@pytest.mark.parametrize("name", MIXING)
def test_moments_of_mixed_noise_are_those_within_a_large_image(name):
    frames = flats(100.0, SIGMA_DN, height=150, width=150)
    mean, variance = moments(MIXING[name], np.full((1, 1, 1, 3), 100.0), np.full((1, 1, 1, 3), 9.0), frames)
    seen = run(MIXING[name], frames)[:, EDGE_PX:-EDGE_PX, EDGE_PX:-EDGE_PX]
    np.testing.assert_allclose(seen.mean(), mean.mean(), atol=0.05)
    np.testing.assert_allclose(seen.var(axis=(0, 1, 2)), variance[0, 0, 0], rtol=0.03)


@pytest.mark.parametrize("name", [*EFFECTS, *MIXING])
def test_moments_take_flat_fields(name):
    images = flats(frames=3, height=5, width=6)
    levels = np.array([50.0, 100.0, 150.0]).reshape(3, 1, 1, 1) * np.ones(3)
    effect = {**EFFECTS, **MIXING}[name]
    mean, variance = moments(effect, levels, np.full_like(levels, 4.0), images)
    assert np.broadcast_shapes(mean.shape, images.shape) == images.shape
    assert np.broadcast_shapes(variance.shape, images.shape) == images.shape


@pytest.mark.parametrize(
    "effect",
    [
        make(Quantisation, step_dn=8.0),
        make(Quantisation, step_dn=8.0, rounding="floor"),
        make(Quantisation, step_dn=18.0),
        make(Crosstalk, share=0.03),
        make(DarkCurrent, rate_dn_s=100.0, hot_share=0.5),
    ],
    ids=["quantisation", "rounding down", "quantisation to a comb", "crosstalk", "dark-current"],
)
def test_moments_are_those_of_binned_pixels(effect):
    frames = flats(100.0, SIGMA_DN, height=100, width=100, frames=40)
    flat = np.full((1, 100, 100, 3), 100.0)
    mean, variance = moments(effect, flat, np.full(flat.shape, SIGMA_DN**2), frames, binning=3.0)
    seen = np.rint(run(effect, frames, binning=3.0))
    inside = np.s_[EDGE_PX:-EDGE_PX, EDGE_PX:-EDGE_PX]
    temporal = seen.var(axis=0, ddof=1)[inside].mean() - 1 / 12  # that of rounding
    np.testing.assert_allclose(seen.mean(axis=0)[inside].mean(), mean[0][inside].mean(), atol=0.05)
    np.testing.assert_allclose(temporal, np.broadcast_to(variance, flat.shape)[0][inside].mean(), rtol=0.02)


def test_far_below_the_level_nothing_is_cut_off_and_far_above_nothing_is_left():
    mean, variance = cut_off_moments([50.0, 100.0, 150.0, 200.0], [4.0, 0.0, 0.0, 4.0], 120.0)
    np.testing.assert_allclose(mean, [50, 100, 120, 120], atol=1e-12)
    np.testing.assert_allclose(variance, [4, 0, 0, 0], atol=1e-9)
