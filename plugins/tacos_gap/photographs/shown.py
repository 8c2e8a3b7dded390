"""Kind of a photograph: a cap, a wall, a board, a chart, an edge, or a scene."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.targets.chart import find_chart
from tacos_gap.captures.targets.chart_pixels import in_colour
from tacos_gap.captures.targets.slanted_edge import find_edge
from tacos_gap.captures.targets.two_tone import darkness, find_print, paper_level
from tacos_gap.captures.targets.wall import shading
from tacos_gap.photographs.board_lattice import size_of_board
from tacos_gap.photographs.charuco import Markers, find_markers

DARK_SHARE = 0.1
"""Level over full scale below which a picture without structure shows the cap: pedestals lie at 6 %."""

_STEADY = 0.04
"""Difference over the level up to which two pictures show the same: lamps waver by one to two percent."""

_FEWEST_CORNERS = 20
"""Corners below which text and tiles are taken for chessboards too often."""

THUMBNAIL = (48, 64)
COARSE = (6, 8)
"""Parts by which even pictures are compared: each averages 6,400 pixels of 640 x 480."""

_LIT_ALIKE = 0.003
"""Spread of the ratio of two walls' shading from side to side up to which light and camera were left alone:
that of a tilt by 1 %. Repeated frames of 480 x 360 pixels stay below 0.001, a wall turned under a lamp that
falls off by 1.5 % has 0.005."""

_CLIPPED = 0.95
"""Share of full scale from which on a part of a wall says nothing of its shading."""

_POWERS = (0.3, 3.0)
"""Local powers of tone curves, one over the other."""

_PLATEAU, _LEAST_TOLD = 0.3, 0.03
"""Share of a picture at its brightest from which on that is where light is cut off, and the least share that
must be left of it to compare framings by."""

_WORKING_PX = 1000
_EVEN = 0.04
"""Departure from smooth shading, over the level, up to which a picture shows an even surface."""

_MOST_BAD_LINES = 0.1
"""Share of a picture's columns from which on those that stand out are its pattern, not its defects."""

_SIDES = 0.85
"""Share of pixels close to one of two levels from which on a picture shows sharp edges of a print."""


@dataclass(frozen=True, eq=False)
class Shown:
    """Content of a picture."""

    kind: str  # dark, flat, board, chart, edge or scene
    thumbnail: NDArray[np.float32]  # small picture of even mean and spread, by which framings are compared
    level: float  # middle value over full scale
    sharpness: float  # energy of the finest detail over that of the picture: falls when the focus moves
    corners: tuple[int, int] | None = None
    """Inner corners (columns, rows) that were counted on a chessboard; fewer where it is cut off."""
    markers: Markers | None = None  # those of a ChArUco board
    doubt: str = ""  # what is uncertain of it, to stand behind its name; empty if nothing is


def shown_in(image: NDArray[np.floating], black_dn: float, white_dn: float, cfa: str | None = None) -> Shown:
    """Look at a picture.

    `image`: (H, W, C) file values; a mosaic is looked at by its means of two by two [DN].
    """
    above = np.maximum(np.asarray(image, np.float32) - np.float32(black_dn), 0)
    signal = above / np.float32(white_dn - black_dn)
    grey = _reduced(signal.mean(axis=-1))
    thumbnail = _thumbnail(grey)
    level = float(np.median(grey))
    seen = Shown("scene", thumbnail, level, _sharpness(grey))
    if _is_dark(grey):
        return replace(seen, kind="dark")
    noise = _noise_left(grey) / max(level, 1e-6) if level < DARK_SHARE else 0.0
    if (unevenness := _unevenness(grey)) < _EVEN + noise:
        doubt = "half of it is clipped." if np.mean(signal >= 0.99) > 0.5 else ""
        return replace(seen, kind="flat", doubt=doubt)
    eight = _eight_bit(grey)
    if (corners := _board(eight)) is not None:
        return replace(seen, kind="board", corners=corners)
    if (markers := find_markers(eight)) is not None:
        return replace(seen, kind="board", markers=markers)
    if (colours := in_colour(signal, cfa)) is not None and find_chart(colours) is not None:
        return replace(seen, kind="chart")
    if find_edge(grey) is not None:
        return replace(seen, kind="edge")
    if _two_levels(grey):
        return replace(seen, kind="edge", doubt="taken for sharp edges of a print.")
    if find_print(darkness(grey, paper_level(grey))) is not None:
        return replace(seen, kind="edge", doubt="taken for print, blurred.")
    doubt = "taken for a scene; it may be a wall with marks on it." if unevenness < 2 * _EVEN else ""
    return replace(seen, doubt=doubt)


