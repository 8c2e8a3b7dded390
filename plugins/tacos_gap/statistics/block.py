"""Input and output of a family of statistics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures import RealCapture
from tacos_gap.statistics.line_means import line_means_of_frames, over_frames
from tacos_gap.statistics.masked import only_in
from tacos_gap.statistics.sampled import noise_bands, sampled
from tacos_gap.statistics.steady_light import levels_of_frames
from tacos_plugins.effects.darks import ROUNDING_DN, isolated, middle_and_spread


@dataclass(frozen=True, eq=False)
class StatisticBlock:
    statistic: str  # its name, e.g. ``"relative_illumination"``
    stage: str  # the stage of image formation that shows in it most often
    values: NDArray[np.float64]
    at: Sequence[Mapping[str, Any]]
    """For each number where it was taken: ``{"radius": [0.7, 1.0]}``, ``{"channel": "R"}``."""
    margin: NDArray[np.float64] | float
    """Equivalence margin: smaller differences are negligible, however significant; a number or one each."""


class Sample:
    """Frames of a capture, real or simulated, prepared for measuring.

    What bins and tiles are made of comes from the expectation alone, so that real and simulated frames are
    measured alike.

    `noisier_dn`: (N, H, W, C) the frames with noise added, as `expected_dn` holds noise of its own (see
    `tacos_gap.nuisances.noisy_expectation`): what is measured but codes and codecs [DN].
    """

    def __init__(
        self,
        capture: RealCapture,
        frames_dn: NDArray[np.float32],
        expected_dn: NDArray[np.float32],
        noisier_dn: NDArray[np.float32] | None = None,
    ):
        self.capture = capture
        self.as_taken = frames_dn
        self.frames = frames_dn if noisier_dn is None else noisier_dn
        self.files = frames_dn
        if capture.kind == "dark":
            self.frames = without_hot_pixels(self.frames, expected_dn)
            self.files = self.frames if noisier_dn is None else without_hot_pixels(frames_dn, expected_dn)
        self.expected = expected_dn

    @cached_property
    def reference(self) -> NDArray[np.float32]:
        """(H, W, C) mean of the expectation over frames [DN]."""
        return over_frames(self.expected)

    @cached_property
    def mean(self) -> NDArray[np.float32]:
        """(H, W, C) mean of the frames [DN]."""
        return over_frames(self.frames)

    @cached_property
    def residual(self) -> NDArray[np.float32]:
        """(H, W, C) mean of the frames less the expectation [DN]."""
        return self.mean - self.reference

    @cached_property
    def residual_as_taken(self) -> NDArray[np.float32]:
        """(H, W, C) `residual` with the hot pixels of the dark, and without added noise [DN]."""
        if self.as_taken is self.frames:
            return self.residual
        return over_frames(self.as_taken) - self.reference

    @cached_property
    def halves(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Means of every second frame, and of the others, less the expectation, (H, W, C) each [DN]."""
        one, other = (over_frames(self.frames[half::2]) for half in (0, 1))
        return one - self.reference, other - self.reference

    @cached_property
    def signal(self) -> NDArray[np.float32]:
        """(H, W, C) expected signal above the pedestal, of the capture as it was read [DN]."""
        return expected_signal(self.capture)

    @property
    def repeats(self) -> bool:
        """True if several frames show the same, so that noise and fixed patterns come apart."""
        return len(self.frames) > 1 and len(self.expected) == 1

    @cached_property
    def bands(self) -> NDArray[np.int64]:
        """(B, R) the rows that noise is measured in, band by band; see `noise_bands`."""
        return noise_bands(self.frames.shape)

    @cached_property
    def row_means(self) -> NDArray[np.float32]:
        """(N, H, C) means of the rows of each frame [DN]."""
        return line_means_of_frames(self.frames, 1)

    @cached_property
    def light_of_frames(self) -> NDArray[np.float32]:
        """(N, 1, C) level of each frame over that of their mean; see `levels_of_frames`."""
        if self.valid.all():
            return levels_of_frames(self.capture, self.row_means)
        counted = only_in(self.valid, self.frames)
        return levels_of_frames(self.capture, line_means_of_frames(counted, 1))

    @cached_property
    def temporal(self) -> NDArray[np.float32]:
        """(N, B R, W, C) noise of pixels in `bands`: frames less their mean, in steady light [DN].

        Without what the pixels of a row share in a frame, which is measured by itself: a lamp that flickers
        parts two frames by another amount each time. Its mean square is the variance.
        """
        from tacos_gap.statistics.noise_loops import part_from_mean

        count, height, width, channels = self.frames.shape
        rows = self.bands.ravel()
        scale = np.float32(np.sqrt(count / (count - 1) * width / max(width - 1, 1)))
        black = np.float32(self.capture.context.black_level_dn)
        over = np.tile((scale / self.light_of_frames)[:, 0], width)  # as `in_steady_light`, in one pass
        noise = np.empty((count, len(rows), width * channels), np.float32)
        in_rows = self.frames.reshape(count, height, -1), self.mean.reshape(height, -1)
        part_from_mean(*in_rows, rows, over, black * (scale - over), scale, channels, noise)
        return noise.reshape(count, len(rows), width, channels)

    @cached_property
    def planes(self) -> NDArray[np.float32]:
        """(C, N B, R, W) `temporal`, channel by channel and band by band [DN]."""
        return self.in_planes(self.temporal)

    def in_planes(self, noise: NDArray[np.float32]) -> NDArray[np.float32]:
        """(C, N B, R, W) noise (N, B R, W, C) of the rows of `bands`, contiguous in memory."""
        frames, _, width, channels = noise.shape
        bands, rows = self.bands.shape
        return np.ascontiguousarray(np.moveaxis(noise, -1, 0)).reshape(channels, frames * bands, rows, width)

    @cached_property
    def variance(self) -> NDArray[np.float32]:
        """(B R, W, C) variance over frames in the rows of `bands` [DN^2]."""
        return np.asarray(np.einsum("nhwc,nhwc->hwc", self.temporal, self.temporal) / len(self.frames))

    @property
    def channels(self) -> tuple[str, ...]:
        return ("R", "G", "B") if self.frames.shape[-1] == 3 else ("mono",)

    @property
    def valid(self) -> NDArray[np.bool_]:
        return self.capture.valid


