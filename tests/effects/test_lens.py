"""Diffraction, depth of field and fall-off of a lens against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter

from tacos_framework import Camera
from tacos_framework import Lens as Projection
from tacos_framework.camera import rays_of_pixels
from tacos_framework.formation import in_image_units
from tacos_framework.values import ContextMissing, ImageContext, ImageGeometry
from tacos_plugins.effects.blur import airy_transfer, kernel_of
from tacos_plugins.effects.depth_of_field import blur_by_depth
from tacos_plugins.effects.lens import Lens
from tacos_plugins.effects.lens_light import relative_illumination
from tacos_plugins.effects.slight_blur import blur_in_two_passes, blur_slightly
from tests.effects.light_arrays import run

OFF = {"wavelength_nm": None, "out_of_focus": 0.0, "fall_off": 0.0}


def behind(projection: Projection, width_px=161, height_px=121, **changes) -> ImageGeometry:
    return ImageGeometry(
        width_px,
        height_px,
        **{
            "focal_length_px": 80.0,
            "centre_px": ((width_px - 1) / 2, (height_px - 1) / 2),
            "pixel_um": 3.0,
            "lens": projection,
            **changes,
        },
    )


@pytest.mark.parametrize("f_number", [1.4, 2.8, 5.6])
@pytest.mark.parametrize("frequency", [0.1, 0.25, 0.4])
def test_bars_keep_the_contrast_that_diffraction_leaves(f_number, frequency):
    geometry = behind(Projection(), 128, 96)
    bars = np.cos(2 * np.pi * frequency * np.arange(128.0)) * np.ones((96, 1))
    seen = run(
        Lens,
        3 + bars[None, ..., None],
        **OFF | {"wavelength_nm": 550.0},
        geometry=geometry,
        context=ImageContext(f_number=f_number),
    )
    middle = np.s_[30:-30]
    kept = np.linalg.lstsq(bars[:, middle].ravel()[:, None], seen[0, :, middle, 0].ravel() - 3, rcond=None)
    share = frequency * 0.55 * f_number / 3.0
    closed = 2 / math.pi * (math.acos(share) - share * math.sqrt(1 - share**2))  # Goodman, eq. 6-31
    assert kept[0][0] == pytest.approx(closed, abs=0.015)


@pytest.mark.parametrize("detail_px", [0.12, 0.2, 0.5, 1.5])
def test_two_passes_have_the_transfer_of_the_whole(detail_px):
    lamp = np.zeros((1, 257, 257, 1))
    lamp[0, 192, 192], lamp[0, 0, 0] = (
        1.0,
        -1.0,
    )  # light stays within its range: a kernel is below 0 in places
    airy = airy_transfer(1 / detail_px)
    spread = blur_in_two_passes(lamp, kernel_of(airy, reach_px=8 * detail_px))[0, 128:, 128:, 0]
    frequency = np.fft.fftfreq(129)
    closed = airy(frequency[None, :], frequency[:, None])
    inner = np.hypot(frequency[None, :], frequency[:, None]) < 0.4
    assert np.abs(np.abs(np.fft.fft2(spread)) - closed)[inner].max() < 0.03


def test_discs_are_those_of_a_thin_lens():
    """50 mm at f/4 on pixels of 5 um, focused on 5 m: at 4 m discs are f^2/N |1/s-1/Z| / (1-f/s) wide."""
    geometry = behind(Projection(), 97, 97, focal_length_px=1e4, pixel_um=5.0)
    lamp = np.zeros((1, 97, 97, 1))
    lamp[0, 48, 48] = 1.0
    spread = run(
        Lens,
        lamp,
        **OFF | {"out_of_focus": 1.0, "focus_m": 5.0},
        geometry=geometry,
        context=ImageContext(f_number=4.0, depth_m=np.full((97, 97), 4.0)),
    )[0, ..., 0]
    width_px = 0.05**2 / 4 * (1 / 4 - 1 / 5) / (1 - 0.05 / 5) / 5e-6
    place = np.arange(97.0) - 48
    assert spread.sum(axis=0) @ place**2 == pytest.approx((width_px / 2) ** 2 / 4, rel=0.05)


def test_a_lens_without_a_focus_stands_at_its_hyperfocal_distance():
    """Infinity and half that distance then have the discs of two photosites, whatever they are binned to."""
    f_m, f_number, pixel_m = 4e-3, 2.0, 3e-6
    hyperfocal_m = f_m**2 / (f_number * 2 * pixel_m) + f_m
    lens = Lens(Lens.Config())
    geometry = behind(Projection(), focal_length_px=f_m / pixel_m)
    assert lens._focus_m(geometry, f_number) == pytest.approx(hyperfocal_m)
    lamp = np.zeros((1, 97, 97, 1), np.float64)
    lamp[0, 48, 48] = 1.0
    for depth_m in (np.inf, hyperfocal_m / 2):
        spread = run(
            Lens,
            lamp,
            **OFF | {"out_of_focus": 1.0},
            geometry=behind(Projection(), 97, 97, focal_length_px=f_m / pixel_m),
            context=ImageContext(f_number=f_number, depth_m=np.full((97, 97), depth_m)),
        )[0, ..., 0]
        assert spread.sum(axis=1) @ (np.arange(97.0) - 48) ** 2 == pytest.approx(1 / 4, rel=0.01)


@settings(max_examples=20, deadline=None)
@given(st.floats(0.2, 1.9), st.integers(0, 99))
def test_slight_blur_is_that_of_layers_where_depth_is_even(radius_px, seed):
    light = gaussian_filter(np.random.default_rng(seed).uniform(1, 9, (1, 40, 40, 1)), (0, 1, 1, 0))
    radii = np.full((1, 40, 40), -radius_px)
    inside = np.s_[:, 6:-6, 6:-6]
    np.testing.assert_allclose(
        blur_slightly(light, radii)[inside], blur_by_depth(light, radii)[inside], atol=0.03
    )


def test_what_is_sharp_stays_so_beside_a_slight_blur():
    light = np.random.default_rng(1).uniform(1, 9, (1, 20, 40, 3)).astype(np.float32)
    radii = np.where(np.arange(40) < 20, 0.0, 1.2)[None, None] * np.ones((1, 20, 1))
    seen = blur_slightly(light, radii)
    np.testing.assert_array_equal(seen[:, :, :20], light[:, :, :20])
    assert np.abs(seen[:, :, 20:] - light[:, :, 20:]).mean() > 0.3


def solid_angle_per_pixel(geometry: ImageGeometry) -> np.ndarray:
    """(H, W) by the directions of neighbouring places [sr], over that on the axis."""
    y, x = np.mgrid[: geometry.height_px, : geometry.width_px].astype(float)

    def rays(dx, dy):
        return rays_of_pixels(np.stack([x + dx, y + dy], axis=-1), geometry)

    across, down = (rays(0.01, 0) - rays(-0.01, 0)) / 0.02, (rays(0, 0.01) - rays(0, -0.01)) / 0.02
    return np.linalg.norm(np.cross(across, down), axis=-1) * geometry.focal_length_px**2


@pytest.mark.parametrize(
    ("projection", "closed"),
    [
        (Projection(), lambda t: np.cos(t) ** 4),
        (Projection("equidistant"), lambda t: np.sinc(t / np.pi)),
        (Projection("equisolid"), np.ones_like),
        (Projection("stereographic"), lambda t: np.cos(t / 2) ** 4),
    ],
    ids=lambda each: getattr(each, "projection", ""),
)
def test_light_falls_off_by_the_law_of_the_projection(projection, closed):
    geometry = behind(projection)
    angle = projection.angle(np.hypot(geometry.x_px, geometry.y_px) / 80.0)
    np.testing.assert_allclose(relative_illumination(geometry), closed(angle), atol=1e-6)


@pytest.mark.parametrize(
    "projection",
    [
        Projection("rectilinear", (-0.2, 0.04)),
        Projection("kannala-brandt", (-0.003, 0.054, -0.052, 0.011)),
    ],
    ids=lambda each: each.projection,
)
def test_light_of_a_solid_angle_falls_on_its_pixel(projection):
    """By the function that takes pixels to rays, which knows nothing of the law."""
    geometry = behind(projection, focal_length_px=90.0)
    expected = solid_angle_per_pixel(geometry)
    if projection.is_rectilinear:
        y, x = np.mgrid[:121, :161]
        expected = expected * rays_of_pixels(np.stack([x, y], axis=-1), geometry)[..., 2]
    np.testing.assert_allclose(relative_illumination(geometry), expected, atol=2e-4)


def test_nothing_falls_beyond_the_image_circle():
    geometry = behind(Projection("equisolid", half_field_deg=40))
    light = run(Lens, np.ones((1, 121, 161, 3)), **OFF | {"fall_off": 1.0}, geometry=geometry)
    outside = np.hypot(geometry.x_px, geometry.y_px) > 80.0 * 2 * math.sin(math.radians(20))
    assert np.all(light[0][outside] == 0)
    np.testing.assert_allclose(light[0][~outside], 1.0, atol=1e-6)


def test_figures_are_those_of_the_camera_whatever_it_is_binned_to():
    """A wall out of focus: binned by two, the spread in um is the same."""
    camera = Camera("c", 128, 96, pixel_um=3.0, focal_length_mm=6.0)
    binned = Camera("c", 64, 48, pixel_um=3.0, focal_length_mm=6.0, binning=2.0)
    settings_of_sites = Lens.Config(wavelength_nm=None, fall_off=0.0)

    def spread_um(camera):
        geometry = ImageGeometry.of_camera(camera)
        shape = (camera.height_px, camera.width_px)
        context = ImageContext(f_number=2.0, depth_m=np.full(shape, 0.6))
        effect = Lens(in_image_units(settings_of_sites, "lens", geometry, context))
        edge = (np.arange(shape[1]) >= shape[1] / 2) * np.ones((1, *shape[:1], 1))
        seen = effect.on_array(
            edge[..., None], geometry=geometry, context=context, rng=np.random.default_rng(0)
        )
        line = np.diff(seen[0, shape[0] // 2, :, 0])
        place = np.arange(len(line)) * camera.pixel_um * camera.binning
        mean = line @ place
        return math.sqrt(line @ (place - mean) ** 2)

    assert spread_um(binned) == pytest.approx(spread_um(camera), rel=0.05)


@pytest.mark.parametrize(
    ("config", "context", "said"),
    [
        ({"wavelength_nm": 550.0}, ImageContext(), "effect.lens needs the f-number"),
        ({"out_of_focus": 1.0}, ImageContext(f_number=2.0), "effect.lens with out_of_focus needs the depth"),
    ],
)
def test_it_says_what_it_needs(config, context, said):
    with pytest.raises(ContextMissing, match=said):
        run(Lens, np.ones((1, 121, 161, 1)), **OFF | config, geometry=behind(Projection()), context=context)


def test_it_says_what_it_assumes_of_a_lens():
    camera = Camera("c", 64, 48, pixel_um=3.0, focal_length_mm=2.0)
    fisheye = Camera("c", 64, 48, pixel_um=3.0, focal_length_mm=2.0, lens=Projection("equidistant"))
    lens = Lens(Lens.Config())
    assert lens.origins(camera) == {
        "sharpness": "assumed to be limited by diffraction",
        "focus": "assumed at the hyperfocal distance",
        "fall-off": "assumed to be natural (cos^4)",
    }
    assert "equidistant" in lens.origins(fisheye)["fall-off"]
    assert Lens(Lens.Config(focus_m=0.7)).origins(camera)["focus"] == "at 0.7 m, as the recipe sets"
    assert Lens(Lens.Config(**OFF)).origins(camera) == {}
