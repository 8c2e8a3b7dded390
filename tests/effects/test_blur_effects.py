"""Defocus, lens blur and motion blur."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.ndimage import gaussian_filter
from scipy.special import j1

from tacos_framework.values import ContextMissing, ImageContext, ImageGeometry
from tacos_plugins.effects import blur
from tacos_plugins.effects.defocus import Defocus
from tacos_plugins.effects.depth_of_field import signed_radius
from tacos_plugins.effects.lens_blur import LensBlur
from tacos_plugins.effects.motion_blur import MotionBlur
from tests.effects.light_arrays import GEOMETRY, INSIDE, light, run


def wave(frequency_x, frequency_y=0.0):
    return light(lambda x, y: 3 + np.cos(2 * np.pi * (frequency_x * x + frequency_y * y)), channels=1)


def contrast(before, after):
    a, b = (image[INSIDE] - image[INSIDE].mean() for image in (before, after))
    return float((a * b).sum() / (a * a).sum())


@pytest.mark.parametrize("frequency", [0.0625, 0.125, 0.25, 0.375])
@pytest.mark.parametrize("radius_px", [0.4, 0.7, 1.1, 2.0, 4.5])
def test_defocus_is_an_even_disc_the_same_in_all_directions(radius_px, frequency):
    z = 2 * np.pi * radius_px * frequency
    for frequencies in [(frequency, 0.0), (0.0, frequency)]:
        before = wave(*frequencies)
        found = contrast(before, run(Defocus, before, radius_px=radius_px))
        assert found == pytest.approx(2 * j1(z) / z, abs=0.008)


@pytest.mark.parametrize("radius_px", [0.3, 1.0, 2.5, 7.0])
@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])  # of light: cd/m2 in studies, digital numbers in captures
def test_a_lamp_out_of_focus_has_no_dark_ring(radius_px, unit):
    lamp = np.full((1, 72, 96, 1), 20.0)
    lamp[:, :, :12] = 0.0  # so that the range of the frame hides no ring
    lamp[:, 36, 48] = 1e5
    spread = run(Defocus, lamp * unit, radius_px=radius_px) / unit
    assert spread[:, :, 24:].min() > 0.9 * 20
    assert spread.sum() == pytest.approx(lamp.sum(), rel=1e-3)


def test_defocus_follows_from_focus_aperture_and_depth():
    geometry = ImageGeometry(96, 72, focal_length_px=2000.0, centre_px=(47.5, 35.5), pixel_um=4.0)  # 8 mm
    depth = np.broadcast_to(np.where(np.arange(96) < 48, 1.0, 3.0), (72, 96))
    context = ImageContext(f_number=4.0, depth_m=depth)
    before = wave(0.125)
    after = run(Defocus, before, focus_m=1.0, geometry=geometry, context=context)
    np.testing.assert_allclose(after[:, :, :40], before[:, :, :40], atol=0.05)
    f, n = 8e-3, 4.0
    radius_px = f**2 / n * (3.0 - 1.0) / (3.0 * (1.0 - f)) / 2 / 4e-6
    z = 2 * np.pi * radius_px * 0.125
    part = np.s_[:, 12:60, 60:84]
    a, b = (image[part] - 3 for image in (before, after))
    assert (a * b).sum() / (a * a).sum() == pytest.approx(2 * j1(z) / z, abs=0.03)


def test_a_larger_f_number_is_sharper():
    context = ImageContext(f_number=2.0, depth_m=np.full((72, 96), 0.3))
    before = wave(0.2)
    geometry = ImageGeometry(96, 72, focal_length_px=1000.0, centre_px=(47.5, 35.5), pixel_um=4.0)
    wide = run(Defocus, before, focus_m=1.0, context=context, geometry=geometry)
    narrow = run(Defocus, before, focus_m=1.0, f_number=16.0, context=context, geometry=geometry)
    assert contrast(before, narrow) > contrast(before, wide) + 0.1


def test_focus_asks_for_what_it_needs():
    with pytest.raises(ContextMissing, match="depth"):
        run(Defocus, wave(0.1), focus_m=1.0)
    with pytest.raises(ContextMissing, match="f-number"):
        run(Defocus, wave(0.1), focus_m=1.0, context=ImageContext(depth_m=np.ones((72, 96))))
    with pytest.raises(ValidationError, match="exclude each other"):
        Defocus.Config(radius_px=1.0, focus_m=1.0)


def test_lens_blur_is_a_gaussian():
    image = np.random.default_rng(0).uniform(0, 10, (1, 72, 96, 1))
    found = run(LensBlur, image, sigma_px=1.5)[INSIDE][0, ..., 0]
    expected = gaussian_filter(image[0, :, :, 0], 1.5, truncate=6)[12:-12, 12:-12]
    np.testing.assert_allclose(found, expected, atol=0.02)


def test_it_grows_from_the_axis_to_the_corner():
    before = wave(0.1, 0.05)
    after = run(LensBlur, before, sigma_px=0.8, growth=1.5)
    r = GEOMETRY.radius
    sigma = 0.8 * (1 + 1.5 * r**2)
    expected = 3 + np.exp(-2 * (np.pi * sigma) ** 2 * (0.1**2 + 0.05**2)) * (before[0, ..., 0] - 3)
    np.testing.assert_allclose(after[0, 12:-12, 12:-12, 0], expected[12:-12, 12:-12], atol=0.015)


def test_it_is_the_same_in_a_crop():
    crop = GEOMETRY.crop(x=40, y=20, width_px=50, height_px=40)
    whole = run(LensBlur, wave(0.1), sigma_px=0.8, growth=1.5)
    part = run(LensBlur, wave(0.1)[:, 20:60, 40:90], sigma_px=0.8, growth=1.5, geometry=crop)
    np.testing.assert_allclose(part[INSIDE], whole[:, 20:60, 40:90][INSIDE], atol=0.01)


def test_diffraction_stops_at_its_cut_off():
    # 1 um at f/6 and 3 um pixels: 1 / (lambda N) is half a cycle per pixel.
    context = ImageContext(f_number=6.0)
    for frequency, expected in [(0.25, 0.3910), (0.45, 0.0374)]:
        before = wave(frequency)
        after = run(LensBlur, before, wavelength_nm=1000.0, context=context)
        assert contrast(before, after) == pytest.approx(expected, abs=0.015)
    before = wave(0.3)  # at f/12 all is lost from a quarter on
    after = run(LensBlur, before, wavelength_nm=1000.0, context=ImageContext(f_number=12.0))
    assert contrast(before, after) == pytest.approx(0.0, abs=0.01)
    with pytest.raises(ContextMissing, match="f-number"):
        run(LensBlur, before, wavelength_nm=500.0)


def test_motion_blurs_along_its_direction_alone():
    along, across = wave(0.1), wave(0.0, 0.1)
    assert contrast(along, run(MotionBlur, along, length_px=6.0)) == pytest.approx(np.sinc(0.6), abs=0.015)
    assert contrast(across, run(MotionBlur, across, length_px=6.0)) == pytest.approx(1.0, abs=0.01)
    down = run(MotionBlur, across, length_px=6.0, angle_deg=90.0)
    assert contrast(across, down) == pytest.approx(np.sinc(0.6), abs=0.015)


def test_motion_downwards_to_the_right_is_at_45_degrees():
    along, across = wave(0.08, 0.08), wave(0.08, -0.08)
    frequency = 0.08 * np.sqrt(2)
    blurred = run(MotionBlur, along, length_px=5.0, angle_deg=45.0)
    assert contrast(along, blurred) == pytest.approx(np.sinc(5 * frequency), abs=0.015)
    assert contrast(across, run(MotionBlur, across, length_px=5.0, angle_deg=45.0)) > 0.98


def test_no_blur_shifts_the_image():
    spot = np.zeros((1, 72, 96, 1))
    spot[0, 36, 48] = 1.0
    for effect, settings in [
        (MotionBlur, {"length_px": 7.3, "angle_deg": 20.0}),
        (Defocus, {"radius_px": 3.2}),
        (LensBlur, {"sigma_px": 1.7}),
    ]:
        after = run(effect, spot, **settings)[0, :, :, 0]
        y, x = np.mgrid[:72, :96]
        assert (after * x).sum() / after.sum() == pytest.approx(48, abs=0.02)
        assert (after * y).sum() / after.sum() == pytest.approx(36, abs=0.02)


@pytest.mark.parametrize(("focal_mm", "f_number", "circle_um"), [(3.6, 2.0, 3.1), (50.0, 2.8, 30.0)])
def test_the_blur_at_the_hyperfocal_distance_is_that_of_the_textbook(focal_mm, f_number, circle_um):
    """Focused on H = f^2 / (N c) + f, the circle c is reached at H / 2 and at infinity (Greenleaf 1950)."""
    geometry = ImageGeometry(8, 8, focal_mm * 1e3, (3.5, 3.5), pixel_um=1.0)
    hyperfocal_m = (focal_mm**2 / (f_number * circle_um * 1e-3) + focal_mm) * 1e-3
    depth_m = np.array([hyperfocal_m / 2, hyperfocal_m, np.inf])
    radius_px = signed_radius(depth_m, geometry, f_number=f_number, focus_m=hyperfocal_m)
    assert 2 * radius_px == pytest.approx([-circle_um, 0.0, circle_um], rel=1e-6)


@pytest.mark.parametrize(
    ("effect", "config"), [(LensBlur, {"sigma_px": 1.3}), (MotionBlur, {"length_px": 5.0})]
)
def test_even_light_stays_as_it_is_and_is_not_convolved(effect, config, monkeypatch):
    even = light(lambda x, y: 0 * x + 0.1, channels=3)
    speck = even.copy()
    speck[:, 7, 9] += 1.0
    assert not np.array_equal(run(effect, speck, **config), speck)
    monkeypatch.setattr(blur.cv2, "filter2D", lambda *args, **kwargs: pytest.fail("convolved"))
    np.testing.assert_array_equal(run(effect, even, **config), even)
