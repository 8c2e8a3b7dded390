"""Each family of statistics, against numbers known beforehand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_gap.captures import Noise, RealCapture
from tacos_gap.statistics import Sample, StatisticBlock, measure
from tacos_gap.statistics.grid import expected_in, tiles
from tacos_gap.statistics.hot_pixels import STEPS
from tacos_gap.statistics.line_means import line_means_of_frames
from tacos_gap.statistics.steady_light import in_steady_light, levels_of_frames
from tests.gap.small_captures import BLACK_DN, HEIGHT, WIDTH, capture, squares

LEVEL = 100.0
VARIANCE = 0.24 * LEVEL + 1.8


def flat_frames(count: int = 4, seed: int = 1) -> np.ndarray:
    """(N, H, W, 1) frames of an even field with the noise that the capture names, not rounded [DN]."""
    rng = np.random.default_rng(seed)
    noise = rng.normal(0, np.sqrt(VARIANCE), (count, HEIGHT, WIDTH, 1))
    return (BLACK_DN + LEVEL + noise).astype(np.float32)


def flat(frames: int = 4) -> RealCapture:
    return capture("flat", "flat", BLACK_DN + LEVEL, frames)


def blocks(of: RealCapture, frames: np.ndarray) -> dict[str, StatisticBlock]:
    assert of.expected_dn is not None
    return {block.statistic: block for block in measure(Sample(of, frames, of.expected_dn))}


def at(block: StatisticBlock, **wanted: Any) -> float:
    """The number of a block taken at this place."""
    (index,) = [i for i, place in enumerate(block.at) if all(place.get(k) == v for k, v in wanted.items())]
    return float(block.values[index])


def test_photon_transfer_is_the_variance():
    measured = blocks(flat(), flat_frames())["photon_transfer"].values
    assert np.exp(measured) == pytest.approx([VARIANCE], rel=0.02)


def test_a_small_pattern_is_no_matter_of_margins():
    """PRNU of .17 % at 180 DN, of six frames: a margin as wide as that would leave it to its neighbours."""
    rng = np.random.default_rng(11)
    level = 180.0
    pattern = level * (1 + 0.0017 * rng.standard_normal((HEIGHT, WIDTH, 1)))
    frames = rng.normal(BLACK_DN + pattern, 1.0, (6, HEIGHT, WIDTH, 1)).astype(np.float32)
    found = blocks(capture("flat", "flat", BLACK_DN + level, 6), frames)["fixed_pattern"]
    assert found.values[0] == pytest.approx((0.0017 * level) ** 2, rel=0.15)
    assert found.values[0] > 2.5 * np.max(found.margin)


def test_level_is_the_difference_of_the_means():
    assert blocks(flat(), flat_frames() + 1.5)["level"].values == pytest.approx([1.5], abs=0.1)


def test_a_level_is_judged_by_what_is_seen_of_it():
    """Of full pixels the light that they lost says nothing of how exactly their level is known."""
    bright = capture("bright", "bracket", 2000.0, frames=1)
    full = np.full(bright.real_dn.shape, 255.0, np.float32)
    assert bright.expected_dn is not None
    (margin,) = (
        block.margin
        for block in measure(Sample(bright, full, bright.expected_dn))
        if block.statistic == "level"
    )
    assert np.max(margin) == pytest.approx(0.004 * (255 - BLACK_DN), rel=0.01)


def test_neighbours_of_mixed_pixels_are_correlated():
    share = 0.05
    kernel = np.array([[0, share, 0], [share, 1 - 4 * share, share], [0, share, 0]], np.float32)
    mixed = np.stack([cv2.filter2D(frame, -1, kernel)[..., None] for frame in flat_frames(6)])
    found = blocks(flat(6), mixed)["noise_autocorrelation"]
    energy = (1 - 4 * share) ** 2 + 4 * share**2
    own = (1 - 4 * share + 2 * share) ** 2 / energy / WIDTH  # what means of rows, taken away, held of it
    assert at(found, lag_px=[1, 0]) == pytest.approx(2 * share * (1 - 4 * share) / energy - own, abs=0.01)
    assert at(found, lag_px=[1, 1]) == pytest.approx(2 * share**2 / energy, abs=0.01)
    assert at(found, lag_px=[4, 0]) == pytest.approx(-own, abs=0.01)


def test_what_repeats_is_a_fixed_pattern_and_noise_is_not():
    pattern = np.random.default_rng(3).normal(0, 1.2, (HEIGHT, WIDTH, 1)).astype(np.float32)
    without = blocks(flat(), flat_frames())["fixed_pattern"].values[0]
    with_it = blocks(flat(), flat_frames() + pattern)["fixed_pattern"].values[0]
    high_pass = 1 - 1 / 49
    assert without == pytest.approx(0, abs=0.25)
    assert with_it - without == pytest.approx(1.2**2 * high_pass, rel=0.15)


def test_a_lamp_that_wavers_from_frame_to_frame_is_no_noise():
    """A part in five hundred is more than the variance that a thousand pixels share."""
    still = flat_frames()
    wavers = np.array([0.998, 1.003, 1.001, 0.998], np.float32)[:, None, None, None]
    wavering = BLACK_DN + (still - BLACK_DN) * wavers
    one, other = blocks(flat(), still), blocks(flat(), wavering)
    for name in ("photon_transfer", "noise_autocorrelation", "row_noise", "column_noise", "row_waves"):
        assert other[name].values == pytest.approx(one[name].values, abs=2e-3), name
    assert other["frame_to_frame"].values == pytest.approx([np.std(wavers)], rel=0.1)


@given(st.floats(0.991, 1.009))
@settings(max_examples=10, deadline=None)
def test_the_level_of_a_frame_is_taken_out_above_the_pedestal(factor):
    scene = capture("scene", "scene", squares(), frames=2)
    assert scene.expected_dn is not None
    signal = scene.expected_dn[0] - BLACK_DN
    frames = np.stack([BLACK_DN + signal, BLACK_DN + factor * signal]).astype(np.float32)
    steady = in_steady_light(scene, frames, levels_of_frames(scene, line_means_of_frames(frames, 1)))
    assert steady[0] == pytest.approx(steady[1], rel=1e-4)
    assert steady.mean() == pytest.approx(frames.mean(), rel=1e-4)


def flickering(phases: list[float], period: float = 47.0) -> np.ndarray:
    """(N, H, W, 1) frames under a lamp of 5 % depth that each frame meets at another phase."""
    rows = np.arange(HEIGHT)[None, :, None, None]
    wave = 1 + 0.05 * np.sin(2 * np.pi * rows / period + np.array(phases)[:, None, None, None])
    return (BLACK_DN + (flat_frames(len(phases)) - BLACK_DN) * wave).astype(np.float32)


@pytest.mark.parametrize("apart", [0.0, 0.4, 1.7, np.pi])
def test_two_frames_show_a_lamps_wave_alike_whatever_parts_their_phases(apart):
    found = blocks(flat(2), flickering([0.3, 0.3 + apart], period=HEIGHT / 3))
    assert at(found["row_waves"], period_rows=HEIGHT / 3) == pytest.approx(0.05, abs=0.004)


def test_a_lamp_that_flickers_is_no_noise_of_pixels():
    flickers = np.array([0.94, 1.06, 1.03, 0.97], np.float32)[:, None, None, None]
    for frames in (flickering([0.0, 1.0, 3.0, 4.0]), BLACK_DN + (flat_frames() - BLACK_DN) * flickers):
        found = blocks(flat(), frames)
        assert np.exp(found["photon_transfer"].values) == pytest.approx([VARIANCE], rel=0.02)
        assert np.abs(found["noise_autocorrelation"].values).max() < 0.02
        assert np.exp(found["row_noise"].values) == pytest.approx([1.2], abs=0.4)


def blemishes(of: RealCapture, light: Any) -> dict[str, tuple[float, float]]:
    """Value and margin by size and place, where light is what it is times so much."""
    assert of.expected_dn is not None
    noise = flat_frames() - BLACK_DN - LEVEL
    frames = (of.expected_dn - BLACK_DN) * np.asarray(light)[..., None] + BLACK_DN + noise
    return {
        f"{place['size_px']} {place['of']}": (float(value), float(margin))
        for block in measure(Sample(of, frames.astype(np.float32), of.expected_dn))
        if block.statistic == "blemishes"
        for value, place, margin in zip(block.values, block.at, np.asarray(block.margin), strict=True)
    }


def stronger(found: dict[str, tuple[float, float]], than: dict[str, tuple[float, float]]) -> dict[str, float]:
    """By how many margins."""
    return {key: (value - than[key][0]) / margin for key, (value, margin) in found.items()}


@pytest.mark.parametrize(("radius_px", "size_px"), [(4, [4, 20]), (8, [4, 20]), (14, [20, 60])])
def test_dust_is_a_blemish_and_falling_light_is_none(radius_px, size_px):
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    speck = 1 - 0.1 / (1 + np.exp(np.hypot(rows - 55, columns - 70) - radius_px))
    of = flat()
    plain, dusty, dim = (
        blemishes(of, light) for light in (np.ones_like(speck), speck, 1 - 0.4 * of.geometry.radius**2)
    )
    strength = stronger(dusty, plain)
    assert max(strength[f"{size_px} {of}"] for of in ("all", "strongest")) > 2
    assert max(np.abs(list(stronger(dim, plain).values()))) < 0.1


def test_blemishes_behind_a_mosaic_are_those_of_the_light():
    """Cells hold whole groups of four colours, so that these are no pattern of their own."""
    colours = np.tile([[0.5, 1.0], [0.3, 0.5]], (HEIGHT // 2, WIDTH // 2))
    mosaic = capture("flat", "flat", BLACK_DN + LEVEL * colours, frames=4)
    mosaic = replace(mosaic, context=replace(mosaic.context, cfa="GRBG"))
    found = stronger(blemishes(mosaic, np.full((HEIGHT, WIDTH), 1.2)), blemishes(mosaic, 1.0))
    assert len(found) == 4
    assert max(np.abs(list(found.values()))) < 0.1


def test_the_colours_of_a_mosaic_are_no_fixed_pattern():
    """Levels that are off by a tenth leave a tenth of the mosaic, which is no pattern of the pixels."""
    colours = np.tile([[0.5, 1.0], [0.3, 0.5]], (HEIGHT // 2, WIDTH // 2))[None, :, :, None]
    mosaic = capture("flat", "flat", BLACK_DN + LEVEL * colours[0, ..., 0], frames=4)
    mosaic = replace(mosaic, context=replace(mosaic.context, cfa="GRBG"))
    noise = flat_frames() - BLACK_DN - LEVEL
    pattern = np.random.default_rng(3).normal(0, 1.2, (HEIGHT, WIDTH, 1))
    brighter = BLACK_DN + 1.1 * LEVEL * colours + noise
    found, with_it = (
        blocks(mosaic, frames.astype(np.float32))["fixed_pattern"].values
        for frames in (brighter, brighter + pattern)
    )
    assert found == pytest.approx(0, abs=0.3)
    assert (with_it - found).mean() == pytest.approx(1.2**2 * (1 - 1 / 25), rel=0.15)


def test_hot_pixels_of_the_dark_are_counted_and_kept_out_of_the_rest():
    rng = np.random.default_rng(5)
    dark = capture("dark", "dark", BLACK_DN, 3)
    frames = (BLACK_DN + rng.normal(0, np.sqrt(1.8), (3, HEIGHT, WIDTH, 1))).astype(np.float32)
    hot = frames.copy()
    hot[:, ::30, ::40] += 90.0
    count = len(range(0, HEIGHT, 30)) * len(range(0, WIDTH, 40))
    unnoticed = 1 + 1e-4 * HEIGHT * WIDTH / np.array(STEPS)
    counted = np.expm1(blocks(dark, hot)["hot_pixels"].values) * unnoticed
    assert counted == pytest.approx([count, count, count, count, 0])  # the highest step is above 90 DN
    assert np.expm1(blocks(dark, frames)["hot_pixels"].values) == pytest.approx(0)
    assert blocks(dark, hot)["dark_level"].values == pytest.approx(
        blocks(dark, frames)["dark_level"].values, abs=0.02
    )


@pytest.mark.parametrize(("axis", "name"), [(1, "row_noise"), (2, "column_noise")])
def test_noise_that_lines_share(axis, name):
    shape = [4, 1, 1, 1]
    shape[axis] = HEIGHT if axis == 1 else WIDTH
    sigma = 0.8
    frames = flat_frames() + np.random.default_rng(7).normal(0, sigma, shape).astype(np.float32)
    other = "column_noise" if name == "row_noise" else "row_noise"
    along = WIDTH if axis == 1 else HEIGHT
    found = blocks(flat(), frames)
    variance = VARIANCE + sigma**2
    assert np.exp(found[name].values[0]) == pytest.approx(1 + along * sigma**2 / variance, rel=0.25)
    assert np.exp(found[other].values[0]) == pytest.approx(1, abs=0.3)


def test_a_wave_over_the_rows_has_its_period_and_depth():
    wave = 1 + 0.05 * np.sin(2 * np.pi * np.arange(HEIGHT) / 40)
    frames = BLACK_DN + (flat_frames(1) - BLACK_DN) * wave[None, :, None, None].astype(np.float32)
    found = blocks(flat(1), frames)["row_waves"]
    assert at(found, period_rows=40.0) == pytest.approx(0.05, abs=0.003)
    assert at(found, period_rows=HEIGHT / 5) < 0.01


def test_falling_light_shows_in_the_level_of_tiles_but_not_in_noise_over_the_field():
    capture_of = flat(6)
    fall = (1 - 0.3 * capture_of.geometry.radius**2).astype(np.float32)[..., None]
    rng = np.random.default_rng(9)
    signal = np.broadcast_to(LEVEL * fall, (6, HEIGHT, WIDTH, 1))
    frames = BLACK_DN + signal + rng.normal(0, 1, signal.shape) * np.sqrt(0.24 * signal + 1.8)
    found = blocks(capture_of, frames.astype(np.float32))
    fallen = found["relative_illumination"]
    outer = [v for v, place in zip(fallen.values, fallen.at, strict=True) if place["radius"][1] > 0.95]
    inner = [v for v, place in zip(fallen.values, fallen.at, strict=True) if place["radius"][1] < 0.35]
    assert np.mean(inner) - np.mean(outer) == pytest.approx(0.3 * (0.8 - 0.05), abs=0.06)
    assert np.abs(found["noise_over_field"].values).max() < 0.03


def test_what_uneven_pixels_put_into_tiles_by_chance_is_no_field():
    """Of many sensors, a field of the dark parts from 0 by no more than its margin says."""
    apart = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        uneven = rng.lognormal(0, 0.7, (1, HEIGHT, WIDTH, 1)) * 6
        frames = BLACK_DN + uneven + rng.normal(0, 1, (4, HEIGHT, WIDTH, 1))
        found = blocks(capture("dark", "dark", BLACK_DN, 4), frames.astype(np.float32))["dark_field"]
        apart.append(found.values / found.margin)
    assert 0.5 < np.std(apart) < 1.2


def test_along_an_edge_nothing_is_displaced():
    """Of an edge only the way across it is seen: flow that runs along it by chance is no displacement."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]

    def edge(dx_px: float, dy_px: float) -> np.ndarray:
        across = (columns - 78 - dx_px) * np.cos(0.1) + (rows - 60 - dy_px) * np.sin(0.1)
        return np.asarray(BLACK_DN + 15 + 180 / (1 + np.exp(-across / 0.5)))

    of = capture("edge", "edge", edge(0, 0), frames=2)
    noise = flat_frames(2) - BLACK_DN - LEVEL
    found = blocks(of, (edge(0.9, 3.0)[None, :, :, None] + noise).astype(np.float32))["displacement"]
    across_px = 0.9 * np.cos(0.1) + 3.0 * np.sin(0.1)
    for value, place in zip(found.values, found.at, strict=True):
        along_axis = np.cos(0.1) if place["axis"] == "x" else np.sin(0.1)
        assert value == pytest.approx(across_px * along_axis, abs=0.08), place


