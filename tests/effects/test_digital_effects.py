"""Nonlinearity, black level, quantisation, and the camera's own processing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy import ndimage, signal

from tacos_framework.testing.forming import placed, with_effect
from tacos_framework.testing.samples import sample_frames
from tacos_framework.values import ContextMissing, FrameBatch
from tacos_plugins.effects.black_level import BlackLevel
from tacos_plugins.effects.colour_matrix import ColourMatrix
from tacos_plugins.effects.denoise import Denoise, noise_of_levels
from tacos_plugins.effects.lens_shading_correction import LensShadingCorrection
from tacos_plugins.effects.nonlinearity import Nonlinearity
from tacos_plugins.effects.quantisation import Quantisation
from tacos_plugins.effects.sharpening import Sharpening
from tacos_plugins.effects.tone_curve import ToneCurve
from tacos_plugins.effects.white_balance import WhiteBalance
from tests.effects.sample_arrays import BLACK_DN, WHITE_DN, flats, make, neighbour_correlation, run
from tests.gap.taken import capture

FULL_SCALE_DN = WHITE_DN - BLACK_DN
RAMP_DN = np.linspace(BLACK_DN, WHITE_DN, 240).reshape(1, 1, -1, 1)
SCENE_DN = np.random.default_rng(6).uniform(20, 240, (2, 30, 40, 3))


def test_nonlinearity_is_a_polynomial_of_the_signal_over_full_scale():
    y = (RAMP_DN - BLACK_DN) / FULL_SCALE_DN
    expected = BLACK_DN + FULL_SCALE_DN * np.polyval([0.05, -0.2, 1, 0], y)
    np.testing.assert_allclose(run(make(Nonlinearity, a2=-0.2, a3=0.05), RAMP_DN), expected, rtol=1e-12)


def test_a_black_level_shifts_every_sample_alike():
    np.testing.assert_allclose(run(make(BlackLevel, offset_dn=-2.5), SCENE_DN), SCENE_DN - 2.5)


def test_quantisation_leaves_a_comb():
    codes = np.unique(run(make(Quantisation, step_dn=4.0), SCENE_DN))
    assert set(codes % 4) == {0.0}
    error = run(make(Quantisation, step_dn=4.0), SCENE_DN) - SCENE_DN
    assert np.abs(error).max() <= 2
    assert error.var() == pytest.approx(16 / 12, rel=0.05)


@pytest.mark.parametrize(
    ("table", "step_dn"),
    [
        (np.arange(64) * 4, 4.0),  # six bits of eight, shifted up
        (np.arange(64) * 4 + np.arange(64) // 16, 255 / 63),  # ... their highest repeated below, as GPUs do
        (np.rint(np.arange(64) * 255 / 63), 255 / 63),
        (np.rint(np.arange(100) * 255 / 99), 255 / 99),
    ],
)
def test_the_step_of_a_coarser_converter_is_read_off_the_codes_in_use(table, step_dn):
    codes = table[np.random.default_rng(1).integers(0, len(table), (1, 60, 80, 1))]
    (found,) = Quantisation.estimate_from(
        [replace(capture("scene", 100.0), real_dn=codes.astype(np.float32))]
    )
    assert found.value == pytest.approx(step_dn, abs=0.03)
    assert found.is_seen(1.0)


def test_codes_that_a_tone_curve_spreads_are_no_coarser_converter():
    spread = np.rint(255 * (np.arange(256) / 255) ** (1 / 2.2))
    codes = spread[np.random.default_rng(1).integers(0, 90, (1, 60, 80, 1))]
    assert not list(
        Quantisation.estimate_from([replace(capture("scene", 100.0), real_dn=codes.astype(np.float32))])
    )


def test_rounding_down_darkens_by_half_a_step():
    error = run(make(Quantisation, step_dn=4.0, rounding="floor"), SCENE_DN) - SCENE_DN
    assert error.mean() == pytest.approx(-2.0, abs=0.1)
    assert error.max() <= 0


@pytest.mark.parametrize(("step_dn", "last_dn"), [(1, 255), (4, 252), (255 / 63, 255), (64, 192)])
def test_a_converter_that_rounds_down_ends_at_its_last_code(step_dn, last_dn):
    codes = run(make(Quantisation, step_dn=step_dn, rounding="floor"), np.full((1, 2, 2, 1), 300.0))
    assert codes == pytest.approx(last_dn)


def test_rounding_down_by_whole_numbers_is_not_neutral():
    np.testing.assert_array_equal(run(make(Quantisation, rounding="floor"), SCENE_DN), np.floor(SCENE_DN))


def test_shading_correction_raises_variance_over_mean_towards_the_corners():
    frames = flats(100.0, 3.0, frames=200, height=30, width=40)
    seen = run(make(LensShadingCorrection, k1=1.0), frames)
    ratio = seen.var(axis=0).mean(axis=-1) / (seen.mean(axis=(0, -1)) - BLACK_DN)
    corner, middle = ratio[:3, :3].mean(), ratio[13:17, 18:22].mean()
    assert corner / middle == pytest.approx(1.9, rel=0.1)  # the gain itself, 1 + r^2
    assert seen[..., 0, 0, :].mean() - BLACK_DN == pytest.approx(
        84 * (1 + (19.5**2 + 14.5**2) / 25**2), rel=0.01
    )


def test_white_balance_multiplies_red_and_blue_above_the_pedestal():
    seen = run(make(WhiteBalance, red=1.5, blue=0.5), SCENE_DN)
    np.testing.assert_allclose(seen - BLACK_DN, (SCENE_DN - BLACK_DN) * [1.5, 1.0, 0.5], rtol=1e-12)


def test_white_balance_of_a_mosaic_follows_its_filters():
    flat = np.full((1, 4, 6, 1), 100.0)
    gain = (run(make(WhiteBalance, red=2.0, blue=3.0), flat, cfa="GRBG")[0, :, :, 0] - BLACK_DN) / 84
    np.testing.assert_allclose(gain, np.tile([[1, 2], [3, 1]], (2, 3)))


@pytest.mark.parametrize("effect", [make(WhiteBalance, red=2.0), make(ColourMatrix, matrix=((0, 1, 0),) * 3)])
def test_colours_need_colour(effect):
    with pytest.raises(ContextMissing, match="in colour"):
        run(effect, flats(channels=1))


def test_of_a_mono_camera_in_a_recipe_there_are_no_colours_to_change():
    """A study chooses among mono and colour parts with one pipeline."""
    grey = sample_frames()
    mono = FrameBatch(grey.capture, tuple(image[..., :1] for image in grey.images))
    assert with_effect(mono, placed(WhiteBalance, red=2.0)) is mono


MATRIX = np.array([[1.6, -0.4, -0.2], [-0.3, 1.5, -0.2], [0.0, -0.6, 1.6]])
MIXING = make(ColourMatrix, matrix=tuple(map(tuple, MATRIX)))


def test_a_colour_matrix_mixes_colours_and_keeps_greys():
    expected = np.einsum("ij,nhwj->nhwi", MATRIX, SCENE_DN - BLACK_DN) + BLACK_DN
    np.testing.assert_allclose(run(MIXING, SCENE_DN), expected, rtol=1e-10)
    grey = np.repeat(SCENE_DN[..., :1], 3, axis=-1)
    np.testing.assert_allclose(run(MIXING, grey), grey, rtol=1e-10)


def test_a_colour_matrix_correlates_the_noise_of_channels():
    seen = run(MIXING, flats(height=200, width=200)).reshape(-1, 3)
    np.testing.assert_allclose(np.cov(seen.T), 9 * MATRIX @ MATRIX.T, rtol=0.02, atol=0.1)


def test_a_colour_matrix_that_tints_greys_is_refused():
    with pytest.raises(ValidationError, match=r"sum to 1, not to 1\.1, 1, 1"):
        ColourMatrix.Config(matrix=((1.1, 0, 0), (0, 1, 0), (0, 0, 1)))


@pytest.mark.parametrize("window", [3, 5, 7])
@pytest.mark.parametrize("threshold", [0.0, 0.01])
def test_denoising_is_the_adaptive_wiener_filter(window, threshold):
    frame = ndimage.gaussian_filter(np.random.default_rng(2).normal(100, 40, (60, 80)), 2)
    frame += np.random.default_rng(3).normal(0, 2, frame.shape)
    mean = ndimage.uniform_filter(frame, window)
    noise = 0.7 * noise_of_levels(frame[..., None], mean[..., None])[..., 0]
    noise += (threshold * (WHITE_DN - BLACK_DN)) ** 2
    expected = signal.wiener(frame, window, noise=noise)
    denoise = make(Denoise, strength=0.7, threshold=threshold, window=window)
    seen = run(denoise, frame[None, ..., None])[0, ..., 0]
    inside = np.s_[4:-4, 4:-4]  # SciPy takes zeros for what lies beyond the edges
    np.testing.assert_allclose(seen[inside], expected[inside], rtol=1e-8)


def test_the_noise_of_a_level_is_found_beside_edges_and_texture():
    rng = np.random.default_rng(5)
    rows, columns = np.mgrid[:200, :200]
    signal_dn = np.where((rows // 25 + columns // 25) % 2, 40.0, 200.0)
    signal_dn += 10 * np.sin(columns / 4)  # texture far above the noise
    variance = 0.25 * signal_dn + 2
    frame = (signal_dn + rng.normal(0, np.sqrt(variance)))[..., None]
    mean = ndimage.uniform_filter(signal_dn, 5)[..., None]
    found = noise_of_levels(frame, mean)[..., 0]
    for dark in (True, False):
        here = (signal_dn < 60) == dark
        assert np.median(found[here]) == pytest.approx(np.median(variance[here]), rel=0.2)


def test_denoising_takes_noise_from_flats_and_leaves_it_correlated_while_edges_stay():
    frames = flats(50.0, 2.0, height=100, width=100)
    frames[:, :, 50:] += 120
    seen = run(make(Denoise, strength=1.0), frames)
    assert seen[:, :, 10:40].var() < 0.2 * 4
    assert neighbour_correlation(seen[:, :, 10:40]) > 0.3
    edge = seen.mean(axis=(0, 1, 3))
    assert edge[50] - edge[49] > 0.98 * 120


def test_a_threshold_smooths_faint_noise_and_leaves_that_of_bright_parts():
    frames = flats(50.0, 1.0, height=100, width=100)
    frames[:, :, 50:] = flats(150.0, 8.0, height=100, width=50)
    seen = run(make(Denoise, threshold=1.5 / (WHITE_DN - BLACK_DN)), frames)
    assert seen[:, :, 10:40].var() < 0.1
    assert seen[:, :, 60:90].var() > 0.9 * 64


@given(strength=st.floats(0.001, 0.05))
def test_a_little_denoising_does_little(strength):
    frames = flats(frames=1, height=20, width=20)
    change = run(make(Denoise, strength=strength), frames) - frames
    # Where the local variance is at least a tenth of the median, as it is here nearly everywhere.
    assert np.abs(change).mean() < 2 * strength * 3


def test_sharpening_is_an_unsharp_mask():
    effect = make(Sharpening, amount=1.5, radius_px=1.2)
    blurred = ndimage.gaussian_filter(SCENE_DN, (0, 1.2, 1.2, 0), mode="reflect", truncate=4.17)
    np.testing.assert_allclose(run(effect, SCENE_DN), SCENE_DN + 1.5 * (SCENE_DN - blurred), atol=0.05)


def test_sharpening_overshoots_at_edges():
    frames = flats(50.0, 0.0, height=40, width=40)
    frames[:, :, 20:] = 150.0
    seen = run(make(Sharpening, amount=1.0), frames)
    assert seen.max() > 165
    assert seen.min() < 35
    np.testing.assert_allclose(seen[:, :, :10], 50.0)


def test_gamma_is_a_straight_line_of_that_slope_in_logarithms():
    seen = run(make(ToneCurve, gamma=0.45), RAMP_DN)
    t_in, t_out = ((x.ravel()[1:] - BLACK_DN) / FULL_SCALE_DN for x in (RAMP_DN, seen))
    np.testing.assert_allclose(np.log(t_out), 0.45 * np.log(t_in), atol=1e-9)


def test_below_the_pedestal_a_tone_curve_goes_on_point_symmetrically():
    above, below = (run(make(ToneCurve, gamma=0.5), np.full((1, 1, 1, 1), BLACK_DN + d)) for d in (3.0, -3.0))
    assert (above - BLACK_DN).item() == pytest.approx(-(below - BLACK_DN).item())


@given(
    heights=st.lists(st.floats(0, 1), min_size=3, max_size=3).map(sorted),
    places=st.tuples(st.floats(0.05, 0.3), st.floats(0.35, 0.6), st.floats(0.65, 0.95)),
)
def test_a_curve_through_knots_rises_and_passes_them(heights, places):
    inner = tuple(zip(places, heights, strict=True))
    effect = make(ToneCurve, knots=((0, 0), *inner, (1, 1)))
    curve = run(effect, RAMP_DN)
    assert np.diff(curve.ravel()).min() > -1e-9
    assert curve.ravel()[[0, -1]] == pytest.approx([BLACK_DN, WHITE_DN])
    at_knots = run(effect, BLACK_DN + FULL_SCALE_DN * np.array(places).reshape(1, 1, 3, 1))
    np.testing.assert_allclose((at_knots.ravel() - BLACK_DN) / FULL_SCALE_DN, heights, atol=2e-3)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"gamma": 0.5, "knots": ((0, 0), (1, 1))}, "not both"),
        ({"knots": ((0, 0.1), (1, 1))}, "from \\(0, 0\\) to \\(1, 1\\)"),
        ({"knots": ((0, 0), (0.6, 0.5), (0.5, 0.6), (1, 1))}, "signal rises"),
        ({"knots": ((0, 0), (0.5, 0.6), (0.6, 0.5), (1, 1))}, "does not fall"),
    ],
)
def test_knots_that_make_no_rising_curve_are_refused(settings, words):
    with pytest.raises(ValidationError, match=words):
        ToneCurve.Config(**settings)


def test_files_are_rounded_and_clipped_and_keep_their_depth():
    frames = sample_frames()
    images = tuple(image.astype(np.uint16) * 16 for image in frames.images)
    deep = FrameBatch(frames.capture, images, black_level_dn=0.0, white_level_dn=4095)
    seen = with_effect(deep, placed(WhiteBalance, red=3.0))
    assert seen.images[0].dtype == np.uint16
    np.testing.assert_array_equal(seen.images[0][..., 0], np.minimum(images[0][..., 0] * 3, 4095))
    assert seen.capture is deep.capture


def test_a_gain_map_that_darkens_corners_is_drawn_but_not_proposed():
    lifting, darkening = make(LensShadingCorrection, k1=0.5, k2=-0.2), make(LensShadingCorrection, k1=-0.5)
    assert lifting.plausible
    assert not darkening.plausible
    assert run(darkening, SCENE_DN).mean() < SCENE_DN.mean()


@pytest.mark.parametrize(
    ("knots", "plausible"),
    [
        (((0, 0), (0.1, 0.3), (0.5, 0.8), (1, 1)), True),
        (((0, 0), (0.06, 0.06), (0.3, 0.06), (1, 1)), False),  # a sensor that saturates
        (((0, 0), (0.5, 0.99), (0.8, 0.99), (1, 1)), True),  # a shoulder
    ],
)
def test_a_tone_curve_that_is_level_below_full_scale_is_none(knots, plausible):
    assert ToneCurve(ToneCurve.Config(knots=knots)).plausible is plausible
