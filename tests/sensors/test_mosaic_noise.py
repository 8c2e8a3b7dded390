"""Noise of averaged mosaics, against OpenCV's demosaicing and its area averages."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tacos_plugins.sensors.mosaic_noise import averaged_variances

SIDE_PX, LEVEL_DN, SIGMA_DN = 1200, 30_000, 1_000


@pytest.mark.parametrize("binning", [1, 2, 3, 4, 6])
def test_variances_are_those_of_a_mosaic_that_is_reconstructed_and_averaged(binning: int) -> None:
    rng = np.random.default_rng(binning)
    mosaic = np.rint(rng.normal(LEVEL_DN, SIGMA_DN, (SIDE_PX, SIDE_PX))).astype(np.uint16)
    colours = cv2.cvtColor(mosaic, cv2.COLOR_BayerRGGB2RGB)[12:-12, 12:-12].astype(np.float64)
    side = len(colours) // binning * binning
    blocks = colours[:side, :side].reshape(side // binning, binning, side // binning, binning, 3)
    found = blocks.mean(axis=(1, 3)).var(axis=(0, 1)) / SIGMA_DN**2
    assert averaged_variances(binning) == pytest.approx(found, rel=0.03)
