"""The JPEG effect, against Pillow's encoder and the format's own tables."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image
from scipy import fft, ndimage

from tacos_plugins.effects.jpeg import Jpeg
from tests.effects.sample_arrays import make, run

_GREY = np.random.default_rng(7).normal(0, 1, (64, 96))
SCENE = np.clip(128 + 200 * ndimage.gaussian_filter(_GREY, 2), 0, 255).round()
COLOUR = np.stack([SCENE, np.roll(SCENE, 9, axis=1), SCENE[::-1]], axis=-1)[None]
SUBSAMPLING = {"4:4:4": 0, "4:2:2": 1, "4:2:0": 2}


def through_pillow(image: np.ndarray, **options: int) -> np.ndarray:
    file = io.BytesIO()
    Image.fromarray(image.astype(np.uint8)).save(file, "JPEG", **options)
    return np.asarray(Image.open(file)).astype(float)


@pytest.mark.parametrize("quality", [20, 60, 95])
@pytest.mark.parametrize("subsampling", SUBSAMPLING)
def test_it_agrees_with_pillow(quality, subsampling):
    ours = run(make(Jpeg, quality=quality, subsampling=subsampling), COLOUR)[0]
    theirs = through_pillow(COLOUR[0], quality=quality, subsampling=SUBSAMPLING[subsampling])
    assert np.abs(ours - theirs).mean() < 0.5
    assert np.sqrt(((theirs - COLOUR[0]) ** 2).mean()) > 1.5 * np.sqrt(((ours - theirs) ** 2).mean())


def test_colours_coded_more_coarsely_agree_with_pillow_and_its_tables():
    tables = {}
    for quality in (90, 40):
        file = io.BytesIO()
        Image.new("RGB", (8, 8)).save(file, "JPEG", quality=quality)
        tables[quality] = Image.open(file).quantization
    theirs = through_pillow(COLOUR[0], qtables=[tables[90][0], tables[40][1]], subsampling=0)
    alike = run(make(Jpeg, quality=90, subsampling="4:4:4"), COLOUR)[0]
    ours = run(make(Jpeg, quality=90, chroma_offset=-50, subsampling="4:4:4"), COLOUR)[0]
    assert np.abs(ours - theirs).mean() < 0.5
    assert np.abs(alike - theirs).mean() > 4 * np.abs(ours - theirs).mean()


def test_blocks_hold_multiples_of_the_tables_steps():
    decoded = run(make(Jpeg, quality=50), SCENE[None, ..., None])[0, ..., 0]
    blocks = (decoded - 128).reshape(8, 8, 12, 8).swapaxes(1, 2)
    coefficients = fft.dctn(blocks, axes=(-2, -1), norm="ortho")
    # ITU-T T.81 table K.1 at quality 50 (as it stands): the step of coefficient (0, 1) is 11, of (1, 0) 12.
    for place, step in (((0, 1), 11), ((1, 0), 12)):
        values = coefficients[..., *place].ravel()
        inner = values[(np.abs(values) < 100)]
        assert np.abs(inner / step - np.rint(inner / step)).max() < 0.15  # rounded back to bytes


def test_quality_100_is_off_whatever_the_subsampling():
    assert run(make(Jpeg, quality=100, subsampling="4:2:0"), COLOUR) is COLOUR


def test_lower_quality_loses_more():
    errors = [np.abs(run(make(Jpeg, quality=q), COLOUR) - COLOUR).mean() for q in (95, 70, 30, 5)]
    assert errors == sorted(errors)
    assert errors[0] > 0.3


def test_deep_files_are_coded_in_eight_bits():
    deep = COLOUR * 4095 / 255
    seen = run(make(Jpeg, quality=90), deep, white_level_dn=4095.0)
    np.testing.assert_allclose(seen * 255 / 4095, run(make(Jpeg, quality=90), COLOUR), atol=1e-9)


def test_equal_frames_are_coded_alike_and_each_for_itself():
    pair = np.concatenate([COLOUR, COLOUR[:, ::-1]])
    seen = run(make(Jpeg, quality=50), pair)
    np.testing.assert_array_equal(seen[:1], run(make(Jpeg, quality=50), COLOUR))