def repeated(first: Shown, second: Shown) -> bool:
    """True if two pictures differ by their noise alone: same view, same light, same focus."""
    even = first.kind == second.kind and first.kind in ("dark", "flat")
    a, b = (_coarse(each.thumbnail) if even else each.thumbnail for each in (first, second))
    apart = _but_for_waves(a - b) if first.kind == "flat" else a - b
    steady = _STEADY * max(float(a.mean()), DARK_SHARE)
    if np.percentile(np.abs(apart), 95) >= max(steady, 2.3 * _noise(apart)):
        return False
    if even:
        return first.kind == "dark" or same_shading(first, second)
    return 0.85 < (first.sharpness + 1e-9) / (second.sharpness + 1e-9) < 1 / 0.85


def _but_for_waves(apart: NDArray[np.float32]) -> NDArray[np.float32]:
    """A difference of two pictures without what rows differ by, but for a line along them.

    A lamp that flickers meets the rows of each picture at another phase; one that was moved leaves a slope.
    """
    rows = apart.mean(axis=1)
    place = np.arange(len(rows))
    line = np.polynomial.Polynomial.fit(place, rows, 1)(place).astype(np.float32)
    return apart - (rows - line)[:, None]


def same_shading(first: Shown, second: Shown, *, through_a_curve: bool = False) -> bool:
    """True if two walls are shaded alike from side to side, so that neither lamp nor camera were turned.

    What differs from row to row alone is left to the lamp: it flickers while rows are read out.

    `through_a_curve`: true if their levels differ, so that a tone curve or a pedestal gives their shading
    other powers.
    """
    a, b = first.thumbnail, second.thumbnail
    seen = (np.maximum(a, b) < _CLIPPED).all(axis=0)
    if seen.mean() < 0.5:
        return True
    profiles = [np.log(np.maximum(each.mean(axis=0)[seen], 1e-6)) for each in (a, b)]
    across_a, across_b = (profile - profile.mean() for profile in profiles)
    power = 1.0
    if through_a_curve:
        power = float(np.clip(across_a @ across_b / max(across_b @ across_b, 1e-12), *_POWERS))
    apart = across_a - power * across_b
    parts = apart[: len(apart) // COARSE[1] * COARSE[1]].reshape(COARSE[1], -1)
    noise = float(parts.std(axis=1).mean()) / math.sqrt(parts.shape[1])
    return float(parts.mean(axis=1).std()) < max(_LIT_ALIKE, 3 * noise)


def same_framing(first: Shown, second: Shown) -> bool:
    """True if two pictures show the same view, however bright: their ranks agree, and nothing has moved."""
    dim = min(first.level, second.level) < DARK_SHARE
    a, b = (_averaged(each.thumbnail) if dim else each.thumbnail for each in (first, second))
    told = _below_a_plateau(a) & _below_a_plateau(b)
    if told.mean() < _LEAST_TOLD:
        return False
    return float(np.corrcoef(_ranks(a[told]), _ranks(b[told]))[0, 1]) > 0.9


def _below_a_plateau(thumbnail: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Parts that are not cut off at the top, where many are, wherever that is: they have no order."""
    top = thumbnail >= 0.98 * float(thumbnail.max())
    return ~top if top.mean() > _PLATEAU else np.ones(thumbnail.shape, bool)


def _reduced(grey: NDArray[np.float32]) -> NDArray[np.float32]:
    """At half size or less, so that mosaics show no lattice."""
    scale = min(0.5 if min(grey.shape) > 200 else 1.0, _WORKING_PX / max(grey.shape))
    if scale == 1.0:
        return grey
    return np.asarray(cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA))


def _thumbnail(grey: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.asarray(cv2.resize(grey, THUMBNAIL[::-1], interpolation=cv2.INTER_AREA))


def _coarse(thumbnail: NDArray[np.float32]) -> NDArray[np.float32]:
    """A thumbnail of an even picture, which shows all there is but noise in a few large parts."""
    return np.asarray(cv2.resize(thumbnail, COARSE[::-1], interpolation=cv2.INTER_AREA))


def _averaged(thumbnail: NDArray[np.float32]) -> NDArray[np.float32]:
    """A thumbnail at a quarter of its size: what remains of a view in the noise of too little light."""
    return np.asarray(cv2.resize(thumbnail, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA))


def _ranks(thumbnail: NDArray[np.float32]) -> NDArray[np.float64]:
    order = np.empty(thumbnail.size)
    order[np.argsort(thumbnail, axis=None, kind="stable")] = np.arange(thumbnail.size)
    return order


def _is_dark(grey: NDArray[np.float32]) -> bool:
    """Near the bottom everywhere but for hot pixels, and without anything to be seen."""
    broad = cv2.medianBlur(np.ascontiguousarray(grey), 5)
    return bool(np.percentile(broad, 99.5) < DARK_SHARE and np.ptp(cv2.blur(broad, (15, 15))) < 0.02)


def _unevenness(grey: NDArray[np.float32]) -> float:
    """Departure of a picture, over the level, from the smooth shading that lens and lamp give a wall."""
    grey = _without_bad_lines(_without_bad_lines(grey).T).T
    fine = cv2.GaussianBlur(grey, (0, 0), 2.0)
    smooth = shading(np.ascontiguousarray(grey))
    lit = smooth > 0.1 * float(np.percentile(smooth, 99))
    departure = np.abs(fine - smooth)[lit] / smooth[lit]
    return float(np.percentile(departure, 99)) + 1 - float(lit.mean())


def _without_bad_lines(grey: NDArray[np.float32]) -> NDArray[np.float32]:
    """The picture with columns that depart from their neighbours over its whole height taken from these.

    Those are of the sensor: no edge or line of a view keeps to one column of pixels.
    """
    profile = np.median(grey, axis=0)
    beside = cv2.medianBlur(np.ascontiguousarray(profile[np.newaxis]), 5)[0]
    good = np.flatnonzero(np.abs(profile - beside) <= _EVEN * beside)
    if len(good) < (1 - _MOST_BAD_LINES) * len(profile):
        return grey
    nearest = good[np.abs(np.arange(len(profile))[:, np.newaxis] - good).argmin(axis=1)]
    return grey[:, nearest]


def _noise_left(grey: NDArray[np.float32]) -> float:
    """Departure left by noise, of which `_unevenness` takes the 99th percentile."""
    return 2.6 * _noise(grey) / (2 * math.sqrt(math.pi) * 2.0)


def _noise(image: NDArray[np.float32]) -> float:
    """Standard deviation of the noise in an image, its structure left out (Immerkaer 1996)."""
    kernel = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32) / 6
    return 1.4826 * float(np.median(np.abs(cv2.filter2D(image, cv2.CV_32F, kernel))))


def _sharpness(grey: NDArray[np.float32]) -> float:
    fine = cv2.Laplacian(cv2.GaussianBlur(grey, (0, 0), 1.0), cv2.CV_32F)
    return float(fine.var() / max(float(grey.var()), 1e-9))


def _eight_bit(grey: NDArray[np.float32]) -> NDArray[np.uint8]:
    low, high = np.percentile(grey, (0.5, 99.5))
    return np.asarray(np.clip((grey - low) * (255 / max(high - low, 1e-6)), 0, 255), np.uint8)


def _board(eight: NDArray[np.uint8]) -> tuple[int, int] | None:
    """Inner corners of a chessboard of any size, the longer side first (Duda and Frese 2018)."""
    found, corners, layout = cv2.findChessboardCornersSBWithMeta(eight, (3, 3), cv2.CALIB_CB_LARGER)
    if not found or len(corners) < _FEWEST_CORNERS:
        return None
    rows, columns = layout.shape[:2]
    counted = size_of_board(eight, np.asarray(corners, np.float64).reshape(rows, columns, 2))
    return counted or (max(rows, columns), min(rows, columns))


def _two_levels(grey: NDArray[np.float32]) -> bool:
    _, binary = cv2.threshold(_eight_bit(grey), 0, 1, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    bright = binary.astype(bool)
    if not 0.1 < bright.mean() < 0.9:
        return False
    sides = [float(np.median(grey[side])) for side in (bright, ~bright)]
    contrast = sides[0] - sides[1]
    near = np.minimum(np.abs(grey - sides[0]), np.abs(grey - sides[1])) < 0.15 * contrast
    return bool(contrast > 0.2 * sides[0] and near.mean() > _SIDES)
