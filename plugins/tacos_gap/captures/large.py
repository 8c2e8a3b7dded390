"""Captures of many pixels, or many captures: a part of each is kept and measured, where it shows most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.capture import RealCapture, Whole
from tacos_plugins.effects.row_waves import SHADING_DEGREE

KEPT_PIXELS = 1_000_000
"""Pixels of a frame of even light, of an edge, of a bracket that are kept in memory, for closed forms: a
variance is known to 0.2 % by them, and nine pictures of 12 megapixels take 1.3 GB as they are."""

_KEPT_IN_PART = ("dark", "flat", "edge", "bracket")

ENOUGH_PIXELS, LEAST_PIXELS = 500_000, 40_000
"""Pixels of a capture that are measured at most, and at least where there are so many: more tell little that
the first do not, and less than the second little at all. Repeated frames count, too."""

ENOUGH_SAMPLES = 1_200_000
"""Samples of all captures, colour by colour, that are measured: every trial of an effect simulates them all,
in a tenth of a microsecond of processor time each, and a search takes some hundred trials."""

NEARLY_ALL = 1.5
"""A part is measured of frames so many times as large as what is enough: less would save little."""

GRID_PX = 16
"""Parts begin and end with the blocks of codecs, and with whole cells of mosaics."""

DETAIL_PX = 32
"""Lines that a part with edges has at least: statistics of detail are taken in tiles of about as many."""

FLICKERS = 0.003
"""Scatter of a wall's rows about a smooth course, over their mean, that is a lamp's flicker."""

SMALL_PX = 640
"""Width of the picture that stays of a frame that is kept in part [px]."""

FEWEST_CAPTURES = 16
"""Captures that are searched over at least where there are so many, however many colours they have."""

Part = tuple[slice, slice]
"""Rows and columns."""


def searched_over(captures: Sequence[RealCapture]) -> list[RealCapture]:
    """The captures that a search simulates: of many of a kind some, at gains, times and levels spread out.

    All together they then hold `ENOUGH_SAMPLES`. What arithmetic tells takes a moment and is of all of them;
    boards are simulated by their corners alone, and all stay.
    """
    pictures = [capture for capture in captures if capture.kind != "board"]
    channels = max((capture.real_dn.shape[-1] for capture in pictures), default=1)
    room = max(FEWEST_CAPTURES, ENOUGH_SAMPLES // (LEAST_PIXELS * channels))
    by_kind: dict[str, list[RealCapture]] = {}
    for capture in pictures:
        by_kind.setdefault(capture.kind, []).append(capture)
    kept: set[str] = set()
    for place, of_kind in enumerate(sorted(by_kind.values(), key=len)):
        share = max(
            (room - len(kept)) // (len(by_kind) - place), 1
        )  # what small kinds leave, large ones have
        ordered = sorted(of_kind, key=_setting)
        spread = np.linspace(0, len(ordered) - 1, min(share, len(ordered))).round().astype(int)
        kept |= {ordered[k].id for k in spread}
    return [capture for capture in captures if capture.kind == "board" or capture.id in kept]


def _setting(capture: RealCapture) -> tuple[float, float, float]:
    """Gain, exposure time and level, by which captures of a kind are ordered."""
    context = capture.context
    return context.gain_db, context.exposure_s, float(capture.real_dn[0, ::8, ::8].mean())


def not_searched_over(captures: Sequence[RealCapture], searched: Sequence[RealCapture]) -> list[str]:
    """In a sentence, of how many captures causes are searched for in some; empty where in all."""
    if len(searched) == len(captures):
        return []
    return [
        f"Causes are searched for in {len(searched)} of the {len(captures)} captures, which are spread over "
        "their gains, exposure times and levels; what arithmetic tells is of all of them."
    ]


def enough_pixels(captures: Sequence[RealCapture]) -> int:
    """Pixels of each capture that are measured, so that all of them take no longer than `ENOUGH_SAMPLES`."""
    channels = sum(capture.real_dn.shape[-1] for capture in captures if capture.kind != "board")
    return int(np.clip(ENOUGH_SAMPLES // max(channels, 1), LEAST_PIXELS, ENOUGH_PIXELS))


def as_kept(capture: RealCapture) -> RealCapture:
    """A capture of no more pixels than are worth their memory, as it comes from its files.

    Of a large board, whose corners alone are used, the mean of frames and colours. Scenes, which tasks are
    scored on, and charts, which are still to be found, stay as they are.
    """
    height, width = capture.valid.shape
    if height * width <= NEARLY_ALL * KEPT_PIXELS:
        return capture
    if capture.kind == "board":
        grey = capture.real_dn.mean(axis=(0, -1), dtype=np.float32)
        return replace(capture, real_dn=grey[None, ..., None])
    if capture.kind not in _KEPT_IN_PART:
        return capture
    upright, shown = height > width, np.zeros(capture.valid.shape, np.float32)
    if capture.kind == "edge":  # which every line of its band crosses
        right, down = (np.abs(slope) for slope in _slopes(capture.real_dn[0]))
        upright, shown = bool(down.sum() > right.sum()), right + down
    elif capture.kind == "flat":
        upright |= _flickers(capture)
    cut = part_of(capture, _band(shown, KEPT_PIXELS, upright=upright))
    return replace(
        cut,
        real_dn=cut.real_dn.copy(),
        expected_dn=None if cut.expected_dn is None else cut.expected_dn.copy(),
        valid=cut.valid.copy(),
        whole=Whole(capture.geometry, _small(capture.real_dn[0])),
    )


def measured_part(capture: RealCapture, enough: int = ENOUGH_PIXELS) -> Part | None:
    """The part of a capture that is measured; None where that is all of it.

    A band along the longer side, so that what depends on the radius is seen as far out as that: through the
    middle, or where edges are of a capture that shows some; then the band is wide enough for them and, for
    that, may be short. Of a wall whose lamp flickers a band through all rows. Of a chart all of its patches.
    """
    height, width = capture.valid.shape
    frames = min(capture.frames, 2)  # two are kept, see `RealCapture.of_at_most`
    if height * width * frames <= NEARLY_ALL * enough or capture.expected_dn is None:
        return None
    if capture.patches is not None:
        return _around(capture.patches[0], height, width)
    upright = height > width or (capture.kind == "flat" and _flickers(capture))
    return _band(_shown(capture), enough // frames, upright=upright)


def part_of(capture: RealCapture, part: Part) -> RealCapture:
    """A part of a capture that nothing has moved yet, as if the sensor had been read out there alone."""
    rows, columns = part
    context = capture.context
    velocity = context.velocity_px_s
    boxes = capture.patches
    return replace(
        capture,
        real_dn=capture.real_dn[:, rows, columns],
        expected_dn=None if capture.expected_dn is None else capture.expected_dn[:, rows, columns],
        valid=capture.valid[part],
        geometry=capture.geometry.crop(
            x=columns.start,
            y=rows.start,
            width_px=columns.stop - columns.start,
            height_px=rows.stop - rows.start,
        ),
        context=replace(
            context,
            depth_m=None if context.depth_m is None else context.depth_m[..., rows, columns],
            velocity_px_s=(lambda: _cut(velocity(), part)) if callable(velocity) else _cut(velocity, part),
            reference_row=context.reference_row - rows.start,
        ),
        patches=boxes and (boxes[0] - np.array([columns.start, rows.start, 0, 0]), boxes[1]),
    )


def left_out(read: RealCapture, measured: RealCapture) -> str:
    """In a sentence, what of a capture's files was not measured; empty where all of it was."""
    whole, part = read.whole.geometry if read.whole else read.geometry, measured.geometry
    of, seen = (f"{each.width_px} x {each.height_px}" for each in (whole, part))
    if of == seen:
        return ""
    x, y = np.subtract(part.offset_px, whole.offset_px)
    return (
        f"{read.id}: of {of} pixels, {seen} are measured, from column {x} and row {y} on; what only the "
        "rest would tell is not seen."
    )


