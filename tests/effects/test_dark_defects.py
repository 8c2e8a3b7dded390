"""Bad lines and hot pixels: how many, what they show, and when captures suggest which."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.values import ImageGeometry
from tacos_plugins.effects.black_level import BlackLevel
from tacos_plugins.effects.dark_current import DarkCurrent
from tacos_plugins.effects.darks import isolated, steady_darks
from tacos_plugins.effects.defect_lines import DefectLines
from tacos_plugins.effects.dsnu import Dsnu
from tests.effects.sample_arrays import BLACK_DN, context, flats, geometry_of, make, run
from tests.effects.test_declarations import seen


def dark(rows: int = 60, columns: int = 80, frames: int = 2, black_dn: float = 0.0) -> np.ndarray:
    return np.full((frames, rows, columns, 1), black_dn, np.float32)


def geometry(frames: np.ndarray) -> ImageGeometry:
    height, width = frames.shape[1:3]
    return ImageGeometry(width, height, 300.0, ((width - 1) / 2, (height - 1) / 2), 3.0)


def as_dark(frames: np.ndarray, **changes):
    capture = seen(frames, dark(*frames.shape[1:3], frames=1), kind="dark", **changes)
    capture.geometry = geometry(frames)
    return capture


@given(share=st.floats(0, 1), seed=st.integers(0, 50))
def test_as_many_columns_are_bad_as_the_share_says(share, seed):
    effect = make(DefectLines, column_share=share, offset_dn=7.0, map_seed=seed)
    bad = run(effect, flats(100.0, 0.0))[0, :, :, 0] - 100.0
    assert np.count_nonzero(bad[0]) == round(share * bad.shape[1])
    np.testing.assert_array_equal(bad, np.broadcast_to(bad[:1], bad.shape))
    assert set(np.unique(bad)) <= {0.0, 7.0}


@given(small=st.floats(0, 0.5), more=st.floats(0, 0.5))
def test_lines_of_a_smaller_share_stay_bad(small, more):
    few, many = (
        run(make(DefectLines, row_share=share), flats(100.0, 0.0)) > 100 for share in (small, small + more)
    )
    assert np.all(many[few])


def test_a_dead_line_shows_the_pedestal_whatever_the_light():
    effect = make(DefectLines, column_share=0.1, dead=True)
    bright, dim = (run(effect, flats(level, 0.0))[0] for level in (180.0, 60.0))
    np.testing.assert_array_equal(bright == BLACK_DN, dim == BLACK_DN)
    assert 0.05 < np.mean(bright == BLACK_DN) < 0.15


@pytest.mark.parametrize("binning", [2.0, 4.0])
def test_a_binned_line_averages_its_photosites(binning):
    frames = flats(100.0, 0.0)
    binned = geometry_of(frames, binning=binning)
    effect = make(DefectLines, column_share=0.05, offset_dn=12.0)
    shown = effect.on_array(frames, geometry=binned, context=context(), rng=np.random.default_rng(0)) - 100
    photosites = binned.full_width_px * binning
    assert shown[0, 0, :, 0].sum() == pytest.approx(12.0 * round(0.05 * photosites) / binning, rel=1e-5)


@pytest.mark.parametrize("binning", [1.5, 2.7, 3.0])
def test_no_more_of_a_binned_line_is_bad_than_all_of_it(binning):
    """Where the binning is no whole number, a line of photosites may belong to two lines of the image."""
    frames = flats(100.0, 0.0)
    binned = geometry_of(frames, binning=binning)
    every = make(DefectLines, column_share=1.0, dead=True)
    shown = every.on_array(frames, geometry=binned, context=context(), rng=np.random.default_rng(0))
    np.testing.assert_allclose(shown[:, :, :-1], BLACK_DN, rtol=1e-5)  # the last may lie half off the sensor
    assert shown.min() > BLACK_DN - 1e-3


# what captures suggest ------------------------------------------------------------------------------------


def test_a_column_that_is_bad_all_along_is_suggested():
    frames = dark()
    frames[:, :, 31] += 9.0
    assert list(DefectLines.guesses_from([as_dark(frames)])) == [{"column_share": 1 / 80, "offset_dn": 9.0}]


def test_a_dead_row_is_told_from_an_offset_by_a_flat():
    frames = np.full((2, 60, 80, 1), 100.0, np.float32)
    frames[:, 20] = 0.0
    flat = seen(frames, np.full((1, 60, 80, 1), 100.0), kind="flat")
    assert list(DefectLines.guesses_from([flat])) == [{"row_share": 1 / 60, "dead": True}]


def test_bad_columns_and_rows_are_suggested_together_and_alone():
    frames = dark()
    frames[:, :, 31] += 9.0
    frames[:, 12] += 8.0
    both, columns, rows = DefectLines.guesses_from([as_dark(frames)])
    assert columns == {"column_share": 1 / 80, "offset_dn": 9.0}
    assert rows == {"row_share": 1 / 60, "offset_dn": 8.0}
    assert both == {**columns, **rows, "offset_dn": 8.5}


def test_lines_too_weak_for_one_capture_are_seen_in_the_mean_of_several():
    def noisy(seed, sigma_dn):
        frames = dark() + np.random.default_rng(seed).normal(0, sigma_dn, (2, 60, 80, 1)).astype(np.float32)
        frames[:, :, 31] += 1.2
        return as_dark(np.round(frames))

    one, several = [noisy(0, 1.6)], [*(noisy(seed, 1.6) for seed in range(9)), noisy(9, 9.0)]
    assert list(DefectLines.guesses_from(one)) == []
    (guess,) = DefectLines.guesses_from(several)
    assert guess["column_share"] == 1 / 80
    assert guess["offset_dn"] == pytest.approx(1.2, abs=0.3)


def test_captures_of_other_crops_show_other_lines():
    def cropped(x):
        frames = dark()
        frames[:, :, 31 - x] += 9.0
        capture = as_dark(frames)
        capture.geometry = replace(capture.geometry, offset_px=(x, 0), full_width_px=100)
        return capture

    (guess,) = DefectLines.guesses_from([cropped(0), cropped(4), cropped(9)])
    assert guess == {"column_share": 1 / 80, "offset_dn": 9.0}


@pytest.mark.parametrize("bad", [np.s_[:, 35:, 31], np.s_[:, :5, :], np.s_[:, ::7, ::11]], ids=str)
def test_what_is_bad_in_part_only_is_no_line_defect(bad):
    """A piece of a column, a band of rows, and pixels that stand alone."""
    frames = dark()
    frames[bad] += 9.0
    found = list(DefectLines.guesses_from([as_dark(frames)]))
    assert not [guess for guess in found if "column_share" in guess]


def test_a_pattern_of_all_columns_is_no_line_defect():
    frames = dark() + np.random.default_rng(1).normal(0, 3, (1, 1, 80, 1)).astype(np.float32)
    assert list(DefectLines.guesses_from([as_dark(frames)])) == []


def test_pieces_of_lines_do_not_stand_alone_and_single_pixels_do():
    bright = np.zeros((20, 20), bool)
    bright[5, 7] = bright[9, 2:9] = bright[12:19, 15] = True
    alone = isolated(bright)
    assert alone[5, 7]
    assert not alone[9, 3:8].any()
    assert not alone[13:18, 15].any()


def test_columns_without_a_pedestal_suggest_a_pattern_and_single_pixels_dark_current():
    column, pixels = dark(), dark()
    column[:, 20:, 31] = 2.0
    pixels[:, ::9, ::13] = 5.0
    assert "column_sigma_dn" in next(iter(Dsnu.guesses_from([as_dark(column)])))
    assert _hot(column).size <= 2  # the ends of the piece
    assert _hot(pixels).size == np.count_nonzero(pixels[0])
    (guess,) = DarkCurrent.guesses_from([as_dark(pixels, exposure_s=2.0)])
    assert guess["hot_rate_dn_s"] == pytest.approx((5.0 - 0.5) / 2.0)


def _hot(frames: np.ndarray) -> np.ndarray:
    (found,) = steady_darks([as_dark(frames)])
    return found.hot_dn


def test_a_dark_that_rises_with_time_suggests_its_rate():
    noise = np.random.default_rng(2)
    short, long = (
        np.rint(np.maximum(noise.normal(level, 1.3, (2, 60, 80, 1)), 0)).astype(np.float32)
        for level in (4, 9)
    )
    guesses = DarkCurrent.guesses_from([as_dark(long, exposure_s=5.0), as_dark(short, exposure_s=0.0)])
    assert next(iter(guesses))["rate_dn_s"] == pytest.approx(1.0, abs=0.05)


def test_a_pattern_that_grows_with_time_suggests_how_uneven_the_rates_are():
    noise = np.random.default_rng(4)
    rates_dn_s = noise.gamma(4.0, 0.5, (1, 60, 80, 1))  # mean 2, spread over mean 1/2
    short, long = (
        np.rint(noise.normal(50 + rates_dn_s * time_s, 0.8, (4, 60, 80, 1))).astype(np.float32)
        for time_s in (0.5, 4.0)
    )
    darks = [as_dark(long, exposure_s=4.0), as_dark(short, exposure_s=0.5)]
    guess = next(iter(DarkCurrent.guesses_from(darks)))
    assert guess["rate_dn_s"] == pytest.approx(2.0, rel=0.1)
    assert guess["nonuniformity"] == pytest.approx(0.5, rel=0.1)


def test_the_pedestal_is_the_dark_without_its_current():
    noise = np.random.default_rng(5)
    short, long = (noise.normal(50 + 8 * time_s, 0.5, (2, 60, 80, 1)) for time_s in (0.5, 2.0))
    darks = [as_dark(frames.astype(np.float32), exposure_s=s) for frames, s in ((long, 2.0), (short, 0.5))]
    (guess,) = BlackLevel.guesses_from(darks)
    (found,) = BlackLevel.estimate_from(darks)
    assert guess["offset_dn"] == pytest.approx(50.0, abs=0.05)
    assert found.value == pytest.approx(50.0, abs=4 * found.standard_error)
    assert found.standard_error < 0.02
    (alone,) = BlackLevel.guesses_from(darks[1:])
    assert alone["offset_dn"] == pytest.approx(54, abs=0.05)


def test_noise_that_is_cut_off_at_0_is_no_bright_pixel():
    noise = np.random.default_rng(3).normal(0, 1.3, (2, 200, 200, 1))
    (found,) = steady_darks([as_dark(np.rint(np.maximum(noise, 0)).astype(np.float32))])
    assert found.lowest_dn > 4
    assert found.hot_dn.size == 0
