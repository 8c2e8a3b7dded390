"""Noise of a camera, measured in frames of any scene."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

_BLOCK_PX = 8
_QUANTILE = 0.1
"""Of the blocks of one brightness the plainest tenth is taken to be without texture."""
_FREE = _BLOCK_PX**2 / 2
"""Independent differences in a block: neighbours share samples."""


@dataclass(frozen=True)
class LinearNoise:
    """Variance of light ``floor_dn2 + slope_dn * light`` [DN^2, DN]."""

    floor_dn2: float
    slope_dn: float

    def missing_dn2(self, light_dn: NDArray[np.float32], ratio: float) -> NDArray[np.float32]:
        """Variance to be added to light of a frame that was multiplied by `ratio`; below 0 it has too much.

        The frame carries its own noise times ``ratio**2``; only the rest is to be drawn.
        """
        signal = np.maximum(light_dn, 0)
        return np.asarray(self.floor_dn2 * (1 - ratio**2) + self.slope_dn * (1 - ratio) * signal, np.float32)


def measured_noise(lights_dn: Iterable[NDArray[np.float32]], *, mosaic: int, top_dn: float) -> LinearNoise:
    """Noise over light, from the plainest blocks at each brightness.

    - `lights_dn`: (N, H, W) frames of each exposure: short ones show the noise of darkness, long ones that
      of light.
    - `mosaic`: period of the colour filters [px].
    - `top_dn`: light from which on samples are clipped; blocks that reach it are left out [DN].

    Source: Liu et al. 2006, "Noise estimation from a single image": the lower envelope of variance over
    brightness.
    """
    means, variances = [], []
    for light_dn in lights_dn:
        for row, column in np.ndindex(mosaic, mosaic):
            plane = light_dn[:, row::mosaic, column::mosaic]
            bend = plane[:, 1:-1, 1:-1] - (plane[:, 1:-1, :-2] + plane[:, 1:-1, 2:]) / 2
            samples = _blocks(plane[:, 1:-1, 1:-1])
            whole = samples.max(-1) < top_dn
            means.append(samples[whole].mean(-1))
            variances.append((_blocks(np.asarray(bend, np.float32))[whole] ** 2).mean(-1) / 1.5)
    mean, variance = np.concatenate(means), np.concatenate(variances)
    if not len(mean):
        return LinearNoise(0.0, 0.0)
    edges = np.unique(np.quantile(mean, np.linspace(0, 0.95, 20)))
    if len(edges) < 3:
        return LinearNoise(max(float(np.quantile(variance, _QUANTILE)), 0.0), 0.0)
    which = np.digitize(mean, edges[1:-1])
    share = chi2.ppf(_QUANTILE, _FREE) / _FREE
    level = np.array([mean[which == i].mean() for i in range(len(edges) - 1)])
    lowest = np.array([np.quantile(variance[which == i], _QUANTILE) / share for i in range(len(edges) - 1)])
    weight = 1 / np.maximum(lowest, 1e-6)
    slope, floor = np.polyfit(level, lowest, 1, w=weight)
    return LinearNoise(max(float(floor), 0.0), max(float(slope), 0.0))


def _blocks(plane: NDArray[np.float32]) -> NDArray[np.float32]:
    """(blocks, samples) of (N, H, W)."""
    frames, height, width = plane.shape
    rows, columns = height // _BLOCK_PX, width // _BLOCK_PX
    cut = plane[:, : rows * _BLOCK_PX, : columns * _BLOCK_PX]
    split = cut.reshape(frames, rows, _BLOCK_PX, columns, _BLOCK_PX).transpose(0, 1, 3, 2, 4)
    return np.asarray(split.reshape(-1, _BLOCK_PX**2))
