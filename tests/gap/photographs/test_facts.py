"""What files say of how they were taken, where cameras and programs wrote it in their own way."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

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
        ({}, None),
    ],
)
def test_exposure_times_are_read_however_they_were_written(tmp_path, own, exposure_ms):
    found = read_facts(photograph(tmp_path / "a.jpg", own)).exposure_ms
    assert found == (exposure_ms and pytest.approx(exposure_ms))


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
