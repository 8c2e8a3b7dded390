"""Print: ink on paper. What a blurred picture of it would be if nothing had blurred it.

Of all even blurs, that one is taken whose undoing leaves two tones which, blurred again, give the picture:
grey between ink and paper is blur, or else the picture shows no print.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import fft

from tacos_gap.captures.capture import RealCapture
from tacos_plugins.effects.blur import Transfer, disc_transfer, gaussian_transfer, line_transfer

EXPLAINED = 0.8
"""Share of the picture's variance that two tones must explain, blurred."""

PAPER_PX = 61
"""Window in which there is paper wherever one looks: wider than a line of print [px]."""

LARGEST_PX = 512
"""Side of the part with most ink that the blur is looked for in [px]."""

BORDER_PX = 24
"""What lies outside the picture has been blurred into its border: nothing is expected there [px]."""

_NOISE_TO_SIGNAL = 0.01
"""Power of noise over that of print, for Wiener's filter: less, and dots of ink make up any grey there is."""

_THRESHOLDS = (0.3, 0.4, 0.5, 0.6)
"""Where ink begins, over the darkest there is."""

_MIDDLE = 0.4
"""The one that a first look takes."""

_HOPEFUL = 8
"""Blurs that are looked at again after it."""

_DARKEST = 99.5
_LEAST_INK = 0.003

_LEAST_PAPER, _LIGHT = 0.45, 0.25
"""Share of a picture of print that is paper: less than a quarter as dark as its ink. Clouds and rooms have
less, and dots of ink would make up those as well."""


@dataclass(frozen=True)
class EvenBlur:
    """A blur that is the same all over a picture."""

    family: str = "none"  # none, gaussian, disc or line
    size_px: float = 0.0
    angle_deg: float = 0.0  # of a line, from x downwards [deg]

    @property
    def transfer(self) -> Transfer:
        if self.family == "gaussian":
            return gaussian_transfer(self.size_px)
        if self.family == "disc":
            return disc_transfer(self.size_px)
        return line_transfer(self.size_px, self.angle_deg)  # of no length: none


@dataclass(frozen=True, eq=False)
class Print:
    """Two tones and the blur that made a picture of them."""

    blur: EvenBlur
    unexplained: float  # share of the picture's variance that the blurred print leaves
    ink: NDArray[np.float32]  # (H, W) share of each pixel that is ink


def with_print(capture: RealCapture) -> RealCapture | None:
    mean = capture.real_dn.mean(axis=0)
    black = np.float32(capture.context.black_level_dn)
    planes = [np.ascontiguousarray(mean[..., c] - black) for c in range(mean.shape[-1])]
    paper = [paper_level(plane) for plane in planes]
    green = len(planes) // 2
    found = find_print(darkness(planes[green], paper[green]))
    if found is None:
        return None
    inside = np.zeros(capture.valid.shape, bool)
    inside[BORDER_PX:-BORDER_PX, BORDER_PX:-BORDER_PX] = True
    expected = [_inked(plane, white, found, inside) for plane, white in zip(planes, paper, strict=True)]
    sharp = np.stack(expected, axis=-1)[None] + black
    return replace(capture, expected_dn=sharp, valid=capture.valid & inside, own_edges=True)


def paper_level(plane: NDArray[np.float32]) -> NDArray[np.float32]:
    """(H, W) how bright the paper is, under the ink as well [DN]."""
    quiet = cv2.blur(plane, (5, 5))
    highest = cv2.dilate(quiet, np.ones((PAPER_PX, PAPER_PX), np.uint8))
    return np.asarray(cv2.GaussianBlur(highest, (0, 0), PAPER_PX / 2), np.float32)


def darkness(plane: NDArray[np.float32], paper: NDArray[np.float32]) -> NDArray[np.float32]:
    """(H, W) what ink takes of the light of the paper, from 0 to 1."""
    return np.clip(1 - plane / np.maximum(paper, 1e-3), 0.0, 1.0).astype(np.float32)


def find_print(dark: NDArray[np.float32]) -> Print | None:
    """The print of which a picture has this darkness; None where two tones do not explain it."""
    if min(dark.shape) < 4 * BORDER_PX:
        return None
    inked = _with_most_ink(dark)
    ink = np.percentile(inked, 99)
    if ink <= 0 or np.mean(inked < _LIGHT * ink) < _LEAST_PAPER:
        return None
    part = _Spectrum.of(inked)
    glanced = {blur: part.fit(blur, (_MIDDLE,)) for blur in _coarse()}
    hopeful = sorted(glanced, key=lambda blur: glanced[blur])[:_HOPEFUL]
    tried = {blur: part.fit(blur, _THRESHOLDS) for blur in hopeful}
    for _ in range(2):
        best = min(tried, key=lambda blur: tried[blur])
        tried |= {blur: part.fit(blur, _THRESHOLDS) for blur in _around(best) if blur not in tried}
    best = min(tried, key=lambda blur: tried[blur])
    unexplained, threshold = tried[best]
    if unexplained > 1 - EXPLAINED:
        return None
    return Print(best, unexplained, _Spectrum.of(dark).ink(best, threshold))


