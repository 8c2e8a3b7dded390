"""Contrast of detail over that expected, by spatial frequency, direction and place."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures import RealCapture
from tacos_gap.statistics.block import Sample, StatisticBlock, mean_signal
from tacos_plugins.noise_calibration.photon_transfer import ROUNDING_DN2

TILE_PX, LEAST_TILE_PX = 64, 24
"""Sides of the tiles that detail is measured in; smaller ones where a region of interest holds no larger."""

BANDS = (0.03, 0.08, 0.16, 0.28, 0.42)
"""Borders of the bands of spatial frequency [cycles/px]."""

DIRECTIONS = 4
ZONES = (0.0, 0.45, 0.75, np.inf)
"""Borders of the zones, as radius over half the diagonal; a crop may lie wholly off the principal point."""

_LEAST_SHARE = 1e-7
"""Detail fainter than this share of full scale squared is lost in noise, of whatever camera."""

_ABOVE_NOISE = 3.0
"""Expected power over that of noise from which on a cell tells of detail."""

_LEAST_OF_A_BAND = 0.01
"""Expected power over that of the strongest direction of the same band below which a cell holds what a window
leaks into it: along itself a straight edge has no detail."""


def sharpness_statistics(sample: Sample) -> Iterator[StatisticBlock]:
    """Log power of real over expected detail."""
    capture = sample.capture
    if not capture.is_structured:
        return
    layout = _layout(capture)
    if layout is None:
        return
    green = 1 if len(sample.channels) == 3 else 0
    power = _power(sample.mean[..., green], layout)
    values = np.log((power + layout.least) / (layout.expected + layout.least))
    yield StatisticBlock("detail", "optics", values[layout.kept], layout.at, 0.03)


def has_detail(capture: RealCapture) -> bool:
    return _layout(capture) is not None


@dataclass(frozen=True, eq=False)
class _Layout:
    tile_px: int
    corners: Sequence[tuple[int, int]]
    zone: NDArray[np.int64]
    cell: NDArray[np.int64]
    expected: NDArray[np.float64]
    kept: NDArray[np.int64]
    least: float
    at: Sequence[Mapping[str, Any]]


_LAYOUTS: WeakKeyDictionary[RealCapture, list[_Layout | None]] = WeakKeyDictionary()
_CELLS = (len(BANDS) - 1) * DIRECTIONS


def _layout(capture: RealCapture) -> _Layout | None:
    if capture not in _LAYOUTS:
        _LAYOUTS[capture] = [_make_layout(capture)]
    return _LAYOUTS[capture][0]


def _make_layout(capture: RealCapture) -> _Layout | None:
    """Tiles with detail, which zone each is in, and the cells of frequency and direction with power."""
    assert capture.expected_dn is not None
    expected = capture.expected_dn.mean(axis=0)
    green = 1 if expected.shape[-1] == 3 else 0
    height, width = capture.valid.shape
    tile_px = min(TILE_PX, min(height, width) // 8 * 8)
    if tile_px < LEAST_TILE_PX:
        return None
    corners, zones = [], []
    for top in range(0, height - tile_px + 1, tile_px // 2 if height < 200 else tile_px):
        for left in range(0, width - tile_px + 1, tile_px // 2 if width < 200 else tile_px):
            part = (slice(top, top + tile_px), slice(left, left + tile_px))
            if capture.valid[part].mean() > 0.95 and np.ptp(expected[part][..., green]) > 4:
                corners.append((top, left))
                radius = float(capture.geometry.radius[part].mean())
                zones.append(int(np.searchsorted(ZONES, radius, side="right") - 1))
    if not corners:
        return None
    fy = np.fft.fftfreq(tile_px)[:, None]
    fx = np.fft.rfftfreq(tile_px)[None, :]
    band = np.searchsorted(BANDS, np.hypot(fx, fy), side="right") - 1
    sector = np.floor((np.degrees(np.arctan2(fy, fx)) % 180 + 22.5) / 45).astype(int) % DIRECTIONS
    cell = np.where((band >= 0) & (band < len(BANDS) - 1), band * DIRECTIONS + sector, -1)
    layout = _Layout(tile_px, corners, np.array(zones), cell, np.zeros(0), np.zeros(0, int), 0.0, [])
    power = _power(expected[..., green], layout)
    least = max(_LEAST_SHARE * capture.context.white_level_dn**2, _noise_power(capture, green))
    strongest = power.reshape(-1, DIRECTIONS).max(axis=1).repeat(DIRECTIONS)
    kept = np.flatnonzero((power > _ABOVE_NOISE * least) & (power > _LEAST_OF_A_BAND * strongest))
    at = [_place(int(k)) for k in kept]
    return _Layout(tile_px, corners, layout.zone, cell, power, kept, least, at)


def _noise_power(capture: RealCapture, channel: int) -> float:
    """Power of the noise in the mean of the frames, alike at all frequencies [DN^2 per frequency].

    Without it the cells that an edge leaves empty, along itself and beyond what a lens passes, compare noise
    with noise, to a hundredth.
    """
    level = mean_signal(capture)
    photon, thermal = (
        np.broadcast_to(each, level.shape)[channel]
        for each in (capture.noise.photon_dn, capture.noise.thermal_dn2)  # one may stand for all channels
    )
    return float((photon * max(float(level[channel]), 0.0) + thermal + ROUNDING_DN2) / capture.frames)


def _place(index: int) -> dict[str, Any]:
    zone, cell = divmod(index, _CELLS)
    band, sector = divmod(cell, DIRECTIONS)
    return {
        "radius": [ZONES[zone], min(ZONES[zone + 1], 1.0)],
        "frequency_cycles_px": [BANDS[band], BANDS[band + 1]],
        "direction_deg": 45 * sector,
    }


def _power(image: NDArray[np.float32], layout: _Layout) -> NDArray[np.float64]:
    """Mean power in each zone, band and direction [DN^2 per frequency]."""
    side = layout.tile_px
    window = np.hanning(side + 1)[:-1]
    stack = np.stack([image[t : t + side, c : c + side] for t, c in layout.corners]).astype(np.float32)
    stack = (stack - stack.mean(axis=(1, 2), keepdims=True)) * (window[:, None] * window[None, :]).astype(
        np.float32
    )
    spectrum = np.abs(np.fft.rfft2(stack)) ** 2 / (window**2).sum() ** 2
    used = layout.cell >= 0
    flat = spectrum[:, used]
    cell = layout.cell[used]
    powers = np.zeros((len(ZONES) - 1, _CELLS))
    for zone in np.unique(layout.zone):
        mean = flat[layout.zone == zone].mean(axis=0)
        powers[zone] = np.bincount(cell, mean, _CELLS) / np.maximum(np.bincount(cell, minlength=_CELLS), 1)
    return powers.ravel()
