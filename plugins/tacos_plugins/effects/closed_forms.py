"""Closed forms on even fields: pedestal, rows, patterns, fall-off and whiteness of the noise.

Each is measured in parts of the picture, or of the captures, that know nothing of each other; their scatter
is the standard error.

Source: EMVA 1288, release 4.0; Janesick 2007, "Photon Transfer".
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tacos_framework import SURE, Captures, ObservedCapture, of_kind
from tacos_plugins.effects.darks import pedestal_dn

PARTS = (4, 6)
"""Rows and columns of parts that a picture is cut into."""

WHITE = 0.006
"""Correlation of neighbours' noise below which it is independent."""

CUT_OFF = 0.01
"""Share of pixels at 0 from which on a dark hides what lies below."""

_FULL = 0.9  # of full scale: brighter walls begin to clip
_LEAST_SIGNAL_DN = 10.0
_FEWEST_PX = 40  # side of a picture that can be cut into parts
_DEFECT = 7.5  # step between columns over the median one from which on one is defect: 5 standard deviations
_WINDOW_PX = 7
_LARGEST_PX = 1024
_SHADING_TILES = (18, 24)


class Measured(NamedTuple):
    """A number and its standard error, in its unit."""

    value: float
    standard_error: float


def mean_of_groups(groups: Sequence[Sequence[float]]) -> Measured | None:
    """Mean of all measurements; the groups' scatter is its error, where it is more than that of all."""
    found = mean_of([value for group in groups for value in group])
    means = mean_of([float(np.mean(group)) for group in groups])
    if found is None or means is None:
        return found
    return found._replace(standard_error=max(found.standard_error, means.standard_error))


def mean_of(values: Sequence[float]) -> Measured | None:
    """Mean of independent measurements; None of fewer than two."""
    if len(values) < 2:
        return None
    return Measured(float(np.mean(values)), float(np.std(values, ddof=1)) / len(values) ** 0.5)


def root(of: Measured) -> Measured:
    """A standard deviation, from a variance that may come out below 0 where there is none."""
    value = max(of.value, 0.0) ** 0.5
    return Measured(value, (value**2 + of.standard_error) ** 0.5 - value)


def whole_darks(captures: Captures) -> list[ObservedCapture]:
    """Darks whose noise is seen on either side of their level, by exposure time."""
    seen = [each for each in of_kind(captures, "dark") if _is_large(each)]
    darks = [each for each in seen if np.mean(each.real_dn <= 0) < CUT_OFF]
    return sorted(darks, key=lambda each: each.context.exposure_s)


def whole_walls(captures: Captures, frames: int = 1) -> list[ObservedCapture]:
    """Flats that are lit and do not clip, of so many frames at least."""
    return [
        each
        for each in of_kind(captures, "flat")
        if each.frames >= frames and _is_large(each) and _is_between(each)
    ]


def pedestal_off_dn(captures: Captures) -> Measured | None:
    """Height of the dark at no exposure above the believed pedestal [DN]."""
    darks = whole_darks(captures)
    if not darks:
        return None
    first, last = map(_levels_of_parts, (darks[0], darks[-1]))
    return mean_of([pedestal_dn(*part) for part in zip(first, last, strict=True)])


def _levels_of_parts(dark: ObservedCapture) -> list[tuple[float, float]]:
    """Exposure time [s], and height of each part above the believed pedestal [DN]."""
    off = dark.real_dn - dark.context.black_level_dn
    return [(dark.context.exposure_s, float(part.mean())) for part in _parts(off)]


def line_variance_dn2(captures: Captures, axis: int) -> Measured | None:
    """Variance of offsets that all pixels of a row (axis 1) or column (0) share in one frame [DN^2]."""
    found = []
    for dark in whole_darks(captures):
        frames = _middle(dark.real_dn)
        for one, other in pairwise(frames):
            for part in _parts(((one - other) / np.sqrt(2))[None]):
                lines = part[0].mean(axis=(axis, 2))
                independent = float(part.var()) / (part.size / len(lines))
                found.append(float(np.mean(np.diff(lines) ** 2)) / 2 - independent)
    return mean_of(found)


