"""ColorCheckers: found however they lie, and read under a light that nobody measured."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from skimage.transform import ProjectiveTransform, warp

from tacos_gap.captures.targets.chart import (
    find_chart,
    light_on,
    patch_colours,
    patch_errors,
    reference_colours,
)
from tacos_gap.captures.targets.expectation import with_own_expectations
from tests.gap.taken import capture

DATA = Path(__file__).parents[5] / "shared" / "data" / "real"
PATCH, GAP = 40, 8


def drawn() -> np.ndarray:
    """The chart in linear light, white at 0.9, in a dark frame."""
    step = PATCH + GAP
    chart = np.full((4 * step + GAP, 6 * step + GAP, 3), 0.02)
    for k, colour in enumerate(reference_colours()):
        row, column = divmod(k, 6)
        chart[GAP + row * step :, GAP + column * step :][:PATCH, :PATCH] = colour
    return chart


def photographed(turn_deg: float, tilt: float = 0.0, size=(480, 640)) -> tuple[np.ndarray, np.ndarray]:
    """The chart on grey paper, turned and tilted, and the centre of its dark skin in the picture."""
    chart = drawn()
    height, width = chart.shape[:2]
    turn = np.radians(turn_deg)
    rotation = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    to_middle = np.array([[1, 0, -width / 2], [0, 1, -height / 2], [0, 0, 1]])
    view = np.array([[1, 0, size[1] / 2], [0, 1, size[0] / 2], [0, 0, 1]])
    bend = np.array([[1, 0, 0], [0, 1, 0], [tilt, 0, 1]])
    transform = ProjectiveTransform(view @ bend @ rotation @ to_middle)
    picture = warp(chart, transform.inverse, output_shape=size, cval=0.35)
    return picture, transform([[GAP + PATCH / 2, GAP + PATCH / 2]])[0]


@pytest.mark.parametrize("turn_deg", [0, 7, 90, 180, 215, 270])
@pytest.mark.parametrize("tilt", [0.0, 0.0006])
def test_it_is_found_however_it_lies(turn_deg, tilt):
    picture, dark_skin = photographed(turn_deg, tilt)
    rng = np.random.default_rng(1)
    found = find_chart(255 * picture ** (1 / 2.2) + rng.normal(0, 1, picture.shape))
    assert found is not None
    assert found.patches_px[0].mean(axis=0) == pytest.approx(dark_skin, abs=3)
    for (x, y, width, height), colour in zip(found.boxes(), reference_colours(), strict=True):
        part = picture[y : y + height, x : x + width]
        assert part.mean(axis=(0, 1)) == pytest.approx(colour, abs=0.01)
        assert part.std(axis=(0, 1)).max() < 0.02


def test_other_things_are_no_chart():
    rng = np.random.default_rng(0)
    squares = (
        np.kron(np.indices((8, 10)).sum(axis=0) % 2, np.ones((40, 40)))[..., None].repeat(3, axis=2) * 200
    )
    tiles = np.kron(rng.uniform(20, 200, (4, 6, 3)), np.ones((60, 60, 1)))
    tiles[::60], tiles[:, ::60] = 0, 0
    assert find_chart(squares + 10) is None
    assert find_chart(cv2.GaussianBlur(tiles, (0, 0), 1.0)) is None


@pytest.mark.parametrize(("exponent", "offset_dn"), [(1.0, 0.0), (1.0, 12.0), (0.45, 0.0)])
def test_the_greys_tell_light_and_response(exponent, offset_dn):
    white_dn = np.array([180.0, 220.0, 150.0])
    boxes = np.array([[4 + 6 * (k % 6), 4 + 6 * (k // 6), 5, 5] for k in range(24)])
    codes = 255 * (reference_colours() * white_dn / 255) ** exponent + offset_dn + 16
    picture = np.full((1, 40, 50, 3), 16.0, np.float32)
    for (x, y, width, height), code in zip(boxes, codes, strict=True):
        picture[0, y : y + height, x : x + width] = code
    seen = capture("chart", 0.0, channels=3)
    object.__setattr__(seen, "real_dn", picture)
    object.__setattr__(
        seen, "context", seen.context.__class__(0.01, black_level_dn=16.0, white_level_dn=271.0)
    )
    light = light_on(seen, patch_colours(seen, boxes), patch_errors(seen, boxes))
    assert light is not None
    assert light.slope == pytest.approx(exponent, abs=0.02)
    assert light.white_dn == pytest.approx(white_dn, rel=0.03)
    assert light.offset_dn == pytest.approx(offset_dn, abs=0.5)


PEDESTAL_DN = 64.0
WHITE_DN = np.array([0.55, 1.0, 0.7])
"""Of raw filters in daylight, over the green one."""


def chart_capture(
    green_dn: float, noise_dn: float, *, cfa: str | None = None, bits: int = 14, frames: int = 2
):
    """A ColorChecker whose white gives so much green above the pedestal, in colour or behind a mosaic."""
    picture, _ = photographed(3.0, size=(480, 640))
    linear = picture * WHITE_DN * green_dn
    if cfa is not None:
        mosaic = np.empty((*linear.shape[:2], 1))
        for k, letter in enumerate(cfa):
            mosaic[k // 2 :: 2, k % 2 :: 2, 0] = linear[k // 2 :: 2, k % 2 :: 2, "RGB".index(letter)]
        linear = mosaic
    noisy = PEDESTAL_DN + linear + np.random.default_rng(4).normal(0, noise_dn, (frames, *linear.shape))
    seen = capture("chart", 0.0, channels=linear.shape[-1])
    height, width = linear.shape[:2]
    return replace(
        seen,
        real_dn=np.rint(noisy).astype(np.float32),
        expected_dn=None,
        valid=np.ones((height, width), bool),
        geometry=replace(
            seen.geometry, width_px=width, height_px=height, full_width_px=width, full_height_px=height
        ),
        context=replace(seen.context, black_level_dn=PEDESTAL_DN, white_level_dn=2.0**bits - 1, cfa=cfa),
    )


@pytest.mark.parametrize("cfa", ["RGGB", "GBRG"])
def test_a_chart_behind_a_mosaic_is_read_colour_by_colour(cfa):
    seen = chart_capture(4000.0, 12.0, cfa=cfa)
    (found,), said = with_own_expectations([seen])
    assert not said
    expected, real = found.expected_dn[0, ..., 0], seen.real_dn.mean(axis=0)[..., 0]
    assert found.valid.mean() > 0.01
    error = (real - expected)[found.valid]
    assert np.abs(np.mean(error)) < 4
    assert np.std(error) < 1.3 * 12 / np.sqrt(2)
    white_dn = 4000 * WHITE_DN * reference_colours()[18]
    assert found.patches[1][18] - PEDESTAL_DN == pytest.approx(white_dn, rel=0.02)


@pytest.mark.parametrize(("green_dn", "bits"), [(800.0, 16), (250.0, 16), (120.0, 14)])
def test_a_dim_chart_of_a_deep_camera_is_not_black(green_dn, bits):
    """Its white reaches half a percent of full scale, hundreds of times its noise."""
    (found,), said = with_own_expectations([chart_capture(green_dn, 2.0, bits=bits)])
    assert not said
    assert found.patches[1][18, 1] - PEDESTAL_DN == pytest.approx(
        green_dn * reference_colours()[18, 1], rel=0.05
    )


def test_a_chart_in_the_noise_is_left_out_with_what_to_do():
    kept, said = with_own_expectations([chart_capture(3.0, 40.0)])
    assert not kept
    assert "it is left out." in said[0]


@pytest.mark.skipif(not DATA.is_dir(), reason=f"the real captures are not at {DATA}")
def test_a_real_chart_in_the_sun_is_linear_above_its_pedestal():
    image = cv2.imread(str(DATA / "chart_asi533/color_target_sun.tif"))[..., ::-1].astype(np.float32)
    found = find_chart(image)
    assert found is not None
    first, white = found.boxes()[[0, 18], :2]
    assert (first < 60).all()
    assert white[1] > 300


@pytest.mark.skipif(not DATA.is_dir(), reason=f"the real captures are not at {DATA}")
@pytest.mark.parametrize("file", ["chart_350d/class1_class4_exp1_1.jpg", "opencv_boards/left05.jpg"])
def test_no_chart_is_seen_where_there_is_none(file):
    image = cv2.imread(str(DATA / file))[..., ::-1].astype(np.float32)
    assert find_chart(image) is None
