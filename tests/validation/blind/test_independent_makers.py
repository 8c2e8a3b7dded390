"""Reference values of the independent makers: what each does to light, samples or codes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import fft, special

from tacos_validation.blind.generators import flat_scenes
from tacos_validation.blind.generators.camera import IdealCamera, IdealShot, Image, dark
from tacos_validation.blind.generators.geometric_effects import InjectedFocalLengthError, InjectedPoseError
from tacos_validation.blind.generators.image_formation import take
from tacos_validation.blind.generators.independent import VARIANTS, colour, lenses, pixels, sensing
from tacos_validation.blind.generators.injected_effect import InjectedEffect

MONO = IdealCamera(96, 72, focal_px=96.0, channels=1)
COLOUR = IdealCamera(96, 72, focal_px=96.0, channels=3)
RNG = np.random.default_rng


def flat(camera: IdealCamera = MONO, level: float = 0.5, exposure_ms: float = 10.0) -> IdealShot:
    return IdealShot(camera, flat_scenes.even(camera, level), exposure_ms)


def frames(shot: IdealShot, *effects: InjectedEffect, count: int = 8) -> Image:
    return take(shot, effects, count, RNG(1), sensor_seed=3)


def test_most_effects_have_an_independent_maker() -> None:
    assert len({variant.effect for variant in VARIANTS.values()}) >= 31


def test_a_perfect_pupil_passes_what_diffraction_theory_says() -> None:
    """Goodman 2005, eq. 6-32."""
    at, transfer = lenses.pupil_transfer(0.0)
    inside = at < 0.95
    rho = at[inside]
    theory = 2 / np.pi * (np.arccos(rho) - rho * np.sqrt(1 - rho**2))
    np.testing.assert_allclose(transfer[inside], theory, atol=0.012)


def test_an_aberrated_pupil_passes_less() -> None:
    at, perfect = lenses.pupil_transfer(0.0)
    _, aberrated = lenses.pupil_transfer(0.2)
    middle = (at > 0.1) & (at < 0.9)
    assert (aberrated[middle] < perfect[middle]).all()


def test_a_pupil_keeps_all_light() -> None:
    light = RNG(0).uniform(50, 100, (72, 96, 1))
    blurred = lenses.AberratedPupil(2.0).light(light, flat(), 0)
    assert blurred.mean() == pytest.approx(light.mean(), rel=1e-3)
    passed = np.abs(fft.fft2(blurred[..., 0])) / np.abs(fft.fft2(light[..., 0]))
    assert passed[0, 48] < 1e-6  # a period of two pixels is beyond the cut-off


def test_opencv_and_rotations_agree_on_a_pose() -> None:
    x, y = MONO.grid()
    pose = lenses.OpenCvPose(1.0)
    ours = InjectedPoseError(**pose.parameters)
    shot = IdealShot(MONO, dark, 10.0, depth_m=2.0)
    np.testing.assert_allclose(pose.rays(x, y, 0, shot, y), ours.rays(x, y, 0, shot, y), atol=1e-5)


def test_opencv_and_the_pinhole_agree_on_a_focal_length() -> None:
    x, y = MONO.grid()
    ours = InjectedFocalLengthError(scale=1.05)
    found = lenses.OpenCvFocalLength(0.05).rays(x, y, 0, flat(), y)
    np.testing.assert_allclose(found, ours.rays(x, y, 0, flat(), y), atol=1e-6)


def test_fringes_of_a_real_lens_are_radial_and_leave_green() -> None:
    pytest.importorskip("lensfunpy")
    x, y = COLOUR.grid()
    lens = lenses.RealFringes(20.0)
    green = lens.rays(x, y, 1, flat(COLOUR), y)
    np.testing.assert_allclose(green, (x, y), atol=2e-3)
    moved_x, moved_y = (a - b for a, b in zip(lens.rays(x, y, 0, flat(COLOUR), y), (x, y), strict=True))
    cx, cy = COLOUR.centre_px
    across = moved_x * (y - cy) - moved_y * (x - cx)
    assert np.abs(across).max() < 0.02 * np.hypot(moved_x, moved_y).max() * np.hypot(cx, cy)
    assert np.hypot(moved_x, moved_y)[0, 0] > 0.3


def test_planck_gives_the_balance_of_a_lamp() -> None:
    """The ratio of two black bodies at 595 and 475 nm, about where the camera's filters have their middle."""

    def planck(nm: float, kelvin: float) -> float:
        return float(1 / (nm**5 * np.expm1(1.438777e7 / (nm * kelvin))))

    cool, warm = 5500.0, 1e6 / (1e6 / 5500 + 200)
    lamp = colour.WarmerLamp(0.5).parameters
    wanted = planck(595, warm) * planck(475, cool) / planck(595, cool) / planck(475, warm)
    assert lamp["red"] / lamp["blue"] == pytest.approx(wanted, rel=0.15)
    assert lamp["red"] > 1 > lamp["blue"]
    assert colour.WarmerLamp(0.0).parameters == pytest.approx({"red": 1.0, "blue": 1.0})


