"""Temporal noise: photon transfer, correlation between neighbours and channels, lattice, tails."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tacos_gap.statistics.block import Sample, StatisticBlock
from tacos_gap.statistics.grid import has_even_areas, levels, smooth_areas
from tacos_gap.statistics.masked import only_in
from tacos_plugins.noise_calibration.photon_transfer import ROUNDING_DN2

LAGS = ((0, 1), (1, 0), (1, 1), (0, 2), (2, 0), (1, -1), (0, 4), (4, 0))
"""Neighbours, as rows and columns away [px]."""

_FLOOR_DN2 = 1e-3
_LAPLACIAN = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32) / 6


def noise_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Noise of repeated frames; of a single one, what a high-pass leaves in even areas."""
    if sample.repeats:
        planes = sample.planes
        yield from _photon_transfer(sample, sample.variance, "photon_transfer", None, 0.02)
        counted = np.broadcast_to(
            sample.valid[sample.bands], (len(sample.frames), *sample.bands.shape, sample.valid.shape[1])
        )
        yield _tails(planes, counted.reshape(planes.shape[1:]))
    else:
        if not has_even_areas(sample.capture):
            return
        even = smooth_areas(sample.capture) & sample.valid
        noise = only_in(even, sample.frames[0] - sample.expected[0])
        yield from _photon_transfer(sample, _high_pass(noise) ** 2, "spatial_noise", even, 0.03)
        planes = sample.in_planes(noise[None, sample.bands.ravel()])
    if sample.capture.noise.known or sample.repeats:
        yield from _correlation(sample, planes)
        yield from _lattice(sample, planes)


def _photon_transfer(
    sample: Sample,
    variance: NDArray[np.float32],
    name: str,
    areas: NDArray[np.bool_] | None,
    amplitude: float,
) -> Iterator[StatisticBlock]:
    if not sample.capture.noise.known:
        return
    for channel, label in enumerate(sample.channels):
        bins = levels(sample.capture, channel, areas)
        if areas is None:
            bins = bins.in_rows(sample.bands)
        if bins.at:
            measured = bins.mean(variance[..., channel])
            # a variance far below that of rounding is a matter of rounding, not of noise
            yield StatisticBlock(
                name,
                "pixel",
                np.log(measured + _FLOOR_DN2),
                [{**at, "channel": label} for at in bins.at],
                np.hypot(amplitude, 0.01 / (measured + _FLOOR_DN2)),
            )


def _tails(planes: NDArray[np.float32], valid: NDArray[np.bool_]) -> StatisticBlock:
    """Kurtosis of the noise with normal noise as large as rounding added, without which little has tails."""
    square = np.square(planes if valid.all() else planes[:, valid])
    second, fourth = float(square.mean()), float(np.vdot(square, square)) / square.size
    added = ROUNDING_DN2
    kurtosis = (fourth + 6 * added * second + 3 * added**2) / (second + added) ** 2
    return StatisticBlock("noise_tails", "readout", np.array([np.log(kurtosis)]), [{}], 0.03)


def _correlation(sample: Sample, planes: NDArray[np.float32]) -> Iterator[StatisticBlock]:
    step = 2 if sample.capture.context.cfa else 1
    for plane, label in zip(planes, sample.channels, strict=True):
        variance = max(float(np.vdot(plane, plane)) / plane.size, ROUNDING_DN2)
        values = [_lagged(plane, rows * step, columns * step) / variance for rows, columns in LAGS]
        at = [{"lag_px": [columns * step, rows * step], "channel": label} for rows, columns in LAGS]
        yield StatisticBlock("noise_autocorrelation", "pixel", np.array(values), at, 0.004)
    if len(sample.channels) == 3:
        pairs = ((0, 1), (1, 2), (0, 2))
        flat = planes.reshape(3, -1)
        covariance = flat @ flat.T / flat.shape[1]
        spread = np.sqrt(np.maximum(np.diag(covariance), 1e-6))
        values = [float(covariance[a, b] / (spread[a] * spread[b])) for a, b in pairs]
        at = [{"channels": sample.channels[a] + sample.channels[b]} for a, b in pairs]
        yield StatisticBlock("channel_correlation", "isp", np.array(values), at, 0.005)


def _lagged(plane: NDArray[np.float32], rows: int, columns: int) -> float:
    height, width = plane.shape[1:]
    a = plane[:, : height - rows, max(-columns, 0) : width - max(columns, 0)]
    b = plane[:, rows:, max(columns, 0) : width - max(-columns, 0)]
    return float(np.einsum("nij,nij->", a, b) / a.size)


def _lattice(sample: Sample, planes: NDArray[np.float32]) -> Iterator[StatisticBlock]:
    """Variance at the four places of a 2 x 2 lattice, which only a demosaiced image tells apart."""
    if sample.capture.context.cfa:
        return
    for plane, label in zip(planes, sample.channels, strict=True):
        height, width = (size // 2 * 2 for size in plane.shape[1:])
        pairs = plane[:, :height, :width].reshape(-1, 2, width)
        columns = np.einsum("nrw,nrw->rw", pairs, pairs)
        phases = columns.reshape(2, -1, 2).sum(axis=1, dtype=np.float64).ravel() / (pairs.size / 4)
        logs = np.log(np.maximum(phases, ROUNDING_DN2))
        value = logs - logs.mean()
        at = [{"lattice": [c, r], "channel": label} for r in (0, 1) for c in (0, 1)]
        yield StatisticBlock("noise_lattice", "isp", value, at, 0.02)


def _high_pass(image: NDArray[np.float32]) -> NDArray[np.float32]:
    import cv2

    return np.asarray(cv2.filter2D(image, cv2.CV_32F, _LAPLACIAN).reshape(image.shape), np.float32)
