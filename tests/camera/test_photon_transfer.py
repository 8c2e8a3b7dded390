"""Noise measured from frames: what went in comes out, and what is not noise does not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_plugins.noise_calibration.levels import measure_levels
from tacos_plugins.noise_calibration.photon_transfer import fit_affine


def bars(
    frames: int = 8,
    *,
    photon_dn: float = 0.24,
    thermal_dn2: float = 1.8,
    brightest_dn: float = 220.0,
    black_dn: float = 0.0,
    count: int = 12,
    pattern: float = 0.0,
    seed: int = 1,
    bits: int = 8,
) -> np.ndarray:
    """(F, 144, 240) frames of grey bars with Gaussian noise, unevenly lit from top to bottom."""
    rng = np.random.default_rng(seed)
    steps = np.repeat(np.linspace(0, brightest_dn, count), 240 // count)
    signal = steps * np.linspace(1.0, 0.9, 144)[:, None]
    signal = signal * (1 + pattern * rng.standard_normal(signal.shape))
    noise = rng.standard_normal((frames, *signal.shape)) * np.sqrt(photon_dn * signal + thermal_dn2)
    return np.clip(np.rint(signal + noise + black_dn), 0, 2**bits - 1).astype(np.uint16)


def fitted(frames: np.ndarray, *, black_dn: float = 0.0, white_dn: float = 255.0):
    levels = measure_levels([frames], white_level_dn=white_dn)
    return levels, fit_affine(levels, black_level_dn=black_dn)


@settings(max_examples=15, deadline=None)
@given(
    photon_dn=st.floats(0.05, 1.0),
    thermal_dn2=st.floats(0.5, 10.0),
    black_dn=st.sampled_from([0.0, 16.0]),
    frames=st.integers(2, 12),
)
def test_what_went_in_comes_out(photon_dn, thermal_dn2, black_dn, frames):
    drawn = bars(frames, photon_dn=photon_dn, thermal_dn2=thermal_dn2, black_dn=black_dn, brightest_dn=150.0)
    _, fit = fitted(drawn, black_dn=black_dn)
    # Three times the half width: the property must hold for every example, not for 19 of 20.
    reach = 3 * (fit.photon_ci[1] - fit.photon_ci[0]) / 2
    assert abs(fit.photon_dn - photon_dn) < reach
    assert reach < 0.35 * photon_dn + 0.05
    reach = 3 * (fit.thermal_ci[1] - fit.thermal_ci[0]) / 2
    assert abs(fit.thermal_dn2 - thermal_dn2) < reach


def test_95_percent_intervals_hold_the_truth_about_as_often():
    held = [
        (fit.photon_ci[0] <= 0.24 <= fit.photon_ci[1], fit.thermal_ci[0] <= 1.8 <= fit.thermal_ci[1])
        for fit in (fitted(bars(4, seed=seed))[1] for seed in range(80))
    ]
    photon, thermal = np.mean(held, axis=0)
    assert 0.89 <= photon <= 1.0
    assert 0.89 <= thermal <= 1.0


def test_a_fixed_pattern_is_told_apart_from_noise():
    levels, fit = fitted(bars(pattern=0.02))
    assert fit.photon_dn == pytest.approx(0.24, rel=0.03)
    bright = levels.mean_dn > 100
    pattern = np.sqrt(np.average(levels.fixed_dn2[bright] / levels.mean_dn[bright] ** 2))
    assert pattern == pytest.approx(0.02, rel=0.1)
    without, _ = fitted(bars())
    assert np.average(without.fixed_dn2, weights=without.pixels) < 0.2


def test_pixels_that_jump_are_left_out_and_counted():
    frames = bars().astype(int)
    frames[::2, 20:140:24, 30:240:20] += 60  # in the middle of all bars but the first
    levels, fit = fitted(frames.astype(np.uint16))
    assert levels.outliers == 5 * 11
    assert np.average(levels.fixed_dn2, weights=levels.pixels) < 0.2  # nor are their neighbours a pattern
    assert fit.photon_dn == pytest.approx(0.24, rel=0.03)
    assert measure_levels([bars()], white_level_dn=255).outliers == 0


def test_a_ramp_is_cut_into_levels_of_equal_steps():
    """Signal from 20 to 220 over 600 columns, less what the borders take."""
    rng = np.random.default_rng(1)
    ramp = np.linspace(20, 220, 600) + rng.normal(0, 3, (8, 100, 600))
    levels = measure_levels([np.rint(ramp).astype(np.uint16)], white_level_dn=255, levels=10)
    assert levels.mean_dn == pytest.approx(20 + 20 * (np.arange(10) + 0.5), abs=1.5)
    assert levels.variance_dn2 == pytest.approx(np.full(10, 9 + 1 / 12), rel=0.05)
    assert levels.frames == 8
    # von Neumann 1941: half the mean square of 7 successive differences scatters by (3 F - 4) / (F - 1)^2.
    assert levels.error_dn2 == pytest.approx(levels.variance_dn2 * np.sqrt(20 / 49 / levels.pixels))


@pytest.mark.parametrize("frames", [2, 5])
def test_the_error_of_a_variance_is_its_scatter(frames):
    drawn = [
        measure_levels(
            [np.random.default_rng(seed).normal(100, 4, (frames, 60, 60)).astype(np.uint16)],
            white_level_dn=255,
            levels=1,
        )
        for seed in range(120)
    ]
    scatter = np.std([levels.variance_dn2 for levels in drawn])
    assert scatter == pytest.approx(np.mean([levels.error_dn2 for levels in drawn]), rel=0.2)


@pytest.mark.parametrize("value", [0, 255])
def test_of_censored_frames_every_sample_is_clipped(value):
    levels = measure_levels([np.full((4, 60, 60), value, np.uint16)], white_level_dn=255)
    assert levels.clipped.tolist() == [1.0]
    assert levels.edge_excess == 1.0


def test_the_share_of_clipped_samples_is_over_all_frames():
    frames = np.full((4, 60, 60), 100, np.uint16)
    frames[0, ::2] = 0
    frames[1] = 1
    frames[:, :, 30:] = 200  # a second level, without
    levels = measure_levels([frames], white_level_dn=255, levels=2)
    assert levels.clipped.tolist() == pytest.approx([1 / 8, 0.0], abs=0.01)


def test_where_nothing_is_even_there_is_no_level():
    steep = np.tile(4 * np.arange(60), (4, 60, 1))
    levels = measure_levels([steep.astype(np.uint16)], white_level_dn=255)
    assert len(levels.mean_dn) == 0


def test_light_that_flickers_as_a_whole_is_no_noise():
    frames = bars(16, seed=3).astype(float)
    flicker = 1 + 0.02 * np.sin(np.arange(16))[:, None, None]
    _, fit = fitted(np.rint(frames * flicker).astype(np.uint16))
    assert fit.photon_dn == pytest.approx(0.24, rel=0.05)


def test_levels_cut_off_at_either_end_do_not_count():
    levels, fit = fitted(bars(brightest_dn=300.0))
    assert not fit.used[levels.mean_dn > 245].any()
    assert not fit.used[0]
    assert fit.photon_dn == pytest.approx(0.24, rel=0.03)


def test_noise_finer_than_a_digital_number_does_not_count():
    levels, fit = fitted(bars(16, photon_dn=0.01, thermal_dn2=0.05))
    assert (levels.variance_dn2[fit.used] > 0.3).all()
    assert not fit.used[levels.mean_dn < 10].any()
    assert fit.photon_dn == pytest.approx(0.01, rel=0.06)


def test_a_full_well_below_the_white_level_is_found():
    frames = np.minimum(bars(brightest_dn=1500.0, photon_dn=0.5, bits=12), 1000)
    _, fit = fitted(frames, white_dn=4095.0)
    assert fit.saturation_dn == pytest.approx(960, abs=60)
    assert fit.photon_dn == pytest.approx(0.5, rel=0.03)


def test_a_tone_curve_shows_as_a_bend_and_a_straight_camera_does_not():
    encoded = 255 * (bars(thermal_dn2=0.5, photon_dn=0.5, black_dn=5.0) / 255) ** (1 / 2.2)
    _, bent = fitted(np.rint(encoded).astype(np.uint16))
    assert abs(bent.bend) > 0.05
    assert abs(bent.bend_z) > 4
    _, straight = fitted(bars())
    assert abs(straight.bend) < 0.05 or abs(straight.bend_z) < 4


def test_edges_show_when_the_scene_moves():
    still = bars()
    assert measure_levels([still], white_level_dn=255).edge_excess == pytest.approx(1.0, abs=0.05)
    moving = np.stack([np.roll(frame, i, axis=1) for i, frame in enumerate(still)])
    assert measure_levels([moving], white_level_dn=255).edge_excess > 2.0


@pytest.mark.parametrize(("brighter_dn", "low", "high"), [(180, 30, 100), (255, 0.9, 1.2)])
def test_the_edges_alone_show_it_and_only_where_nothing_is_clipped(brighter_dn, low, high):
    """Noise of 2 everywhere, and five columns about an edge that jump by 60."""
    frames = np.random.default_rng(1).normal(100, 2, (8, 144, 240))
    frames[:, :, 120:] += brighter_dn - 100
    frames[::2, :, 118:123] -= 60
    if brighter_dn == 255:
        frames[:, :, 118:] = np.where(np.arange(8)[:, None, None] % 2, 255, 195)
    levels = measure_levels([np.clip(np.rint(frames), 0, 255).astype(np.uint16)], white_level_dn=255)
    assert low < levels.edge_excess < high


def test_both_greens_of_a_mosaic_count_together():
    one = measure_levels([bars(seed=1)], white_level_dn=255)
    both = measure_levels([bars(seed=1), bars(seed=2)], white_level_dn=255)
    assert both.pixels.sum() == pytest.approx(2 * one.pixels.sum(), rel=0.03)
    assert fit_affine(both, black_level_dn=0.0).photon_dn == pytest.approx(0.24, rel=0.03)


@pytest.mark.parametrize(
    ("frames", "reason"),
    [
        (bars(1), "at least two frames, not 1"),
        (np.full((4, 60, 60), 255, np.uint16), "0 usable levels"),
        (bars(brightest_dn=1.0, thermal_dn2=4.0, black_dn=100.0), "equally bright"),
    ],
    ids=["one frame", "white", "one brightness"],
)
def test_what_cannot_be_fitted_is_refused(frames, reason):
    with pytest.raises(ValueError, match=reason):
        fitted(frames)
