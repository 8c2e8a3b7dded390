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
from tacos_validation.blind.generators.camera import IdealCamera, IdealShot, dark
from tacos_validation.blind.generators.catalogue import CATALOGUE
from tacos_validation.blind.generators.image_formation import expected, seen
from tacos_validation.blind.generators.independent import VARIANTS, available
from tacos_validation.blind.generators.injected_effect import InjectedEffect
from tests.validation.blind.ideal_frames import COLOUR, MONO, difference, flat, frames, scene

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


@pytest.mark.parametrize("effect", NEUTRAL, ids=lambda effect: effect.name)
def test_a_neutral_effect_is_none(effect: InjectedEffect) -> None:
    shot = scene(COLOUR)
    changed = frames(shot, effect, count=1)
    # those that draw noise of their own leave the others' noise elsewhere, but not larger
    assert abs((changed - expected(shot)).var() / (frames(shot, count=1) - expected(shot)).var() - 1) < 0.05
    assert abs((changed - frames(shot, count=1)).mean()) < 0.1


def test_all_of_the_catalogue_has_a_maker() -> None:
    assert len(CATALOGUE) == 34
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