def test_other_filters_keep_greys() -> None:
    matrix = np.array(colour.between_cameras())
    np.testing.assert_allclose(matrix.sum(axis=1), 1)
    assert 0.05 < np.abs(matrix - np.eye(3)).max() < 2


def test_an_avalanche_adds_noise_in_proportion_to_the_signal() -> None:
    for level in (0.2, 0.6):
        clean, noisy = (frames(flat(level=level), *e, count=24) for e in ((), (pixels.AvalancheGain(0.5),)))
        assert noisy.mean() == pytest.approx(clean.mean(), abs=0.2)
        added = noisy.var(axis=0).mean() - clean.var(axis=0).mean()
        assert added == pytest.approx(0.5 * MONO.photon_dn * level * MONO.range_dn, rel=0.15)


def test_wells_are_full_at_levels_of_their_own() -> None:
    full = frames(flat(level=0.95), pixels.UnevenFullWells(0.2))
    assert full.mean() == pytest.approx(MONO.black_dn + 0.8 * MONO.range_dn, abs=0.5)
    assert full.var(axis=0).mean() < 0.1
    assert full.mean(axis=0).std() == pytest.approx(0.004 * 0.8 * MONO.range_dn, rel=0.2)


def test_dark_current_has_its_mean_and_hot_pixels() -> None:
    added = frames(IdealShot(MONO, dark, 1000.0), pixels.UnevenDarkCurrent(20.0)).mean(axis=0) - MONO.black_dn
    assert np.median(added) == pytest.approx(20.0 * np.exp(-0.045), rel=0.05)


def test_offsets_have_heavy_tails() -> None:
    added = pixels.HeavyTailedOffsets(2.0).charge(np.zeros((400, 400, 1)), flat(), RNG(0))
    assert added.std() == pytest.approx(2.0, rel=0.03)
    assert (np.abs(added) > 8).mean() > 20 * special.erfc(4 / np.sqrt(2))


def test_charge_diffuses_to_neighbours_and_none_is_lost() -> None:
    point = np.zeros((9, 9, 1))
    point[4, 4] = 100
    spread = pixels.ChargeDiffusion(0.02).samples(point, flat(), RNG(0))[..., 0]
    assert spread.sum() == pytest.approx(100)
    assert spread[4, 5] == pytest.approx(2.0)
    assert spread[5, 5] == pytest.approx(1.0)


def test_a_table_leaves_out_codes_and_is_monotone() -> None:
    codes = np.arange(256.0).reshape(16, 16, 1)
    given = pixels.UnevenCodes(4.0).codes(codes, flat(), RNG(0)).ravel()
    assert (np.diff(given) >= 0).all()
    assert len(np.unique(given)) == pytest.approx(64, abs=2)
    assert np.abs(given - codes.ravel()).max() <= 3.6


def test_a_clamped_pedestal_shifts_by_its_mean() -> None:
    shifted = frames(flat(), pixels.ClampedPedestal(5.0), count=24).mean() - frames(flat(), count=24).mean()
    assert shifted == pytest.approx(5.0, abs=0.15)


def test_rows_of_a_block_share_their_moment() -> None:
    rows = np.arange(12.0)[:, None]
    shot = IdealShot(MONO, dark, 10.0, velocity_px_s=(1000.0, 0.0))
    x, _ = pixels.BlockReadout(100.0).rays(np.zeros((12, 1)), rows, 0, shot, rows)
    np.testing.assert_allclose(x.ravel(), -0.4 * (np.arange(12) // 4))


def test_a_shading_table_lifts_corners_and_leaves_the_middle() -> None:
    codes = np.full((72, 96, 1), 116.0)
    lifted = pixels.ErfShading(1.0).codes(codes, flat(), RNG(0))[..., 0]
    assert lifted[36, 48] == pytest.approx(116.0, abs=0.1)
    rise = (special.erf(0.25 / 0.4) - special.erf(-0.75 / 0.4)) / 2
    assert lifted[0, 0] == pytest.approx(16 + 100 * (1 + rise), rel=0.02)


@pytest.mark.parametrize(
    ("maker", "measure"),
    [
        (sensing.LognormalPixels(0.02), lambda a: a.std() / a.mean()),
        (sensing.DriftingRows(0.8), lambda a: a.std()),
    ],
)
def test_parameters_are_what_the_makers_do(maker: InjectedEffect, measure: object) -> None:
    if isinstance(maker, sensing.LognormalPixels):
        changed = maker.charge(np.full((400, 400, 1), 100.0), flat(), RNG(0))
    else:
        changed = maker.samples(np.zeros((40000, 2, 1)), flat(), RNG(0))
    (true,) = maker.parameters.values()
    assert measure(changed) == pytest.approx(true, rel=0.03)  # type: ignore[operator]
