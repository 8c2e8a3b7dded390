"""Captures of many megapixels, of which a part is measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tacos_framework.formation import EpisodeDraws, PlacedEffect
from tacos_framework.values import ImageContext, ImageGeometry
from tacos_gap.answer.gathering import gather
from tacos_gap.captures import CaptureFolder
from tacos_gap.captures.capture import Noise, RealCapture
from tacos_gap.captures.large import (
    DETAIL_PX,
    ENOUGH_PIXELS,
    ENOUGH_SAMPLES,
    FEWEST_CAPTURES,
    GRID_PX,
    KEPT_PIXELS,
    LEAST_PIXELS,
    as_kept,
    enough_pixels,
    left_out,
    measured_part,
    not_searched_over,
    part_of,
    searched_over,
)
from tacos_gap.simulation.formation import simulate
from tacos_gap.statistics import Sample, measure
from tacos_plugins.effects.vignetting import Vignetting


def capture(height: int, width: int, kind: str = "flat", **given) -> RealCapture:
    expected = np.full((1, height, width, 1), 120.0, np.float32)
    return RealCapture(
        id="a",
        kind=kind,
        real_dn=expected.copy(),
        expected_dn=expected,
        valid=np.ones((height, width), bool),
        geometry=ImageGeometry(
            width, height, focal_length_px=width, centre_px=((width - 1) / 2, (height - 1) / 2), pixel_um=3
        ),
        context=ImageContext(),
        noise=Noise((0.1,), (1.0,)),
        **given,
    )


def test_a_frame_of_ordinary_size_is_measured_whole():
    assert measured_part(capture(720, 960)) is None


@pytest.mark.parametrize(("height", "width"), [(3000, 4000), (4000, 3000), (1225, 1633)])
def test_of_a_large_one_a_band_along_its_longer_side_on_the_grid_of_codecs(height, width):
    rows, columns = measured_part(capture(height, width))
    sides = rows.stop - rows.start, columns.stop - columns.start
    assert max(sides) == max(height, width)
    assert 0.6 * ENOUGH_PIXELS < np.prod(sides) <= ENOUGH_PIXELS
    assert rows.start % GRID_PX == columns.start % GRID_PX == 0
    middle = (rows.start + rows.stop) / 2, (columns.start + columns.stop) / 2
    assert middle == pytest.approx((height / 2, width / 2), abs=GRID_PX)


def test_many_captures_share_the_samples_that_are_measured():
    grey = [capture(240, 320)] * 92
    assert enough_pixels(grey[:1]) == ENOUGH_PIXELS
    assert enough_pixels(grey) == LEAST_PIXELS
    few = [capture(480, 640)] * 6
    part = measured_part(few[0], enough_pixels(few))
    seen = part_of(few[0], part).valid.size
    assert 0.8 * ENOUGH_SAMPLES < 6 * seen <= ENOUGH_SAMPLES
    repeated = replace(few[0], real_dn=np.repeat(few[0].real_dn, 2, axis=0))
    halved = part_of(repeated, measured_part(repeated, enough_pixels(few)))
    assert halved.valid.size == pytest.approx(seen / 2, rel=0.1)


@pytest.mark.parametrize("height", [480, 1600])
def test_of_a_wall_whose_lamp_flickers_all_rows_are_measured(height):
    wave = 1 + 0.03 * np.sin(2 * np.pi * np.arange(height) / (height / 3.4))
    steady, flickers = (capture(height, 2 * height) for _ in range(2))
    flickers.real_dn[...] *= wave[:, None, None]
    (rows, _), (few, _) = (measured_part(each, LEAST_PIXELS) for each in (flickers, steady))
    assert rows == slice(0, height)
    assert few.stop - few.start < height / 2
    assert as_kept(flickers).valid.shape[0] == height


def test_a_band_lies_where_a_picture_shows_edges():
    scene = capture(1200, 1600, "scene")
    scene.expected_dn[0, 900:1000, 200:1400:8] = 30.0
    rows, _ = measured_part(scene)
    assert rows.start < 900 < 1000 < rows.stop


@pytest.mark.parametrize(("height", "width"), [(1080, 1920), (1920, 1080)])
def test_of_many_captures_with_edges_a_part_high_enough_for_detail_is_measured(height, width):
    scene = capture(height, width, "scene")
    for corner in range(690, 770, 14):  # squares of 7 px, in both directions
        scene.expected_dn[0, corner : corner + 7, 690:770] -= 60.0
        scene.expected_dn[0, 690:770, corner : corner + 7] += 40.0
    part = measured_part(scene, LEAST_PIXELS // 2)
    lines, along = sorted(each.stop - each.start for each in part)
    assert lines == DETAIL_PX
    assert lines * along <= LEAST_PIXELS // 2
    assert all(each.start < 770 and each.stop > 690 for each in part)
    sample = Sample(part_of(scene, part), scene.real_dn[:, *part], scene.expected_dn[:, *part])
    assert {"detail", "displacement"} <= {block.statistic for block in measure(sample)}


def test_of_a_chart_all_patches_are_measured():
    boxes = np.array([[1000, 500, 80, 80], [2000, 900, 80, 80]])
    chart = capture(2000, 3000, "chart", patches=(boxes, np.ones((2, 3))))
    part = part_of(chart, measured_part(chart))
    (x, y, width, height), *_ = part.patches[0].tolist()
    assert (part.patches[0][:, :2] >= 0).all()
    assert 480 <= part.valid.shape[0] < 600
    assert 1080 <= part.valid.shape[1] < 1200
    assert part.geometry.offset_px == (1000 - x, 500 - y)
    assert (width, height) == (80, 80)


def test_an_effect_does_to_a_part_what_it_does_to_it_in_the_whole():
    whole = capture(1600, 1600)
    rows, columns = measured_part(whole)
    part = part_of(whole, (rows, columns))
    effect = PlacedEffect("effect.vignetting", "effect.vignetting", Vignetting, Vignetting.Config(k1=-0.3))
    noiseless = [replace(each, noise=Noise((0.0,), (0.0,))) for each in (whole, part)]
    one, other = (simulate(each, [effect], EpisodeDraws(1, ("a",))) for each in noiseless)
    assert np.array_equal(one[:, rows, columns], other)
    assert np.ptp(other) > 10


def test_what_varies_with_a_capture_is_cut_with_it():
    depth = np.arange(2000 * 1000, dtype=np.float32).reshape(2000, 1000)
    velocity = np.stack([depth, -depth], axis=-1)
    tall = capture(2000, 1000)
    part = (slice(16, 48), slice(32, 96))
    for given in (velocity, lambda: velocity):
        context = ImageContext(depth_m=depth, velocity_px_s=given, reference_row=100.0)
        cut = part_of(replace(tall, context=context), part).context
        assert np.array_equal(cut.depth_m, depth[part])
        assert np.array_equal(cut.known_velocity_px_s(""), velocity[part])
        assert cut.reference_row == 84.0


def exposed(kind: str, count: int, channels: int = 1) -> list[RealCapture]:
    """Captures of a kind at as many exposure times, the last first."""
    values = np.full((1, 96, 128, channels), 120.0, np.float32)
    return [
        replace(
            capture(96, 128, kind),
            id=f"{kind}_{k}",
            real_dn=values,
            expected_dn=values,
            context=ImageContext(exposure_s=1e-3 * k),
        )
        for k in range(count, 0, -1)
    ]


def test_a_search_over_many_captures_simulates_no_more_than_over_thirty():
    many = [*exposed("dark", 50), *exposed("bracket", 40), *exposed("chart", 2), *exposed("board", 9)]
    searched = searched_over(many)
    kinds = [each.kind for each in searched]
    assert len(searched) - 9 <= ENOUGH_SAMPLES // LEAST_PIXELS == 30
    assert {kind: kinds.count(kind) for kind in set(kinds)} == {
        "dark": 14,
        "bracket": 14,
        "chart": 2,
        "board": 9,
    }
    times = [each.context.exposure_s for each in searched if each.kind == "dark"]
    assert times == sorted(times, reverse=True), "the order of the folder, in which folds alternate, stays"
    assert (min(times), max(times)) == (0.001, 0.050)
    assert np.diff(sorted(times)).max() <= 0.0041
    assert "39 of the 101 captures" in not_searched_over(many, searched)[0]


def test_few_captures_are_all_searched_over_in_colour_too():
    few = exposed("flat", FEWEST_CAPTURES, channels=3)
    assert searched_over(few) == few
    assert not_searched_over(few, few) == []


def test_each_trial_of_a_large_folder_simulates_those_captures_alone():
    evidence, said = gather(CaptureFolder(None, (*exposed("flat", 45),)), seed=0)
    assert len(evidence) == 30
    assert any("30 of the 45 captures" in text for text in said)


@pytest.mark.parametrize("kind", ["dark", "flat", "bracket"])
def test_of_large_pictures_of_even_light_the_middle_is_kept(kind):
    kept = as_kept(capture(1300, 1400, kind))
    assert kept.valid.shape == kept.real_dn.shape[1:3] == kept.expected_dn.shape[1:3] == (704, 1400)
    assert kept.valid.size <= KEPT_PIXELS
    assert kept.real_dn.base is None, "the whole is let go"
    assert kept.geometry.offset_px == (0, 304)
    assert kept.whole.small_dn.shape == (594, 640, 1), "a page shows all of it"
    (_, limitations) = gather(CaptureFolder(None, (kept,)), seed=0)
    assert any(text.startswith("a: of 1400 x 1300 pixels, 1400 x 352 are measured") for text in limitations)


@pytest.mark.parametrize("kind", ["scene", "chart"])
def test_of_scenes_and_charts_all_is_kept(kind):
    large = capture(1300, 1400, kind)
    assert as_kept(large) is large


def test_of_a_large_edge_lines_across_it_are_kept_whichever_way_it_lies():
    level = capture(1300, 1400, "edge")
    level.real_dn[0, 900:] = 30.0
    rows, columns = as_kept(level).valid.shape
    assert (rows, columns) == (1300, 768)
    upright = capture(1300, 1400, "edge")
    upright.real_dn[0, :, 900:] = 30.0
    assert as_kept(upright).valid.shape == (704, 1400)


def test_a_large_board_is_kept_in_grey():
    colours = np.repeat(np.arange(3, dtype=np.float32)[None, None, None], 1500, axis=1).repeat(1100, axis=2)
    board = as_kept(replace(capture(1500, 1100, "board"), real_dn=colours.repeat(2, axis=0)))
    assert board.real_dn.shape == (1, 1500, 1100, 1)
    assert np.ptp(board.real_dn) == 0
    assert board.real_dn[0, 0, 0, 0] == 1.0


def test_what_is_not_measured_is_said():
    large = capture(2000, 3000)
    _, limitations = gather(CaptureFolder(None, (large,)), seed=0)
    said = "a: of 3000 x 2000 pixels, 3000 x 160 are measured, from column 0 and row 912 on"
    assert any(text.startswith(said) for text in limitations)
    assert left_out(large, large) == ""


def test_an_upright_picture_in_colour_is_measured_too():
    """Of its band, columns of an array, every statistic is taken."""
    texture = np.random.default_rng(3).uniform(60, 180, (250, 80)).astype(np.float32)
    expected = np.repeat(np.kron(texture, np.ones((8, 16), np.float32))[None, ..., None], 3, axis=-1)
    scene = replace(capture(2000, 1280, "scene"), real_dn=expected.copy(), expected_dn=expected)
    (evidence,), _ = gather(CaptureFolder(None, (scene,)), seed=0)
    assert evidence.capture.valid.shape == (2000, 192)
    assert {"level", "displacement", "colour_displacement", "detail"} <= {
        e.statistic for e in evidence.labels
    }
    assert np.isfinite(evidence.residual(())).all()