def pattern_variance(captures: Sequence[ObservedCapture], *, relative: bool) -> Measured | None:
    """Variance of what repeats from frame to frame between neighbouring pixels [DN^2, or 1 if `relative`].

    Covariance of the halves of the frames, beside their local mean: noise that is new in every frame cancels.
    """
    found = []
    for capture in captures:
        if capture.frames < 2 or capture.context.cfa is not None:
            continue
        frames = _middle(capture.real_dn)
        halves = [_fine(frames[half::2].mean(axis=0)) for half in (0, 1)]
        signal = _smooth(frames.mean(axis=0)) - capture.context.black_level_dn if relative else 1.0
        product = halves[0] * halves[1] / np.maximum(signal, _LEAST_SIGNAL_DN if relative else 1.0) ** 2
        found += [float(np.clip(part, *_within(part)).mean()) for part in _parts(product[None])]
    return mean_of(found)


def column_pattern_variance_dn2(captures: Sequence[ObservedCapture]) -> Measured | None:
    """Variance of offsets of columns that repeat from frame to frame, but for defect ones [DN^2]."""
    found = []
    for capture in captures:
        if capture.frames < 2 or capture.context.cfa is not None:
            continue
        frames = _middle(capture.real_dn)
        columns = [frames[half::2].mean(axis=(0, 1, 3), dtype=np.float64) for half in (0, 1)]
        one, other = map(np.diff, columns)
        steps = np.abs(one + other)
        usual = steps <= _DEFECT * max(float(np.median(steps)), 1e-9)
        parts = np.array_split((one * other / 2)[usual], PARTS[1])
        found += [float(part.mean()) for part in parts if part.size]
    return mean_of(found)


class Shading(NamedTuple):
    """Light of walls over what is expected, ``(1 + k1 r^2 + k2 r^4) (1 + gx x + gy y)``."""

    k1: Measured
    k2: Measured
    gx: Measured
    gy: Measured


def shading(captures: Captures) -> Shading | None:
    """The fall-off and the plane that fit walls best, least squares over tiles of each."""
    import cv2

    rows, deviations = [], []
    for wall in whole_walls(captures):
        assert wall.expected_dn is not None
        black, (h, w) = wall.context.black_level_dn, _SHADING_TILES
        light = (wall.real_dn.mean(axis=0) - black).mean(axis=-1)
        ratio = light / (wall.expected_dn.mean(axis=0) - black).mean(axis=-1)
        g = wall.geometry
        x = (np.arange(g.width_px) + g.offset_px[0] + 0.5) / g.full_width_px - 0.5
        y = (g.sensor_row + 0.5) / g.full_height_px - 0.5
        r2 = g.radius**2
        columns = [np.ones_like(r2), r2, r2**2, *(p.astype(float) for p in np.broadcast_arrays(x, y))]
        tiles = [cv2.resize(each, (w, h), interpolation=cv2.INTER_AREA).ravel() for each in (*columns, ratio)]
        terms = np.stack(tiles[:-1], axis=1)
        found, *_ = np.linalg.lstsq(terms, tiles[-1], rcond=None)
        left = tiles[-1] - terms @ found
        covariance = np.linalg.inv(terms.T @ terms) * float(left @ left) / (len(left) - len(found))
        rows.append(found[1:] / found[0])
        deviations.append(np.sqrt(np.diag(covariance))[1:] / abs(found[0]))
    if not rows:
        return None
    values, own = np.mean(rows, axis=0), np.sqrt(np.mean(np.square(deviations), axis=0) / len(rows))
    apart = np.std(rows, axis=0, ddof=1) / len(rows) ** 0.5 if len(rows) > 1 else np.zeros(4)
    return Shading(*(Measured(float(v), float(e)) for v, e in zip(values, np.hypot(own, apart), strict=True)))