def _cut(velocity: Any, part: Part) -> Any:
    """A (H, W, 2) or (N, H, W, 2) field of velocities, cut; one velocity of all pixels stays."""
    return velocity if velocity is None or velocity.ndim == 1 else velocity[..., *part, :]


def _around(boxes: NDArray[np.int64], height: int, width: int) -> Part:
    """The rows and columns that hold boxes (P, 4), on the grid."""
    low = boxes[:, :2].min(axis=0) // GRID_PX * GRID_PX
    high = -(-(boxes[:, :2] + boxes[:, 2:]).max(axis=0) // GRID_PX) * GRID_PX
    return slice(int(low[1]), min(int(high[1]), height)), slice(int(low[0]), min(int(high[0]), width))


def _shown(capture: RealCapture) -> NDArray[np.float32]:
    """(H, W) what a capture shows at each pixel: edges of which something is expected."""
    if not capture.is_structured:
        return np.zeros(capture.valid.shape, np.float32)
    assert capture.expected_dn is not None
    return np.asarray(np.hypot(*_slopes(capture.expected_dn[0])) * capture.valid, np.float32)


def _flickers(capture: RealCapture) -> bool:
    """Whether rows of a wall scatter about a smooth course, in any frame, and columns do much less."""
    signal = capture.real_dn.mean(axis=-1) - np.float32(capture.context.black_level_dn)
    rows, columns = (max(map(_scatter, signal.mean(axis=axis))) for axis in (2, 1))
    return bool(rows > max(FLICKERS, 2 * columns))


def _scatter(profile: NDArray[np.float32]) -> float:
    """Standard deviation of a (L,) profile about a polynomial, over its mean."""
    place = np.linspace(-1, 1, len(profile))
    smooth = np.polynomial.Polynomial.fit(place, profile, SHADING_DEGREE)(place)
    return float(np.std(profile - smooth) / max(float(profile.mean()), 1.0))


def _slopes(image: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """(H, W) slopes of an image (H, W, C) to the right and down [DN/px], times 8."""
    level = np.ascontiguousarray(image.mean(axis=-1))
    right, down = cv2.Sobel(level, cv2.CV_32F, 1, 0), cv2.Sobel(level, cv2.CV_32F, 0, 1)
    return np.asarray(right, np.float32), np.asarray(down, np.float32)


def _small(frame: NDArray[np.float32]) -> NDArray[np.float32]:
    """(h, w, C) a frame made small, for a page."""
    height, width, channels = frame.shape
    size = SMALL_PX, max(1, round(height * SMALL_PX / width))
    small = np.asarray(cv2.resize(frame, size, interpolation=cv2.INTER_AREA), np.float32)
    return small.reshape(size[1], size[0], channels)


def _band(shown: NDArray[np.float32], enough: int, *, upright: bool) -> Part:
    """So many pixels of an (H, W) picture: lines of all its rows or columns where they show most.

    Where those are too few for detail, and there is some, as many as that takes, and shorter.
    """
    lying = shown.T if upright else shown
    length = lying.shape[1]
    size = max(GRID_PX, enough // length // GRID_PX * GRID_PX)
    if size < DETAIL_PX and shown.any():
        size, length = DETAIL_PX, max(GRID_PX, enough // DETAIL_PX // GRID_PX * GRID_PX)
    lines = _where_most_is_shown(lying.sum(axis=1, dtype=np.float64), size)
    along = _where_most_is_shown(lying[lines].sum(axis=0, dtype=np.float64), length)
    return (along, lines) if upright else (lines, along)


def _where_most_is_shown(profile: NDArray[np.float64], size: int) -> slice:
    """So many lines: on the grid, those nearest to the middle that show most."""
    starts = np.arange(0, max(len(profile) - size, 0) + 1, GRID_PX)
    sums = np.concatenate([[0.0], np.cumsum(profile)])
    inside = sums[np.minimum(starts + size, len(profile))] - sums[starts]
    most = np.flatnonzero(inside >= 0.999 * inside.max())
    middle = (len(profile) - size) / 2
    start = int(starts[most[np.argmin(np.abs(starts[most] - middle))]])
    return slice(start, min(start + size, len(profile)))
