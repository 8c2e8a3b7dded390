"""Captures of a real camera as an effect sees them, and what it may declare of them for a diagnosis."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tacos_framework.values import ImageContext, ImageGeometry


@dataclass(frozen=True)
class FileCoding:
    """Coding of lossy files, as they state it."""

    quality: int
    """As libjpeg counts it."""
    subsampling: str
    """Of the colours: 4:4:4, 4:2:2 or 4:2:0."""
    chroma_offset: int = 0
    """Quality of the colours less `quality`."""


class ObservedCapture(Protocol):
    """Real frames of one thing under one setting, and what the simulator expects of them."""

    @property
    def kind(self) -> str:
        """dark, flat, bracket, edge, board, chart, scene or sequence."""

    @property
    def group(self) -> str | None:
        """Captures of one group vary only in their exposure time."""

    @property
    def real_dn(self) -> NDArray[np.float32]:
        """(N, H, W, C) files [DN]."""

    @property
    def expected_dn(self) -> NDArray[np.float32] | None:
        """(1 or N, H, W, C) noise-free expectation with the pedestal; None where there is none [DN]."""

    @property
    def valid(self) -> NDArray[np.bool_]:
        """(H, W), False where the expectation says nothing."""

    @property
    def geometry(self) -> ImageGeometry:
        """Geometry of the pixels."""

    @property
    def context(self) -> ImageContext:
        """Circumstances of the picture."""

    @property
    def frames(self) -> int:
        """Number of real frames."""

    @property
    def is_structured(self) -> bool:
        """True if it shows edges or texture, rather than an even field."""

    @property
    def own_edges(self) -> bool:
        """True if the expectation was read off the picture's own edges: it tells no level and no place."""

    @property
    def coding(self) -> FileCoding | None:
        """Coding of its files; None where they are not lossy, or do not say."""

    @property
    def edge_angle_deg(self) -> float | None:
        """Angle of a straight edge; None without one [deg]."""

    @property
    def patches(self) -> tuple[NDArray[np.int64], NDArray[np.float64]] | None:
        """(P, 4) x, y, width, height of chart patches [px], and (P, 3) expected linear RGB [DN]."""

    @property
    def corners(self) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """(K, 3) points of a board [mm] and (K, 2) where they are seen [px]; None where there is none."""


Captures = Sequence[ObservedCapture]


@dataclass(frozen=True)
class LookAlike:
    """An effect that some captures cannot tell from the one that declares it."""

    effect: str
    """Name of the other effect, without ``effect.``."""
    holds: Callable[[Captures], bool]
    """True if these captures leave the two alike."""
    capture: str
    """The kind of capture that would tell them apart."""
    why: str
    """What that capture shows, in a few words."""


@dataclass(frozen=True)
class ShownBy:
    """Captures that it takes to speak of an effect."""

    met: Callable[[Captures], bool]
    """True if captures will do."""
    remedy: str
    """What to photograph: ``kind dark: frames with the cap on``."""


SURE = 3.0
"""Standard errors within which an estimate is believed."""


@dataclass(frozen=True)
class Estimate:
    """A closed-form estimate of a parameter of an effect from captures."""

    parameter: str
    """One that the effect's `neutral` names."""
    value: float
    standard_error: float
    """Both in its unit."""
    negligible: float
    """By how much it may part from neutral unnoticed, in its unit."""

    def is_seen(self, neutral: float) -> bool:
        """True if it surely parts from neutral, and by what matters.

        >>> Estimate("sigma", 0.008, 0.0002, 0.0007).is_seen(0.0)
        True
        """
        return abs(self.value - neutral) > max(SURE * self.standard_error, self.negligible)

    def is_excluded(self, neutral: float) -> bool:
        """True if it surely lies within what is negligible around neutral.

        >>> Estimate("sigma", 0.0002, 0.0001, 0.0007).is_excluded(0.0)
        True
        """
        return abs(self.value - neutral) + SURE * self.standard_error < self.negligible


def of_kind(captures: Captures, *kinds: str) -> list[ObservedCapture]:
    """The captures of some kinds."""
    return [capture for capture in captures if capture.kind in kinds]


def structured(captures: Captures) -> list[ObservedCapture]:
    """The captures that show edges or texture."""
    return [capture for capture in captures if capture.is_structured]


def lit(captures: Captures) -> list[ObservedCapture]:
    """All but those with the cap on."""
    return [capture for capture in captures if capture.kind != "dark"]
