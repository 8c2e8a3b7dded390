"""Flats whose expectation is a mean of a few noisy files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tacos_gap.captures import RealCapture
from tacos_gap.captures.even_light import with_even_light
from tests.gap.small_captures import BLACK_DN, HEIGHT, WIDTH, capture

FRAMES = 4


def light(level: float = 100.0) -> NDArray[np.float64]:
    """(H, W) light that falls off, brighter on one side [DN above the pedestal]."""
    y, x = np.meshgrid(np.linspace(-1, 1, HEIGHT), np.linspace(-1, 1, WIDTH), indexing="ij")
    return np.asarray(level * (1 - 0.15 * (x**2 + y**2) + 0.04 * x))


def noisy(signal: NDArray[np.float64], seed: int, frames: int = 1) -> NDArray[np.float32]:
    """(frames, H, W, 1) files with the noise that small captures state."""
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal((frames, *signal.shape)) * np.sqrt(1.8 + 0.24 * signal)
    return np.asarray(BLACK_DN + signal + noise, np.float32)[..., None]


def flat(expected: NDArray[np.float64], real: NDArray[np.float64]) -> RealCapture:
    believed = capture("flat", "flat", BLACK_DN + 100.0)
    mean = noisy(expected, 1, FRAMES).mean(axis=0, keepdims=True)
    return replace(believed, expected_dn=mean, real_dn=noisy(real, 2, 3), expected_frames=FRAMES)


def test_the_light_behind_a_noisy_mean_is_expected():
    of = with_even_light(flat(light(), light()))
    assert of.expected_frames == 0
    assert of.expected_dn is not None
    off = of.expected_dn[0, ..., 0] - BLACK_DN - light()
    assert off.std() < 0.06  # noise of the mean is 2.4
    assert np.abs(off).max() < 0.4  # in the very corners


def test_what_the_real_camera_repeats_is_left_to_be_found():
    pattern = 1 + 0.02 * np.random.default_rng(3).standard_normal((HEIGHT, WIDTH))
    assert with_even_light(flat(light(), light() * pattern)).expected_frames == 0


def test_a_mean_of_the_real_cameras_own_files_expects_its_pattern():
    pattern = 1 + 0.02 * np.random.default_rng(3).standard_normal((HEIGHT, WIDTH))
    of = flat(light() * pattern, light() * pattern)
    assert with_even_light(of) is of


def test_light_with_structure_stays_as_it_is():
    stripes = light() * (1 + 0.02 * np.sign(np.sin(np.arange(WIDTH) / 20)))
    of = flat(stripes, light())
    assert with_even_light(of) is of


@pytest.mark.parametrize("changes", [{"kind": "scene"}, {"expected_frames": 0}])
def test_only_flats_of_stated_noise_are_smoothed(changes):
    of = replace(flat(light(), light()), **changes)
    assert with_even_light(of) is of