_SIGNALS: WeakKeyDictionary[RealCapture, NDArray[np.float32]] = WeakKeyDictionary()


def expected_signal(capture: RealCapture) -> NDArray[np.float32]:
    """(H, W, C) what the simulator expects above the pedestal; worked out once per capture [DN]."""
    if capture not in _SIGNALS:
        assert capture.expected_dn is not None
        _SIGNALS[capture] = over_frames(capture.expected_dn) - np.float32(capture.context.black_level_dn)
    return _SIGNALS[capture]


_MEANS: WeakKeyDictionary[RealCapture, NDArray[np.float64]] = WeakKeyDictionary()


def mean_signal(capture: RealCapture) -> NDArray[np.float64]:
    """(C,) mean of what is expected above the pedestal in the pixels that count; worked out once [DN]."""
    if capture not in _MEANS:
        _MEANS[capture] = expected_signal(capture)[capture.valid].mean(axis=0, dtype=np.float64)
    return _MEANS[capture]


_HOT_SPREADS = 6.0
"""A pixel is hot that stands above the middle one by so many robust standard deviations and a rounding."""


def without_hot_pixels(
    frames_dn: NDArray[np.float32], expected_dn: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Dark frames whose hot pixels show what is expected, so that a handful do not rule every statistic.

    Bright pieces of rows and columns stay: they are patterns, not single pixels.
    """
    steady = np.minimum.reduce(frames_dn) - expected_dn[0]
    _, spread = middle_and_spread(sampled(frames_dn[0] - expected_dn[0]))
    hot = isolated(steady - np.median(sampled(steady)) > ROUNDING_DN + _HOT_SPREADS * spread)
    return np.where(hot[None], expected_dn, frames_dn) if hot.any() else frames_dn