def _coarse() -> Iterator[EvenBlur]:
    yield EvenBlur()
    yield from (EvenBlur("gaussian", float(sigma)) for sigma in np.geomspace(0.5, 8, 9))
    yield from (EvenBlur("disc", float(radius)) for radius in np.geomspace(1, 16, 9))
    for length in np.geomspace(4, 48, 8):
        yield from (EvenBlur("line", float(length), float(angle)) for angle in range(0, 180, 15))


def _around(blur: EvenBlur) -> Iterator[EvenBlur]:
    """Blurs of the same family, half a coarse step away and less."""
    angles = (-7.5, -4.0, 0.0, 4.0, 7.5) if blur.family == "line" else (0.0,)
    for step in (0.84, 0.92, 1.0, 1.09, 1.19):
        for turn in angles:
            yield replace(blur, size_px=blur.size_px * step, angle_deg=blur.angle_deg + turn)


@dataclass(frozen=True, eq=False)
class _Spectrum:
    """A picture of darkness that fades out to its borders, with its transform."""

    dark: NDArray[np.float32]
    transform: NDArray[np.complexfloating]
    shape: tuple[int, int]

    @classmethod
    def of(cls, dark: NDArray[np.float32]) -> _Spectrum:
        faded = (dark * _fade(dark.shape[0])[:, None] * _fade(dark.shape[1])).astype(np.float32)
        shape = (fft.next_fast_len(dark.shape[0], real=True), fft.next_fast_len(dark.shape[1], real=True))
        return cls(faded, fft.rfft2(faded, shape), shape)

    def fit(self, blur: EvenBlur, thresholds: Sequence[float]) -> tuple[float, float]:
        """Share of the variance that the best print leaves, blurred, and where ink begins in it."""
        sharp = self._undone(blur)
        return min((self._left(blur, _ink(sharp, threshold)), threshold) for threshold in thresholds)

    def ink(self, blur: EvenBlur, threshold: float) -> NDArray[np.float32]:
        """(H, W) share of each pixel that is ink, once a blur is undone."""
        return _ink(self._undone(blur), threshold)

    def blurred(self, blur: EvenBlur) -> NDArray[np.float32]:
        """(H, W) the picture with a blur."""
        return self._back(self.transform * self._transfer(blur))

    def _undone(self, blur: EvenBlur) -> NDArray[np.float32]:
        """(H, W) by Wiener's filter."""
        transfer = self._transfer(blur)
        return self._back(self.transform * transfer / (transfer**2 + np.float32(_NOISE_TO_SIGNAL)))

    def _left(self, blur: EvenBlur, ink: NDArray[np.float32]) -> float:
        if ink.mean() < _LEAST_INK:
            return math.inf
        blurred = self._back(fft.rfft2(ink, self.shape) * self._transfer(blur))[_INSIDE]
        return float(1 - np.corrcoef(blurred.ravel(), self.dark[_INSIDE].ravel())[0, 1] ** 2)

    def _transfer(self, blur: EvenBlur) -> NDArray[np.float32]:
        fy, fx = fft.fftfreq(self.shape[0])[:, None], fft.rfftfreq(self.shape[1])[None, :]
        return np.asarray(blur.transfer(fx, fy), np.float32)

    def _back(self, transform: NDArray[np.complexfloating]) -> NDArray[np.float32]:
        whole = fft.irfft2(transform, self.shape)
        return np.asarray(whole[: self.dark.shape[0], : self.dark.shape[1]], np.float32)


_INSIDE = (slice(BORDER_PX, -BORDER_PX), slice(BORDER_PX, -BORDER_PX))


def _ink(sharp: NDArray[np.float32], threshold: float) -> NDArray[np.float32]:
    """(H, W) share of each pixel that is darker than a threshold, by the slope there."""
    above = sharp - np.float32(threshold * np.percentile(sharp, _DARKEST))
    down, right = np.gradient(above)
    return np.asarray(np.clip(0.5 + above / np.maximum(np.hypot(down, right), 1e-6), 0.0, 1.0), np.float32)


def _fade(length: int) -> NDArray[np.float64]:
    """1 inside, falling to 0 over the border."""
    place = np.arange(length)
    return np.clip((np.minimum(place, place[::-1]) + 1) / BORDER_PX, 0.0, 1.0)


def _with_most_ink(dark: NDArray[np.float32]) -> NDArray[np.float32]:
    """The part of at most `LARGEST_PX` on a side with most ink in it."""
    height, width = (min(size, LARGEST_PX) for size in dark.shape)
    sums = cv2.integral(dark)
    of_parts = (
        sums[height:, width:] - sums[:-height, width:] - sums[height:, :-width] + sums[:-height, :-width]
    )
    top, left = np.unravel_index(int(np.argmax(of_parts)), of_parts.shape)
    return dark[top : top + height, left : left + width]


def _inked(
    plane: NDArray[np.float32], paper: NDArray[np.float32], found: Print, inside: NDArray[np.bool_]
) -> NDArray[np.float32]:
    """(H, W) paper and ink as bright as they are, without blur [DN]."""
    blurred = _Spectrum.of(found.ink).blurred(found.blur)[inside]
    terms = np.column_stack([np.ones(blurred.size), blurred])
    level, strength = np.linalg.lstsq(terms, darkness(plane, paper)[inside], rcond=None)[0]
    return np.asarray(paper * (1 - level - strength * found.ink), np.float32)