def test_every_second_code_missing_is_a_comb():
    found = blocks(flat(), np.rint(flat_frames()))["code_comb"]
    combed = blocks(flat(), 2 * np.rint(flat_frames() / 2))["code_comb"]
    assert at(found, period_dn=2) < 0.02
    assert at(combed, period_dn=2) == pytest.approx(1.0)
    assert at(combed, what="empty codes") == pytest.approx(0.5, abs=0.05)


def test_clipping_is_counted_at_both_ends():
    frames = np.rint(flat_frames())
    frames[:, :12] = 255.0
    frames[:, -6:] = 0.0
    found = blocks(flat(), frames)["clipped"]
    assert at(found, end="white") == pytest.approx(12 / HEIGHT)
    assert at(found, end="zero") == pytest.approx(6 / HEIGHT)


def test_blur_lowers_detail_by_its_transfer_function():
    sigma = 0.9
    edges = capture("edges", "edge", squares())
    assert edges.expected_dn is not None
    blurred = cv2.GaussianBlur(edges.expected_dn[0], (0, 0), sigma)[None, ..., None]
    found = blocks(edges, np.repeat(blurred, 2, axis=0))["detail"]
    band = {"frequency_cycles_px": [0.08, 0.16], "direction_deg": 0}
    measured = [v for v, p in zip(found.values, found.at, strict=True) if band.items() <= p.items()]
    low, high = (np.exp(-4 * np.pi**2 * sigma**2 * f**2) for f in (0.16, 0.08))
    assert all(low <= np.exp(value) <= high for value in measured)
    assert measured


