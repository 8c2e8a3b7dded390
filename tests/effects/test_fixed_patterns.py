"""PRNU, DSNU and dark current: what is fixed to a sensor."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_framework.errors import UserError
from tacos_plugins.effects.dark_current import DarkCurrent
from tacos_plugins.effects.dsnu import Dsnu
from tacos_plugins.effects.prnu import Prnu
from tests.effects.sample_arrays import BLACK_DN, context, flats, geometry_of, make, run

PATTERNS = {
    "prnu": make(Prnu, sigma=0.01),
    "dsnu": make(Dsnu, sigma_dn=1.0, column_sigma_dn=0.5),
    "dark-current": make(DarkCurrent, rate_dn_s=10.0, hot_share=0.05),
}
every_pattern = pytest.mark.parametrize("effect", PATTERNS.values(), ids=PATTERNS)


def dark(frames: int = 3, **size: int) -> np.ndarray:
    return flats(BLACK_DN, 0.0, frames=frames, **size)


@every_pattern
def test_a_pattern_repeats_over_frames_generators_and_candidates(effect):
    pattern = run(effect, flats(100.0, 0.0)) - 100.0
    np.testing.assert_array_equal(pattern, np.broadcast_to(pattern[:1], pattern.shape))
    again = make(type(effect), **effect.config.model_dump())
    np.testing.assert_array_equal(run(again, flats(100.0, 0.0), seed=99) - 100.0, pattern)


@every_pattern
def test_another_sensor_has_another_pattern(effect):
    other = make(type(effect), **{**effect.config.model_dump(), "map_seed": 1})
    first, second = (run(e, flats(100.0, 0.0))[0].ravel() for e in (effect, other))
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.05  # 14,400 photosites: standard error 0.008


@every_pattern
def test_two_cameras_of_a_rig_have_different_patterns(effect):
    flat = flats(100.0, 0.0)
    seen = [
        effect.on_array(
            flat,
            geometry=geometry_of(flat, camera=camera),
            context=context(),
            rng=np.random.default_rng(0),
        )
        for camera in ("left", "right")
    ]
    assert abs(np.corrcoef(*(each[0].ravel() for each in seen))[0, 1]) < 0.06


@every_pattern
def test_a_crop_shows_its_part_of_the_pattern(effect):
    frames = flats(100.0, 0.0)
    full = geometry_of(frames)
    part = effect.on_array(
        np.ascontiguousarray(frames[:, 10:30, 5:45]),
        geometry=full.crop(x=5, y=10, width_px=40, height_px=20),
        context=context(),
        rng=np.random.default_rng(0),
    )
    np.testing.assert_array_equal(part, run(effect, frames)[:, 10:30, 5:45])


def test_prnu_is_the_spread_of_the_response_over_the_mean_at_every_level():
    effect = make(Prnu, sigma=0.02)
    for level_dn in (40.0, 200.0):
        flat = run(effect, flats(level_dn, 0.0, height=120, width=160))[0]
        prnu = flat.std() / (flat.mean() - BLACK_DN)  # EMVA 1288, without the dark term, which is zero
        assert prnu == pytest.approx(0.02, rel=0.02)  # 57,600 photosites: standard error 0.3 %


def test_prnu_leaves_the_dark_as_it_is():
    np.testing.assert_array_equal(run(make(Prnu, sigma=0.1), dark()), dark())


def test_dsnu_has_the_spread_asked_for_in_pixels_and_columns_whatever_the_light():
    effect = make(Dsnu, sigma_dn=2.0, column_sigma_dn=1.5)
    size = {"height": 200, "width": 2000, "channels": 1, "frames": 1}
    pattern = run(effect, dark(**size))[0, :, :, 0] - BLACK_DN
    np.testing.assert_allclose(run(effect, flats(150.0, 0.0, **size))[0, :, :, 0] - 150.0, pattern, atol=1e-9)
    within = pattern.var(axis=0, ddof=1).mean()
    columns = pattern.mean(axis=0).var(ddof=1) - within / len(pattern)
    assert within == pytest.approx(2.0**2, rel=0.02)
    assert columns == pytest.approx(1.5**2, rel=0.15)  # 2000 columns: standard error 3 %


def test_dark_signal_grows_with_the_exposure_time():
    effect = make(DarkCurrent, rate_dn_s=20.0)
    for exposure_s in (0.1, 0.4):
        np.testing.assert_allclose(run(effect, dark(), exposure_s=exposure_s), BLACK_DN + 20 * exposure_s)


def test_rates_of_dark_current_are_lognormal_about_their_mean():
    effect = make(DarkCurrent, rate_dn_s=20.0, nonuniformity=0.8)
    short, long = (
        run(effect, dark(height=300, width=400, channels=1, frames=1), exposure_s=s)[0] - BLACK_DN
        for s in (0.5, 2.0)
    )
    np.testing.assert_allclose(long, 4 * short, rtol=1e-4)
    assert long.mean() == pytest.approx(40.0, rel=0.02)
    assert long.std() / long.mean() == pytest.approx(0.8, rel=0.03)
    logarithm = np.log(long / np.median(long))
    assert (logarithm**3).mean() / logarithm.std() ** 3 == pytest.approx(0.0, abs=0.05)


def test_hot_pixels_have_the_share_and_the_mean_asked_for_and_stay_where_they_are():
    size = {"height": 300, "width": 400, "channels": 1, "frames": 1}
    few = run(make(DarkCurrent, hot_share=0.01, hot_rate_dn_s=50.0), dark(**size), exposure_s=1.0) - BLACK_DN
    more = run(make(DarkCurrent, hot_share=0.02, hot_rate_dn_s=50.0), dark(**size), exposure_s=1.0) - BLACK_DN
    hot = few > 0
    assert hot.mean() == pytest.approx(0.01, rel=0.15)  # 1200 pixels: standard error 3 %
    assert few[hot].mean() == pytest.approx(50.0, rel=0.15)
    np.testing.assert_array_equal(more[hot], few[hot])
    assert (more > 0).sum() > 1.5 * hot.sum()


def test_a_measured_map_takes_the_place_of_the_drawn_one(tmp_path):
    measured = np.random.default_rng(4).uniform(0.9, 1.1, (60, 80))
    np.save(tmp_path / "map.npy", measured)
    seen = run(make(Prnu, sigma=0.03, map=str(tmp_path / "map.npy")), flats(100.0, 0.0))
    response = (seen - BLACK_DN) / (100.0 - BLACK_DN)
    expected = 1 + 0.03 * (measured - measured.mean()) / measured.std()
    np.testing.assert_allclose(response, np.broadcast_to(expected[None, ..., None], seen.shape), rtol=1e-6)


@pytest.mark.parametrize(
    ("array", "words"),
    [
        (np.ones((60, 70)), "has the shape"),
        (np.ones((60, 80)), "is flat"),
        (np.full((60, 80), np.nan), "no numbers"),
        (None, "is no array"),
    ],
)
def test_a_map_that_cannot_serve_is_refused_by_name(tmp_path, array, words):
    path = tmp_path / "map.npy"
    if array is None:
        path.write_text("these are not numbers")
    else:
        np.save(path, array)
    with pytest.raises(UserError, match=words) as refused:
        run(make(Dsnu, sigma_dn=1.0, map=str(path)), flats())
    assert str(path) in str(refused.value)


def test_a_map_belongs_to_one_specimen(tmp_path):
    """Of another camera it would be wrong however it were cut or scaled: it is refused, and says why."""
    np.save(tmp_path / "map.npy", np.random.default_rng(4).uniform(0.9, 1.1, (120, 160)))
    with pytest.raises(UserError) as refused:
        run(make(Prnu, sigma=0.03, map=str(tmp_path / "map.npy")), flats())
    (fault,) = refused.value.faults
    assert "(120, 160), which is not that of the sensor of this camera" in fault.what
    assert "A map belongs to one specimen of a sensor" in fault.remedy


def test_a_binned_pixel_averages_the_hot_photosites_that_are_in_it():
    size = {"height": 300, "width": 400, "channels": 1, "frames": 1}
    effect = make(DarkCurrent, hot_share=0.02, hot_rate_dn_s=50.0)
    frames = dark(**size)
    binned = effect.on_array(
        frames,
        geometry=geometry_of(frames, binning=4.0),
        context=context(exposure_s=1.0),
        rng=np.random.default_rng(0),
    )
    hot = binned[0, ..., 0] - BLACK_DN
    assert hot.mean() == pytest.approx(0.02 * 50.0, rel=0.05)
    assert (hot > 0).mean() == pytest.approx(1 - np.exp(-0.02 * 16), rel=0.05)
    # Of n exponentials with n Poisson of mean m: variance 2 m rate^2, over the square of 16 photosites.
    assert hot.var() == pytest.approx(2 * 0.02 * 16 * 50.0**2 / 16**2, rel=0.1)
