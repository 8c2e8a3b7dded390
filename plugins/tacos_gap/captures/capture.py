"""A capture in memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tacos_framework import FileCoding, ImageContext, ImageGeometry
from tacos_framework.camera import Places
from tacos_framework.formation import PlacedSensor

PRINTED_WITHIN = 0.02
"""Relative accuracy of the reflectance of a printed patch."""


@dataclass(frozen=True)
class Noise:
    """Affine noise of the files, before rounding and clipping."""

    photon_dn: tuple[float, ...]
    """Variance per DN of signal above the pedestal, one per channel or one for all [DN]."""
    thermal_dn2: tuple[float, ...]  # variance at no signal, likewise [DN^2]
    known: bool = True
    """False where it was estimated from the real frames: it then says nothing about the simulator."""

    def variance_dn2(self, signal_dn: NDArray[np.float32], photon_scale: float = 1.0) -> NDArray[np.float32]:
        """Variance for a signal above the pedestal, (..., C) [DN^2]."""
        photon = np.asarray(self.photon_dn, np.float32) * np.float32(photon_scale)
        return photon * np.maximum(signal_dn, 0) + np.asarray(self.thermal_dn2, np.float32)


@dataclass(frozen=True)
class Board:
    """A flat target; views of equal boards are views of one and the same."""

    inner_corners: tuple[int, int]  # columns and rows of inner corners, or of circles
    square_mm: float
    """Side of its squares, or distance from circle to circle; of rows of asymmetric circles half of it is the
    distance between rows [mm]."""
    pattern: str = "chessboard"  # chessboard, charuco, circles or asymmetric_circles
    marker_mm: float = 0.0  # side of the markers of a ChArUco board
    dictionary: str = ""  # OpenCV's name, of those markers


@dataclass(frozen=True, eq=False)
class Objects:
    """Object that each pixel of a still shows."""

    ids: NDArray[np.int32]  # (H, W) int32 index into `classes`; 0 is the background
    classes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Unmoved:
    """An expectation before another pose moved it, so that effects that move it further read it only once."""

    expected_dn: NDArray[np.float32]  # (1 or N, H, W, C) float32 expected values [DN]
    source: Places  # (H, W) columns and rows where the moved expectation looks in this one [px]


@dataclass(frozen=True, eq=False)
class Whole:
    """The files of a capture that is kept in part."""

    geometry: ImageGeometry
    small_dn: NDArray[np.float32]  # (h, w, C) the first frame, made small [DN]


@dataclass(frozen=True, eq=False)
class RealCapture:
    """Real frames of one thing under one setting, and what the simulator expects."""

    id: str
    kind: str
    real_dn: NDArray[np.float32]  # (N, H, W, C) float32 files, C = 1 or 3 [DN]
    expected_dn: NDArray[np.float32] | None
    """(1 or N, H, W, C) float32 noise-free expected values with the pedestal [DN]; None for a board."""
    valid: NDArray[np.bool_]  # (H, W) bool; False where `expected_dn` says nothing
    geometry: ImageGeometry  # where the pixels lie
    context: ImageContext  # what else is known
    noise: Noise
    exposure_stated: bool = True  # whether ``exposure_ms`` was given
    group: str | None = None
    """As in ``captures.yaml``, like the three below; `expected_frames` 0: an expectation without noise."""
    level_uncertainty: float = 0.0
    expected_frames: int = 0
    board: Board | None = None
    coding: FileCoding | None = None
    """How its files were coded, by their own headers; None where they are not lossy."""
    own_edges: bool = False
    """Whether `expected_dn` was read off the edges of the pictures themselves: it then says how sharp they
    would be, and neither where they are nor how bright."""
    own_level: bool = False
    """Whether `expected_dn` is as bright as the pictures themselves, as that of walls and brackets is."""
    own_light: Literal["smooth", "pixel by pixel"] | None = None
    """How `expected_dn` is the light of a bracket as this very camera sees it, at all exposure times alike:
    what lens and colours do to it is in there already, and pixel by pixel also what pixels do."""
    edge_angle_deg: float | None = None
    patches: tuple[NDArray[np.int64], NDArray[np.float64]] | None = None
    """(P, 4) int x, y, width, height of chart patches [px], and (P, 3) float expected linear RGB [DN]."""
    row_time_us: float = 0.0  # readout from row to row that is in `expected_dn` already [us]
    motion_blurred: bool = False  # whether the blur of motion during the exposure is in `expected_dn` already
    taken_s: float | None = None
    """When it was taken, from the same moment on as others of its folder; None where nobody said it [s]."""
    sensor: PlacedSensor | None = None  # the sensor component that simulates it; None stands for `noise`
    notes: tuple[str, ...] = ()
    unstated: frozenset[str] = frozenset()  # what of the lens nobody stated: focal_length, principal_point
    corners: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None
    """(K, 3) points of the board [mm] and (K, 2) where they are seen [px]; None until they were found."""
    objects: Objects | None = None
    """What a still shows, for tasks that find things; None where nobody labelled it."""
    unmoved: Unmoved | None = None
    """What `expected_dn` was before it was moved to another pose; None where it was not."""
    whole: Whole | None = None  # None where all of its files is kept

    @property
    def frames(self) -> int:
        return len(self.real_dn)

    @property
    def is_mosaic(self) -> bool:
        """True if the one channel of its files holds a colour filter array."""
        return self.context.cfa is not None and self.real_dn.shape[-1] == 1

    def of_at_most(self, pixels: int) -> RealCapture:
        """With as many of its repeated frames as hold so many pixels, but two where there are two."""
        assert self.expected_dn is None or len(self.expected_dn) in (1, self.frames)
        enough = max(2, pixels // self.valid.size)
        if self.frames <= enough or self.expected_dn is None or len(self.expected_dn) > 1:
            return self
        return replace(self, real_dn=self.real_dn[:enough])

    @property
    def target_within(self) -> float:
        """Relative accuracy to which the target's reflectances are known; 0 where nobody printed them.

        Prints of charts differ and fade, and gloss adds to them.
        """
        return PRINTED_WITHIN if self.patches is not None else 0.0

    @property
    def is_structured(self) -> bool:
        """True if it shows edges or texture that is not its own, rather than an even field."""
        is_even = self.kind in ("dark", "flat", "board") or self.own_light
        return not is_even and self.expected_dn is not None

    @property
    def shows_patterns(self) -> bool:
        """True if its expectation has no patterns of its own pixels, and files may show some."""
        return self.kind in ("dark", "flat", "bracket") and self.own_light != "pixel by pixel"


@dataclass(frozen=True, eq=False)
class CaptureFolder:
    """All captures of a folder, and what was noticed while reading that is no error."""

    path: Path
    captures: tuple[RealCapture, ...]
    limitations: tuple[str, ...] = field(default=())


def usual_gain_db(captures: Sequence[RealCapture]) -> float:
    """The gain that most captures were taken at: charges in digital numbers hold there [dB]."""
    gains = [capture.context.gain_db for capture in captures]
    return max(gains, key=gains.count)