def test_shifted_detail_is_displaced():
    grain = cv2.GaussianBlur(np.random.default_rng(10).normal(0, 1, (HEIGHT, WIDTH)), (0, 0), 2)
    texture = BLACK_DN + 110 + 300 * grain
    scene = capture("scene", "scene", texture)
    to_the_right = np.array([[1, 0, 0.6], [0, 1, 0.0]])
    moved = cv2.warpAffine(texture, to_the_right, (WIDTH, HEIGHT), borderMode=cv2.BORDER_REFLECT)
    frames = np.repeat(moved[None, ..., None], 2, axis=0).astype(np.float32)
    assert scene.expected_dn is not None
    found = [b for b in measure(Sample(scene, frames, scene.expected_dn)) if b.statistic == "displacement"]
    along, across = (next(b for b in found if b.at[0]["axis"] == axis) for axis in "xy")
    assert np.median(along.values) == pytest.approx(0.6, abs=0.1)
    assert np.median(across.values) == pytest.approx(0.0, abs=0.05)


def colourful() -> RealCapture:
    """A chart of random colours."""
    rng = np.random.default_rng(11)
    patches = rng.uniform(20, 180, (6, 8, 3))
    image = BLACK_DN + np.kron(patches, np.ones((HEIGHT // 6, WIDTH // 8, 1)))
    mono = capture("chart", "chart", BLACK_DN)
    return replace(
        mono,
        real_dn=np.zeros((2, HEIGHT, WIDTH, 3), np.float32),
        expected_dn=image[None].astype(np.float32),
        noise=Noise((0.24,) * 3, (1.8,) * 3),
    )


def test_the_matrix_between_colours_is_found():
    matrix = np.array([[1.2, -0.15, -0.05], [-0.1, 1.2, -0.1], [0.0, -0.2, 1.2]])
    chart = colourful()
    assert chart.expected_dn is not None
    frames = BLACK_DN + (chart.expected_dn - BLACK_DN) @ matrix.T
    rng = np.random.default_rng(13)
    frames = np.repeat(frames, 2, axis=0) + rng.normal(0, 1, (2, HEIGHT, WIDTH, 3))
    found = blocks(chart, frames.astype(np.float32))["colour_matrix"]
    assert found.values.reshape(3, 3) == pytest.approx(matrix, abs=0.01)


def test_a_patch_may_part_from_its_reference_by_what_prints_do():
    boxes = np.array([[2, 2, 12, 12], [62, 42, 12, 12]])
    chart = replace(colourful(), patches=(boxes, np.zeros((2, 3))))
    assert chart.expected_dn is not None
    brighter = BLACK_DN + 1.05 * (chart.expected_dn - BLACK_DN)
    found = blocks(chart, np.repeat(brighter, 2, axis=0).astype(np.float32))["patches"]
    assert np.all(found.values > 0.9)
    assert found.values / found.margin == pytest.approx(np.full(6, 0.05 / 0.02), rel=0.2)  # bright or dark


def test_jpeg_leaves_borders_and_takes_coefficients():
    edges = capture("edges", "edge", squares(), frames=1)
    assert edges.expected_dn is not None
    noise = np.random.default_rng(15).normal(0, 4, edges.expected_dn.shape)
    image = np.clip(edges.expected_dn + noise, 0, 255)
    _, code = cv2.imencode(".jpg", image[0, ..., 0].astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, 25])
    squeezed = cv2.imdecode(code, cv2.IMREAD_GRAYSCALE)[None, ..., None].astype(np.float32)
    before, after = blocks(edges, image.astype(np.float32)), blocks(edges, squeezed)
    assert after["block_borders"].values.sum() > before["block_borders"].values.sum() + 0.2
    assert (after["vanished_coefficients"].values > before["vanished_coefficients"].values + 0.1).all()


def test_what_is_expected_in_a_tile_is_worked_out_once_whatever_is_measured():
    edges = capture("edges", "edge", squares())
    grid = tiles(edges)
    first = expected_in(grid, edges, 0)
    assert first == pytest.approx(grid.mean(squares() - BLACK_DN))
    assert expected_in(grid, edges, 0) is first


def test_real_and_simulated_frames_are_measured_at_the_same_places():
    edges = capture("edges", "edge", squares())
    assert edges.expected_dn is not None
    rng = np.random.default_rng(17)
    one, other = (edges.expected_dn + rng.normal(0, s, (2, HEIGHT, WIDTH, 1)) for s in (1, 9))
    first, second = (measure(Sample(edges, f.astype(np.float32), edges.expected_dn)) for f in (one, other))
    assert [(b.statistic, list(b.at)) for b in first] == [(b.statistic, list(b.at)) for b in second]
