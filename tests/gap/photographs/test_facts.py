"""What files say of how they were taken, where cameras and programs wrote it in their own way."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from PIL import Image
from PIL.TiffImagePlugin import IFDRational

from tacos_files.exposure_names import possible_time_ms, time_in_name_ms
from tacos_framework.errors import UserError
from tacos_gap.photographs.facts import read_facts
from tests.gap.captures.dng import BYTE, LONG, RATIONAL, SHORT, dng

EXPOSURE, SHUTTER, PIXELS, PLANE, UNIT = 0x829A, 0x9201, 0xA002, 0xA20E, 0xA210
MOSAIC = np.full((48, 64), 900, np.uint16)


def photograph(path: Path, own: dict[int, object]) -> Path:
    tags = Image.Exif()
    tags.get_ifd(0x8769).update(own)
    Image.new("L", (16, 12)).save(path, exif=tags)
    return path


@pytest.mark.parametrize(
    ("own", "exposure_ms"),
    [
        ({EXPOSURE: 1 / 60}, 1000 / 60),
        ({EXPOSURE: "1/60"}, 1000 / 60),
        ({SHUTTER: 6.0}, 1000 / 64),
        ({EXPOSURE: IFDRational(2**32 - 1, 1)}, None),  # infinity
        ({SHUTTER: IFDRational(0, 0)}, None),
        ({SHUTTER: 200.0}, None),
        ({}, None),
    ],
)
def test_exposure_times_are_read_however_they_were_written(tmp_path, own, exposure_ms):
    found = read_facts(photograph(tmp_path / "a.jpg", own)).exposure_ms
    assert found == (exposure_ms and pytest.approx(exposure_ms))


@pytest.mark.parametrize("own", [{0x8827: 65535, 0x8832: 102400}, {0x8831: 102400}, {0x8833: 102400}])
def test_an_iso_beyond_16_bits_is_read_where_it_stands(tmp_path, own):
    assert read_facts(photograph(tmp_path / "a.jpg", own)).iso == 102400


def test_the_pixels_of_a_raw_file_are_those_of_the_sensor(tmp_path):
    pytest.importorskip("rawpy", reason="the extra raw is not installed")
    path = tmp_path / "a.dng"
    of_preview = {PLANE: (RATIONAL, [5080, 1]), UNIT: (SHORT, [2]), PIXELS: (LONG, [4 * MOSAIC.shape[1]])}
    path.write_bytes(dng(MOSAIC, of_preview))
    assert read_facts(path).pixel_um == 5.0


def test_filters_that_are_no_bayer_mosaic_are_refused(tmp_path):
    pytest.importorskip("rawpy", reason="the extra raw is not installed")
    path = tmp_path / "a.dng"
    path.write_bytes(dng(MOSAIC, {33421: (SHORT, [6, 6]), 33422: (BYTE, [0, 1, 2, 1, 1, 2] * 6)}))
    with pytest.raises(UserError, match=r"a.dng has colour filters that are no Bayer mosaic"):
        read_facts(path)


def test_a_tiff_of_samples_that_pillow_does_not_know_keeps_its_exif(tmp_path):
    tifffile = pytest.importorskip("tifffile")
    path = tmp_path / "a.tif"
    tags = [(271, "s", 0, "Maker", True), (EXPOSURE, "2I", 1, (1, 50), True)]
    tifffile.imwrite(path, MOSAIC, photometric="cfa", extratags=tags)
    facts = read_facts(path)
    assert (facts.camera, facts.exposure_ms) == ("Maker", 20.0)


@pytest.mark.parametrize("joint", ["1-{}s", "1_{}s", "1 {} s", "shelf_1-{}s_03", "wall 1-{}sec", "1⁄{}s"])
@pytest.mark.parametrize("denominator", [60, 125, 250, 500, 4000])
def test_fractions_of_a_second_in_names_are_fractions(joint: str, denominator: int) -> None:
    assert time_in_name_ms(joint.format(denominator)) == pytest.approx(1000 / denominator)


@pytest.mark.parametrize(
    ("stem", "time_ms"),
    [
        ("wall_1-250_2", 4.0),  # without a unit
        ("dark_3_2s", 2000.0),  # file 3 of 2 s
        ("dark_2_30ms", 30.0),
        ("dark_1_30s", None),  # file 1 of 30 s, or a thirtieth
        ("shelf_2-5s", None),
        ("page_1-10", None),
        ("2024-11-27_dark_1s", 1000.0),
        ("IMG_1-500s(2)", 2.0),
        ("cam1-250s", None),  # camera 1, or a 250th
        ("dark_8,000us", None),  # eight milliseconds, or microseconds
        ("dark_0,125s", 125.0),
        ("shelf_16p7ms_0", 16.7),
        ("dark_0ms", None),
    ],
)
def test_what_a_name_may_mean_twice_is_no_time(stem: str, time_ms: float | None) -> None:
    assert time_in_name_ms(stem) == (None if time_ms is None else pytest.approx(time_ms))


def test_a_folder_says_what_the_names_in_it_do_not(tmp_path: Path) -> None:
    (folder := tmp_path / "iso100_1-125s").mkdir()
    said = [read_facts(photograph(folder / name, {})) for name in ("0.jpg", "1_4ms.jpg")]
    assert [(each.exposure_ms, each.iso, each.time_from) for each in said] == [
        (8.0, 100.0, "its name"),
        (4.0, 100.0, "its name"),
    ]


WORDS = st.text("abcdefghijkmoqrvxyz", min_size=1, max_size=8)
UNITS = {"s": 1e3, "sec": 1e3, "ms": 1.0, "msec": 1.0, "us": 1e-3, "\u00b5s": 1e-3, "ns": 1e-6}


@given(
    before=WORDS,
    joint=st.sampled_from([" ", "_", "_exp_", "_t", " exposure=", "(", "-shutter "]),
    hundredths=st.integers(1, 10**7),
    comma=st.booleans(),
    gap=st.sampled_from(["", " ", "_"]),
    unit=st.sampled_from([*UNITS]),
    after=st.sampled_from(["", "_0", " (2)", "_dark", "_iso100", "-3"]),
)
def test_a_decimal_time_is_read_whatever_stands_around_it(
    before: str, joint: str, hundredths: int, comma: bool, gap: str, unit: str, after: str
) -> None:
    number = f"{hundredths / 100:g}".replace(".", "," if comma else ".")
    assume("e" not in number and not re.fullmatch(r"[1-9]\d{0,2},\d{3}", number))
    stem = f"{before}{joint}{number}{gap}{unit}{after}"
    expected = float(number.replace(",", ".")) * UNITS[unit]
    for written in (stem, stem.upper() if unit != "\u00b5s" else stem):
        assert time_in_name_ms(written) == pytest.approx(expected), written


@given(
    before=WORDS, denominator=st.integers(60, 8000), joint=st.sampled_from("-_ "), after=st.integers(0, 99)
)
def test_no_fraction_is_ever_taken_for_whole_seconds(
    before: str, denominator: int, joint: str, after: int
) -> None:
    for stem in (f"{before}_1{joint}{denominator}s_{after}", f"1{joint}{denominator}s_{before}"):
        assert time_in_name_ms(stem) in (None, pytest.approx(1000 / denominator)), stem


@given(st.text("0123456789abdefmnstux_-+., ()[]=:\u00b5\u2044", max_size=24))
def test_any_name_has_a_time_that_a_shutter_may_have_or_none(stem: str) -> None:
    for time_ms in (time_in_name_ms(stem), possible_time_ms(stem)):
        assert time_ms is None or time_ms > 0