def neighbour_correlation(captures: Captures, *, diagonal: bool = False) -> Measured | None:
    """Correlation of the noise of neighbours beside each other in walls, or at a corner [1].

    Lines share offsets, by rows that jump and lamps that flicker, and are brought to one mean. That costs
    neighbours in a line of n pixels 1/n of their correlation, which is given back. What crosstalk correlates,
    walls show alike; where they do not, software smooths faint noise more.
    """
    found = []
    for wall in whole_walls(captures, frames=2):
        if wall.context.cfa is None:
            difference = np.subtract(*_middle(wall.real_dn[:2]))
            for axis in (1, 0):
                difference = difference - difference.mean(axis=axis, keepdims=True)
            lost = 0.0 if diagonal else (1 / difference.shape[0] + 1 / difference.shape[1]) / 2
            parts = _parts(difference[None])
            found.append([_correlation(part - part.mean(), diagonal) + lost for part in parts])
    return mean_of_groups(found)


def is_white(captures: Captures) -> bool:
    """True if the noise of neighbours is surely independent, as nothing leaves it that averages pixels."""
    found = neighbour_correlation(captures)
    return found is not None and abs(found.value) + SURE * found.standard_error < WHITE


def _correlation(noise: NDArray[np.floating], diagonal: bool) -> float:
    if diagonal:
        pairs = (noise[:, 1:, 1:], noise[:, :-1, :-1]), (noise[:, 1:, :-1], noise[:, :-1, 1:])
    else:
        pairs = (noise[:, :, 1:], noise[:, :, :-1]), (noise[:, 1:], noise[:, :-1])
    covariance = np.mean([float(np.mean(one * other)) for one, other in pairs])
    return float(covariance / max(float(np.mean(noise**2)), 1e-6))


def _is_large(capture: ObservedCapture) -> bool:
    return min(capture.valid.shape) >= _FEWEST_PX and bool(capture.valid.all())


def _is_between(capture: ObservedCapture) -> bool:
    context = capture.context
    signal = capture.real_dn.mean(axis=0) - context.black_level_dn
    span = context.white_level_dn - context.black_level_dn
    return (
        capture.expected_dn is not None
        and bool(np.percentile(signal, 1) > _LEAST_SIGNAL_DN)
        and bool(np.percentile(signal, 99) < _FULL * span)
    )


def _middle(frames: NDArray[np.floating]) -> NDArray[np.floating]:
    """The middle of (N, H, W, C) frames: what holds everywhere alike, a megapixel tells."""
    first = [max(side - _LARGEST_PX, 0) // 2 for side in frames.shape[1:3]]
    rows, columns = (slice(start, start + _LARGEST_PX) for start in first)
    return frames[:, rows, columns]


def _parts(frames: NDArray[np.floating]) -> Iterator[NDArray[np.floating]]:
    for rows in np.array_split(frames, PARTS[0], axis=1):
        yield from np.array_split(rows, PARTS[1], axis=2)


def _smooth(image: NDArray[np.floating]) -> NDArray[np.floating]:
    import cv2

    return np.asarray(cv2.blur(image, (_WINDOW_PX, _WINDOW_PX)), image.dtype).reshape(image.shape)


def _fine(image: NDArray[np.floating]) -> NDArray[np.floating]:
    """(H, W, C) an image beside its local mean, scaled so that white patterns keep their variance."""
    return np.asarray((image - _smooth(image)) / np.sqrt(1 - 1 / _WINDOW_PX**2))


def _within(values: NDArray[np.floating]) -> tuple[float, float]:
    """Bounds beyond which products are those of hot pixels and dust."""
    reach = 12 * float(np.std(np.clip(values, *np.percentile(values, (0.5, 99.5))))) + 1e-12
    return -reach, reach
