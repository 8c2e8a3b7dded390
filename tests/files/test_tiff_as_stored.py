"""TIFF files of every kind give the samples that were stored, or are refused in words."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from tacos_files.images import read_samples
from tacos_framework.errors import UserError

tifffile = pytest.importorskip("tifffile", reason="it writes what OpenCV does not")

RNG = np.random.default_rng(4)
GREY8 = RNG.integers(0, 256, (21, 34)).astype(np.uint8)
GREY16 = RNG.integers(0, 4096, (21, 34)).astype(np.uint16)
RGB8 = RNG.integers(0, 256, (21, 34, 3)).astype(np.uint8)
RGB16 = RNG.integers(0, 65536, (21, 34, 3)).astype(np.uint16)
RGBA8, RGBA16 = (np.dstack([each, each[..., 1]]) for each in (RGB8, RGB16))


def written(folder: Path, image: np.ndarray, **options: object) -> Path:
    path = folder / "a.tif"
    tifffile.imwrite(path, image, **options)
    return path


def test_tags_of_cameras_are_no_warnings(tmp_path, capfd):
    read_samples(written(tmp_path, GREY16, extratags=[(33434, "2I", 1, (1, 100), True)]))
    assert capfd.readouterr().err == ""


def test_camera_raw_under_another_name_is_no_preview(tmp_path):
    said = r"it is camera RAW.*give it its own suffix"
    with pytest.raises(UserError, match=said):
        read_samples(written(tmp_path, GREY16, extratags=[(50706, "B", 4, (1, 4, 0, 0), True)]))
    with tifffile.TiffWriter(tmp_path / "b.tif") as file:
        file.write(RGB8, subfiletype=1, subifds=1)
        file.write(GREY16)
    with pytest.raises(UserError, match=said):
        read_samples(tmp_path / "b.tif")


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("image", [GREY8, GREY16, RGB8, RGB16, GREY16.astype(np.float32)])
def test_files_that_ask_to_be_turned_lie_as_the_sensor_does(tmp_path, image, orientation):
    turned = written(tmp_path, image, extratags=[(274, "H", 1, orientation, True)])
    np.testing.assert_array_equal(read_samples(turned), image)


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("options", [{}, {"tile": (32, 32)}, {"compression": "deflate"}, {"bigtiff": True}])
@pytest.mark.parametrize("image", [RGB8, RGB16, RGB16.astype(np.float32)])
def test_planes_that_lie_one_behind_the_other_are_the_channels(tmp_path, image, options, order):
    planes = np.moveaxis(image, -1, 0)
    path = written(tmp_path, planes, planarconfig="separate", photometric="rgb", byteorder=order, **options)
    np.testing.assert_array_equal(read_samples(path), image)


@pytest.mark.parametrize("kind", ["unassalpha", "assocalpha", "unspecified"])
@pytest.mark.parametrize("image", [RGBA8, RGBA16])
@pytest.mark.parametrize("planes", [False, True])
def test_alpha_is_left_out_and_weighs_nothing(tmp_path, image, kind, planes):
    options = {"photometric": "rgb", "extrasamples": [kind]}
    if planes:
        path = written(tmp_path, np.moveaxis(image, -1, 0), planarconfig="separate", **options)
    else:
        path = written(tmp_path, image, **options)
    np.testing.assert_array_equal(read_samples(path), image[..., :3])


def test_a_mosaic_in_a_tiff_is_one_channel(tmp_path):
    np.testing.assert_array_equal(read_samples(written(tmp_path, GREY16, photometric="cfa")), GREY16)


@pytest.mark.parametrize("bits", [10, 12, 14])
def test_packed_samples_are_right_aligned(tmp_path, bits):
    image = RNG.integers(0, 2**bits, (6, 8))
    text = "".join(f"{sample:0{bits}b}" for sample in image.ravel())
    data = int(text, 2).to_bytes(len(text) // 8, "big")
    start = 8 + 2 + 12 * 10 + 4
    tags = {256: 8, 257: 6, 258: bits, 259: 1, 262: 1, 273: start, 277: 1, 278: 6, 279: len(data), 284: 1}
    entries = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags.items())
    path = tmp_path / "packed.tif"
    path.write_bytes(b"II*\0" + struct.pack("<IH", 8, len(tags)) + entries + b"\0" * 4 + data)
    np.testing.assert_array_equal(read_samples(path), image)


@pytest.mark.parametrize(
    ("image", "options", "message"),
    [
        (np.stack([GREY16, GREY16 + 1]), {"photometric": "minisblack"}, "it holds 2 images; save each"),
        (RGBA8, {"photometric": "separated"}, "its samples are CMYK"),
        (RGB8, {"photometric": "cielab"}, r"its samples are CIE L\*a\*b\*"),
        (GREY16, {"photometric": "miniswhite"}, "its 0 is white and not black"),
        (GREY16.astype(np.float16), {}, "floating-point numbers of 16 bits"),
        (RGBA16[..., :2], {"planarconfig": "contig"}, "2 samples a pixel of 16 bits"),
    ],
)
def test_what_is_no_picture_of_a_sensor_is_refused_in_words(tmp_path, image, options, message):
    with pytest.raises(UserError, match=message):
        read_samples(written(tmp_path, image, **options))


def test_a_preview_behind_the_picture_is_passed_over(tmp_path):
    path = tmp_path / "a.tif"
    with tifffile.TiffWriter(path) as file:
        file.write(GREY16)
        file.write(GREY16, subfiletype=1)
        file.write(GREY8[::4, ::4])
    np.testing.assert_array_equal(read_samples(path), GREY16)
