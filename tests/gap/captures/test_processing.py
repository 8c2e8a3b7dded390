"""Files that a camera's software has changed are recognised as such, and raw ones are not."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from skimage.filters import unsharp_mask
from skimage.restoration import denoise_bilateral

from tacos_framework import ImageContext
from tacos_gap.captures import RealCapture
from tacos_gap.captures.processing import traces_of_processing
from tests.gap.captures.targets.test_slanted_edge import edge
from tests.gap.taken import capture

SHAPE = (180, 240)


def made(kind: str, frames: list[np.ndarray]) -> RealCapture:
    """A grey capture of 8 bits without a pedestal, named by its kind."""
    real = np.clip(np.rint(np.stack(frames)), 0, 255)[..., None].astype(np.float32)
    context = ImageContext(exposure_s=0.01, black_level_dn=0.0, white_level_dn=255.0)
    valid = np.ones(real.shape[1:3], bool)
    own = replace(capture(kind, 0.0), id=kind, real_dn=real, valid=valid, context=context)
    return replace(own, expected_dn=None)


def walls(process=lambda image: image) -> RealCapture:
    rng = np.random.default_rng(5)
    return made("flat", [process(rng.normal(120, 4, SHAPE)) for _ in range(2)])


@pytest.mark.parametrize(
    "process",
    [
        lambda image: cv2.GaussianBlur(image, (0, 0), 0.8),
        lambda image: cv2.medianBlur(image.astype(np.float32), 3),
        lambda image: 255 * denoise_bilateral(image / 255, sigma_color=0.05, sigma_spatial=1.2),
    ],
    ids=["gaussian", "median", "bilateral"],
)
def test_noise_that_was_smoothed_is_told_from_that_of_a_sensor(process):
    (said,) = traces_of_processing([walls(process)])
    assert said.startswith("noise was smoothed (that of neighbours correlates by 0.")
    assert "in flat)" in said
    assert traces_of_processing([walls()]) == []
    leaky = walls(lambda image: image + 0.04 * (np.roll(image, 1, 0) + np.roll(image, 1, 1) - 2 * image))
    assert traces_of_processing([leaky]) == []


def test_walls_under_a_lamp_that_flickers_are_not_smoothed():
    rng = np.random.default_rng(5)
    waves = [8 * np.sin(2 * np.pi * np.arange(SHAPE[0]) / 57 + phase)[:, None] for phase in (0.0, 2.0)]
    assert traces_of_processing([made("flat", [rng.normal(120, 2, SHAPE) + wave for wave in waves])]) == []


def test_halos_are_told_from_blur_and_noise():
    rng = np.random.default_rng(6)
    blurred = np.asarray(edge(5, 1.2, SHAPE), float)
    noise = rng.normal(0, 1.0, SHAPE)
    assert traces_of_processing([made("edge", [blurred + noise])]) == []
    sharp = unsharp_mask(blurred / 255, radius=2, amount=1.0, preserve_range=True) * 255
    (said,) = traces_of_processing([made("edge", [sharp + noise])])
    assert said.startswith("edges were sharpened (they overshoot by ")
