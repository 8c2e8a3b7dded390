"""Blurred print: the blur, and the ink it would be without."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy import ndimage
from skimage.morphology import disk

from tacos_gap.captures import Noise
from tacos_gap.captures.targets.two_tone import darkness, find_print, paper_level, with_print
from tests.gap.taken import capture

DATA = Path(__file__).parents[5] / "shared" / "data" / "real" / "opencv_blur"

PAPER_DN, INK_DN = 180.0, 45.0


def page(height_px: int = 200, width_px: int = 300) -> np.ndarray:
    """Lines of print, drawn four times as large and averaged; float32 from 0 (paper) to 1 (ink)."""
    large = np.zeros((4 * height_px, 4 * width_px), np.uint8)
    for line in range(height_px // 34 + 1):
        words = "the probability of a given value is computed"[line:]
        origin = (40 + 60 * (line % 3), 130 * line + 90)
        cv2.putText(large, words, origin, cv2.FONT_HERSHEY_DUPLEX, 2.6, 255, 8, cv2.LINE_AA)
    return cv2.resize(large, (width_px, height_px), interpolation=cv2.INTER_AREA).astype(np.float32) / 255


def line_kernel(length_px: int, angle_deg: float) -> np.ndarray:
    """A line by turning a row of ones."""
    row = np.zeros((2 * length_px + 1,) * 2)
    row[length_px, length_px - length_px // 2 : length_px + length_px // 2 + 1] = 1
    turned = ndimage.rotate(row, -angle_deg, reshape=False, order=1)
    return turned / turned.sum()


def photographed(ink: np.ndarray, noise_dn: float = 1.0) -> np.ndarray:
    """Ink on paper under light that falls off to one side, with noise and whole digital numbers."""
    light = np.linspace(1.0, 0.8, ink.shape[1])
    seen = light * (PAPER_DN + (INK_DN - PAPER_DN) * ink)
    return np.round(seen + np.random.default_rng(5).normal(0, noise_dn, ink.shape)).astype(np.float32)


def print_in(picture: np.ndarray):
    return find_print(darkness(picture, paper_level(picture)))


@pytest.mark.parametrize("radius_px", [3, 5, 8])
def test_a_disc_is_found_with_its_radius(radius_px):
    kernel = disk(radius_px).astype(float)
    found = print_in(photographed(ndimage.convolve(page(), kernel / kernel.sum())))
    assert found is not None
    assert found.blur.family == "disc"
    assert found.blur.size_px == pytest.approx(radius_px, rel=0.15)


@pytest.mark.parametrize(("length_px", "angle_deg"), [(11, 90), (15, 0), (15, 40)])
def test_a_line_is_found_with_its_length_and_direction(length_px, angle_deg):
    found = print_in(photographed(ndimage.convolve(page(), line_kernel(length_px, angle_deg))))
    assert found is not None
    assert found.blur.family == "line"
    assert found.blur.size_px == pytest.approx(length_px, rel=0.2)
    assert abs((found.blur.angle_deg - angle_deg + 90) % 180 - 90) <= 8


def test_the_ink_is_where_it_was_printed():
    ink = page()
    kernel = disk(4).astype(float)
    found = print_in(photographed(ndimage.convolve(ink, kernel / kernel.sum())))
    inside = (slice(30, -30), slice(30, -30))
    blurred = np.corrcoef(ndimage.convolve(ink, kernel)[inside].ravel(), ink[inside].ravel())[0, 1]
    restored = np.corrcoef(found.ink[inside].ravel(), ink[inside].ravel())[0, 1]
    assert restored > 0.85 > blurred


def test_grey_pictures_are_no_print():
    rng = np.random.default_rng(1)
    clouds = sum(ndimage.gaussian_filter(rng.normal(size=(256, 320)), s) * s for s in (2, 4, 8, 16, 32))
    grey = np.clip(110 + 40 * clouds / clouds.std(), 0, 255).astype(np.float32)
    assert print_in(grey) is None
    assert print_in(np.full((200, 200), 90.0, np.float32)) is None


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_small_smooth_texture_is_no_print(seed):
    """The border that fades out is no paper: it is most of a small picture."""
    texture = ndimage.gaussian_filter(np.random.default_rng(seed).random((120, 160)), 1.5)
    assert print_in((30 + 190 * (texture - texture.min()) / np.ptp(texture)).astype(np.float32)) is None


def test_a_capture_expects_sharp_print_and_says_nothing_of_its_place():
    kernel = disk(4).astype(float)
    picture = photographed(ndimage.convolve(page(), kernel / kernel.sum()))
    taken = replace(
        capture("edge", 0.0),
        real_dn=picture[None, ..., None],
        expected_dn=None,
        valid=np.ones(picture.shape, bool),
        noise=Noise((0.0,), (1.0,), known=False),
    )
    taken = replace(taken, context=replace(taken.context, black_level_dn=0.0))
    found = with_print(taken)
    assert found is not None
    assert found.own_edges
    seen = found.expected_dn[0, found.valid, 0]
    assert np.percentile(seen, 90) == pytest.approx(PAPER_DN * 0.9, rel=0.1)
    assert np.percentile(seen, 1) < 0.6 * PAPER_DN
    small = replace(taken, real_dn=taken.real_dn[:, :60, :60], valid=taken.valid[:60, :60])
    assert with_print(small) is None


@pytest.mark.skipif(not DATA.is_dir(), reason=f"the pictures of print are not at {DATA}")
@pytest.mark.parametrize(("file", "family"), [("text_motion.jpg", "line"), ("text_defocus.jpg", "disc")])
def test_the_blur_of_real_print_is_named(file, family):
    picture = cv2.imread(str(DATA / file), cv2.IMREAD_GRAYSCALE).astype(np.float32)
    found = print_in(picture)
    assert found is not None
    assert found.blur.family == family
