"""Each effect changes what physics says it changes, and nothing else."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from tacos_validation.blind.generators import flat_scenes
from tacos_validation.blind.generators import geometric_effects as geometry
from tacos_validation.blind.generators import light_effects as light
from tacos_validation.blind.generators import processing_effects as processing
from tacos_validation.blind.generators import sensor_effects as sensor
from tacos_validation.blind.generators.camera import IdealCamera, IdealShot, Image, dark
from tacos_validation.blind.generators.catalogue import CATALOGUE
from tacos_validation.blind.generators.image_formation import expected, seen, take
from tacos_validation.blind.generators.independent import VARIANTS, available
from tacos_validation.blind.generators.injected_effect import InjectedEffect

MONO = IdealCamera(96, 72, focal_px=96.0, channels=1)
COLOUR = IdealCamera(96, 72, focal_px=96.0, channels=3)
NEUTRAL: tuple[InjectedEffect, ...] = (
    light.InjectedIlluminationGradient(),
    light.InjectedDefocus(),
    light.InjectedLensBlur(),
    light.InjectedVeilingGlare(),
    light.InjectedVignetting(),
    light.InjectedMotionBlur(),
    light.InjectedExposureError(),
    light.InjectedFlicker(),
    geometry.InjectedLateralChromaticAberration(),
    geometry.InjectedLensDistortion(),
    geometry.InjectedFocalLengthError(),
    geometry.InjectedPoseError(),
    geometry.InjectedRollingShutter(),
    sensor.InjectedConversionGainError(),
    sensor.InjectedPrnu(),
    sensor.InjectedDarkCurrent(),
    sensor.InjectedDsnu(),
    sensor.InjectedCrosstalk(),
    sensor.InjectedDefectLines(),
    sensor.InjectedSaturation(),
    sensor.InjectedNonlinearity(),
    sensor.InjectedReadNoise(),
    sensor.InjectedRowNoise(),
    sensor.InjectedBlackLevelError(),
    sensor.InjectedQuantisation(),
    processing.InjectedShadingCorrection(),
    processing.InjectedWhiteBalance(),
    processing.InjectedDenoising(),
    processing.InjectedColourMatrix(),
    processing.InjectedToneCurve(),
    processing.InjectedSharpening(),
)


def flat(camera: IdealCamera = MONO, level: float = 0.5, exposure_ms: float = 10.0) -> IdealShot:
    return IdealShot(camera, flat_scenes.even(camera, level), exposure_ms)


def scene(camera: IdealCamera = MONO, velocity: tuple[float, float] = (0.0, 0.0)) -> IdealShot:
    rng = np.random.default_rng(5)
    return IdealShot(camera, flat_scenes.natural(camera, rng), 10.0, velocity_px_s=velocity)


def frames(shot: IdealShot, *effects: InjectedEffect, count: int = 4, seed: int = 1) -> Image:
    return take(shot, effects, count, np.random.default_rng(seed), sensor_seed=3)


def difference(shot: IdealShot, *effects: InjectedEffect, count: int = 6) -> Image:
    return np.asarray((frames(shot, *effects, count=count) - frames(shot, count=count, seed=2)).mean(axis=0))


@pytest.mark.parametrize("effect", NEUTRAL, ids=lambda effect: effect.name)
def test_a_neutral_effect_is_none(effect: InjectedEffect) -> None:
    shot = scene(COLOUR)
    changed = frames(shot, effect, count=1)
    # those that draw noise of their own leave the others' noise elsewhere, but not larger
    assert abs((changed - expected(shot)).var() / (frames(shot, count=1) - expected(shot)).var() - 1) < 0.05
    assert abs((changed - frames(shot, count=1)).mean()) < 0.1


def test_all_of_the_catalogue_has_a_maker() -> None:
    assert len(CATALOGUE) == 33
    for name, entry in CATALOGUE.items():
        effect = entry.build(entry.field[1], np.random.default_rng(0))
        assert effect.name == name


def test_clean_frames_follow_the_affine_noise_model() -> None:
    shot = flat(level=0.5)
    taken = frames(shot, count=24)
    signal = 0.5 * MONO.range_dn
    assert taken.mean() == pytest.approx(MONO.black_dn + signal, abs=0.1)
    wanted = MONO.photon_dn * signal + MONO.thermal_dn2 + 1 / 12
    assert taken.var(axis=0, ddof=1).mean() == pytest.approx(wanted, rel=0.03)


def test_the_expected_image_is_the_mean_of_clean_frames() -> None:
    shot = scene()
    inside = expected(shot) < 200
    assert abs((frames(shot, count=16).mean(axis=0) - expected(shot))[inside]).mean() < 1.2


def test_dark_corners() -> None:
    fallen = difference(flat(), light.InjectedVignetting(k1=-0.3))
    signal = 0.5 * MONO.range_dn
    assert fallen[:4, :4].mean() == pytest.approx(-0.3 * 0.92 * signal, rel=0.1)
    assert abs(fallen[32:40, 44:52].mean()) < 1.5


def test_lifted_corners_raise_noise_over_signal_and_dark_corners_do_not() -> None:
    def noise_over_signal(*effects: InjectedEffect) -> float:
        taken = frames(flat(level=0.3), *effects, count=24)[:, :12, :12]
        return float(
            (taken.var(axis=0).mean() - MONO.thermal_dn2) / (taken.mean() - MONO.black_dn) / MONO.photon_dn
        )

    assert noise_over_signal(light.InjectedVignetting(k1=-0.5)) == pytest.approx(1, abs=0.15)
    assert noise_over_signal(processing.InjectedShadingCorrection(k1=1.0)) > 1.5


def test_uneven_light_rises_along_its_axis() -> None:
    change = difference(flat(), light.InjectedIlluminationGradient(gx=0.2))
    assert change[:, -8:].mean() - change[:, :8].mean() == pytest.approx(
        0.2 * 0.5 * MONO.range_dn * 0.92, rel=0.1
    )


def test_haze_lifts_the_dark_of_a_scene_but_not_the_cap() -> None:
    shot = scene()
    dim = expected(shot) < 45
    assert difference(shot, light.InjectedVeilingGlare(0.1))[dim].mean() > 2
    assert abs(difference(IdealShot(MONO, dark, 10.0), light.InjectedVeilingGlare(0.1)).mean()) < 0.2


@pytest.mark.parametrize(
    "effect",
    [light.InjectedDefocus(2.0), light.InjectedLensBlur(1.2), light.InjectedMotionBlur(5.0, 0.0)],
    ids=lambda effect: effect.name,
)
def test_blur_keeps_light_and_takes_contrast(effect: InjectedEffect) -> None:
    shot = scene()
    blurred = effect.light(seen(shot, (), 24), shot, 24)[24:-24, 24:-24]
    sharp = seen(shot, ())
    assert blurred.mean() == pytest.approx(sharp.mean(), rel=0.03)
    assert np.diff(blurred, axis=1).var() < 0.6 * np.diff(sharp, axis=1).var()


def test_motion_blur_has_a_direction() -> None:
    shot = scene()
    sharp = seen(shot, ())
    smeared = light.InjectedMotionBlur(6.0, 90.0).light(seen(shot, (), 24), shot, 24)[24:-24, 24:-24]
    lost = [1 - np.diff(smeared, axis=axis).var() / np.diff(sharp, axis=axis).var() for axis in (0, 1)]
    assert lost[0] > lost[1] + 0.2


def test_distortion_moves_the_corner_by_its_formula() -> None:
    lens = geometry.InjectedLensDistortion(k1=-0.2, p1=0.003)
    shot = scene()
    true = np.array([[0.3]]), np.array([[0.2]])
    square = 0.3**2 + 0.2**2
    put_x = 0.3 * (1 - 0.2 * square) + 2 * 0.003 * 0.3 * 0.2
    put_y = 0.2 * (1 - 0.2 * square) + 0.003 * (square + 2 * 0.2**2)
    cx, cy = MONO.centre_px
    x, y = lens.rays(cx + 96 * np.array([[put_x]]), cy + 96 * np.array([[put_y]]), 0, shot, np.zeros((1, 1)))
    np.testing.assert_allclose(x, cx + 96 * true[0], atol=1e-6)
    np.testing.assert_allclose(y, cy + 96 * true[1], atol=1e-6)


def test_looking_to_the_right_moves_the_scene_to_the_left() -> None:
    x, _ = geometry.InjectedPoseError(ry=1.0).rays(
        np.array([[40.0]]), np.array([[30.0]]), 0, scene(), np.zeros((1, 1))
    )
    assert x[0, 0] == pytest.approx(40 + 96 * np.radians(1), abs=0.05 * 96 * np.radians(1) + 0.5)


def test_fringes_leave_green() -> None:
    fringes = geometry.InjectedLateralChromaticAberration(red=0.01, blue=-0.01)
    at = np.array([[80.0]]), np.array([[60.0]])
    moved = [fringes.rays(*at, channel, scene(COLOUR), at[1])[0][0, 0] for channel in range(3)]
    assert moved[0] < moved[1] == 80.0 < moved[2]


def test_rows_come_later_only_where_things_move() -> None:
    shutter = geometry.InjectedRollingShutter(50.0)
    still = seen(scene(), (shutter,))
    np.testing.assert_allclose(still, seen(scene(), ()))
    x, _ = shutter.rays(
        np.zeros((1, 1)), np.zeros((1, 1)), 0, scene(velocity=(400.0, 0.0)), np.full((1, 1), 50.0)
    )
    assert x[0, 0] == pytest.approx(-400 * 50 * 50e-6)


def test_conversion_gain_changes_noise_but_not_the_mean() -> None:
    clean, noisy = frames(flat(), count=16), frames(flat(), sensor.InjectedConversionGainError(2.0), count=16)
    assert noisy.mean() == pytest.approx(clean.mean(), abs=0.15)
    assert noisy.var(axis=0).mean() > 1.8 * clean.var(axis=0).mean()


@pytest.mark.parametrize(
    "effect", [sensor.InjectedPrnu(0.03), sensor.InjectedDsnu(3.0)], ids=lambda f: f.name
)
def test_fixed_patterns_repeat_over_frames_and_captures(effect: InjectedEffect) -> None:
    one = frames(flat(level=0.6), effect, count=8, seed=1).mean(axis=0)
    other = frames(flat(level=0.5), effect, count=8, seed=2).mean(axis=0)
    assert np.corrcoef(one.ravel(), other.ravel())[0, 1] > 0.5


def test_dark_current_grows_with_time_in_the_same_pixels() -> None:
    effect = sensor.InjectedDarkCurrent(rate_dn_s=20.0, hot_share=0.002)
    short, long = (frames(IdealShot(MONO, dark, time), effect).mean(axis=0) for time in (50.0, 200.0))
    assert np.median(long) - np.median(short) == pytest.approx(3.0, abs=0.6)
    hot = long > np.median(long) + 15
    assert 0 < hot.sum() < 0.01 * hot.size
    assert (short[hot] > np.median(short) + 3).mean() > 0.8


def test_bad_lines_stand_off_over_their_whole_length() -> None:
    change = difference(flat(), sensor.InjectedDefectLines(20.0, columns=2, rows=1), count=12)[..., 0]
    assert (np.median(change, axis=0) > 15).sum() == 2
    assert (np.median(change, axis=1) > 15).sum() == 1
    assert abs(np.median(change)) < 1


def test_coupling_correlates_noise_and_blur_does_not() -> None:
    def neighbours(*effects: InjectedEffect) -> float:
        noise = frames(flat(), *effects, count=8)
        noise = noise - noise.mean(axis=0)
        return float((noise[:, 1:] * noise[:, :-1]).mean() / (noise**2).mean())

    assert neighbours(sensor.InjectedCrosstalk(0.03)) > 0.05
    assert abs(neighbours(light.InjectedLensBlur(1.0))) < 0.02


def test_a_full_well_cuts_off_with_a_spike() -> None:
    taken = frames(flat(level=0.8), sensor.InjectedSaturation(200.0))
    assert taken.max() == 200
    assert (taken == 200).mean() > 0.3


def test_a_bent_response_bends() -> None:
    change = [
        difference(flat(level=level), sensor.InjectedNonlinearity(a2=-0.1)).mean() for level in (0.2, 0.8)
    ]
    assert change[0] == pytest.approx(-0.1 * 0.04 * MONO.range_dn, abs=0.4)
    assert change[1] == pytest.approx(-0.1 * 0.64 * MONO.range_dn, abs=0.8)


def test_row_noise_is_there_in_the_dark_and_flicker_is_not() -> None:
    def rows(*effects: InjectedEffect) -> float:
        return float(frames(IdealShot(MONO, dark, 10.0), *effects).mean(axis=2).var(axis=1).mean())

    clean = rows()
    assert rows(sensor.InjectedRowNoise(1.0)) > 5 * clean
    assert rows(light.InjectedFlicker(0.3, 40.0)) < 1.5 * clean


def test_a_pedestal_shifts_the_dark() -> None:
    assert difference(
        IdealShot(MONO, dark, 10.0), sensor.InjectedBlackLevelError(3.0)
    ).mean() == pytest.approx(3, abs=0.15)


def test_coarse_steps_leave_a_comb_and_floor_half_a_code_less() -> None:
    assert (frames(flat(), sensor.InjectedQuantisation(4.0)) % 4 == 0).mean() > 0.99
    floored = difference(flat(), sensor.InjectedQuantisation(1.0, "floor"), count=16)
    assert floored.mean() == pytest.approx(-0.5, abs=0.12)


def test_gains_and_matrices_act_on_colours_alone() -> None:
    grey = flat(COLOUR, level=0.4)
    gained = difference(grey, processing.InjectedWhiteBalance(1.2, 0.9)).mean(axis=(0, 1))
    np.testing.assert_allclose(gained, 0.4 * COLOUR.range_dn * np.array([0.2, 0, -0.1]), atol=0.6)
    matrix = ((1.4, -0.2, -0.2), (-0.1, 1.2, -0.1), (0.0, -0.3, 1.3))
    assert np.abs(difference(grey, processing.InjectedColourMatrix(matrix)).mean(axis=(0, 1))).max() < 0.4


def test_a_mosaic_keeps_even_colours() -> None:
    shot = IdealShot(COLOUR, lambda x, y, c: np.full(x.shape, (90.0, 60.0, 30.0)[c]), 10.0)
    for method in ("bilinear", "edge-aware"):
        filled = frames(shot, processing.InjectedDemosaicing(method), count=16).mean(axis=(0, 1, 2))
        np.testing.assert_allclose(filled, np.array([90.0, 60.0, 30.0]) + COLOUR.black_dn, atol=0.5)


def test_denoising_takes_noise_and_sharpening_adds_it() -> None:
    clean = frames(flat(), count=8).var(axis=0).mean()
    assert frames(flat(), processing.InjectedDenoising(1.0), count=8).var(axis=0).mean() < 0.5 * clean
    assert frames(flat(), processing.InjectedSharpening(0.8), count=8).var(axis=0).mean() > 1.5 * clean


def test_a_display_curve_lifts_shadows() -> None:
    change = difference(flat(level=0.1), processing.InjectedToneCurve(0.5)).mean()
    assert change == pytest.approx((np.sqrt(0.1) - 0.1) * MONO.range_dn, rel=0.05)


def test_jpeg_leaves_a_grid_of_eight() -> None:
    shot = flat()
    taken = frames(shot, processing.InjectedJpeg(30), count=8)
    jumps = np.abs(np.diff(taken, axis=2)).mean(axis=(0, 1, 3))
    assert jumps[7::8].mean() > 2 * np.delete(jumps, np.s_[7::8]).mean()


@pytest.mark.parametrize("name", available())
def test_independent_makers_change_the_image_more_the_stronger_they_are(name: str) -> None:
    variant = VARIANTS[name]
    shot = scene(COLOUR, velocity=(400.0, 100.0))

    def change(amplitude: float) -> float:
        effect = variant.entry.build(amplitude, np.random.default_rng(0))
        return float(np.abs(frames(shot, effect, count=1) - frames(shot, count=1)).mean())

    assert variant.effect in CATALOGUE
    strong = change(variant.entry.field[1])
    assert strong > 0.02
    if variant.entry.field[0] < variant.entry.field[1] and name != "lensfun lens":
        assert strong > 0.9 * change(variant.entry.field[0])


def corners(shots: Sequence[IdealShot]) -> int:
    import cv2

    found = 0
    for shot in shots:
        image = frames(shot, count=1)[0, ..., 0].astype(np.uint8)
        found += bool(cv2.findChessboardCornersSB(image, (9, 6))[0])
    return found


def test_boards_are_found_by_a_detector() -> None:
    camera = IdealCamera(320, 240, focal_px=330.0, channels=1)
    rng = np.random.default_rng(0)
    shots = [IdealShot(camera, flat_scenes.board(camera, rng), 10.0, has_pose=False) for _ in range(6)]
    assert corners(shots) >= 5
