"""Frames as tasks want them, against OpenCV and the curve of sRGB."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tacos_framework.camera.colour import srgb_from_linear
from tacos_framework.formation import as_wanted, frames_for
from tacos_framework.testing.samples import sample_capture
from tacos_framework.values import FrameBatch

CAPTURE = sample_capture()
SIZE = (*CAPTURE.views[0].depth_m.shape, 3)
RNG = np.random.default_rng(4)


def frames(
    images: np.ndarray, black: float = 0.0, white: float = 255.0, *, coded: bool = False
) -> FrameBatch:
    return FrameBatch(CAPTURE, (images,) * len(CAPTURE.views), black, white, coded=coded)


def test_linear_files_are_coded_by_the_curve_of_srgb() -> None:
    files = RNG.integers(0, 4096, SIZE).astype(np.uint16)
    wanted = as_wanted(frames(files, 64, 4095), "coded")
    expected = np.rint(255 * srgb_from_linear((files - 64.0) / (4095 - 64)))
    np.testing.assert_array_equal(wanted.images[0], expected)
    assert (wanted.coded, wanted.black_level_dn, wanted.white_level_dn) == (True, 0.0, 255.0)
    assert wanted.images[0].dtype == np.uint8


def test_coded_files_are_coded_once() -> None:
    eight = frames(RNG.integers(0, 256, SIZE).astype(np.uint8), coded=True)
    assert np.shares_memory(as_wanted(eight, "coded").images[0], eight.images[0])
    deep = frames(eight.images[0].astype(np.uint16) * 16 + 64, 64, 64 + 255 * 16, coded=True)
    np.testing.assert_array_equal(as_wanted(deep, "coded").images[0], eight.images[0])


def test_grey_is_the_luma_that_opencv_gives() -> None:
    coded = frames(RNG.integers(0, 256, SIZE).astype(np.uint8), coded=True)
    grey = as_wanted(coded, "grey").images[0]
    expected = cv2.cvtColor(coded.images[0][0], cv2.COLOR_RGB2GRAY)
    assert grey.shape == (*SIZE[:3], 1)
    assert np.abs(grey[0, ..., 0].astype(int) - expected).max() <= 1
    mono = frames(RNG.integers(0, 256, (*SIZE[:3], 1)).astype(np.uint8), coded=True)
    np.testing.assert_array_equal(as_wanted(mono, "grey").images[0], mono.images[0])


@pytest.mark.parametrize("wants", [None, "linear"])
def test_others_take_frames_as_they_are(wants: str | None) -> None:
    given = frames(RNG.integers(0, 256, SIZE).astype(np.uint8))
    task = type("Task", (), {"wants": wants})()
    assert frames_for(task, given) is given
