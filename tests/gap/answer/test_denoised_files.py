"""Files that software of another make smoothed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from tacos_framework import Plugins
from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.captures import CaptureFolder, Noise, RealCapture
from tacos_gap.hypotheses.candidates import candidates
from tests.gap.small_captures import BLACK_DN, HEIGHT, WIDTH, capture

GAIN_DN, READ_DN = 0.25, 1.2


def non_local_means(file: np.ndarray) -> np.ndarray:
    """Its strength is one number for all levels."""
    return cv2.fastNlMeansDenoising(file, None, 1.2, 3, 11)


def median(file: np.ndarray) -> np.ndarray:
    """Smooths all levels alike."""
    return cv2.medianBlur(file, 3)


def smoothed(kind: str, level_dn: float, software, rng: np.random.Generator) -> RealCapture:
    electrons = rng.poisson(level_dn / GAIN_DN, (4, HEIGHT, WIDTH))
    taken = GAIN_DN * electrons + rng.normal(0, READ_DN, electrons.shape) + BLACK_DN
    files = [software(file) for file in np.clip(np.rint(taken), 0, 255).astype(np.uint8)]
    noise = Noise((GAIN_DN,), (READ_DN**2 + 1 / 12,))
    expected = capture(f"{kind}_{level_dn:g}", kind, BLACK_DN + level_dn)
    return replace(expected, real_dn=np.stack(files).astype(np.float32)[..., None], noise=noise)


@pytest.mark.parametrize(("software", "parameter"), [(non_local_means, "threshold"), (median, "strength")])
def test_denoising_is_named_by_the_noise_it_leaves_at_each_level(software, parameter):
    rng = np.random.default_rng(4)
    taken = [("dark", 0.0), ("flat", 40.0), ("flat", 90.0), ("flat", 160.0)]
    captures = tuple(smoothed(kind, level, software, rng) for kind, level in taken)
    found = diagnose(CaptureFolder(Path("captures"), captures), candidates(Plugins.discover()))
    first = found.causes[0]
    assert first.effect == "denoise"
    assert first.present > 0.5
    assert parameter in first.parameters
