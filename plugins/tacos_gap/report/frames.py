"""Pictures side by side: a real frame, the simulation before and after, and what is left between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera import srgb_from_linear
from tacos_framework.formation import EpisodeDraws, PlacedEffect
from tacos_gap.captures import RealCapture
from tacos_gap.report.image_map import DIVERGING
from tacos_gap.simulation.formation import simulate

CROP_PX = 56
"""Side of the part that is shown enlarged [px]."""

_WIDEST_PX = 640
_WORTH_A_LOOK = 2.0
"""Gap above which a second capture is shown [noise floor]."""

_TONE = "effect.tone-curve"

_KINDS = ("scene", "chart", "edge", "sequence", "bracket", "flat", "dark")


@dataclass(frozen=True, eq=False)
class ComparedFrames:
    capture: str
    kind: str
    whole: Sequence[NDArray[np.uint8]]  # (H, W, 3) uint8 each: real, before, after (or without the last)
    crops: Sequence[NDArray[np.uint8]]  # likewise, of the part that differs most, enlarged
    differences: Sequence[NDArray[np.uint8]]  # real less before and after, in blue and vermilion
    reach_dn: float  # the difference drawn in full colour [DN]
    stretched: bool
    rms_dn: Sequence[float]  # root mean square of what is drawn as differences, before and after [DN]
    noise_dn: float
    """The same of two simulations that differ in their noise alone: what a perfect one would leave [DN]."""


def to_show(
    captures: Sequence[RealCapture], gaps: Mapping[str, tuple[float, float]], most: int = 2
) -> list[RealCapture]:
    """The captures worth looking at: the richest kind, then the one that differs most of another kind."""
    drawable = [c for c in captures if c.expected_dn is not None and c.kind in _KINDS]
    by_kind = sorted(drawable, key=lambda c: (_KINDS.index(c.kind), -gaps.get(c.id, (0.0, 0.0))[0]))
    by_gap = sorted((c for c in drawable if c.id in gaps), key=lambda c: -gaps[c.id][0])
    chosen = by_kind[:1]
    chosen += [
        c for c in by_gap if c.kind not in {kept.kind for kept in chosen} and gaps[c.id][0] > _WORTH_A_LOOK
    ]
    return chosen[:most]


def compare(capture: RealCapture, effects: Sequence[PlacedEffect], seed: int) -> ComparedFrames:
    """Simulate a capture without and with the effects, and set its first real frame beside it."""
    draws = EpisodeDraws(seed, ("report", capture.id))
    stacks = [capture.real_dn, simulate(capture, (), draws)]
    if effects:
        stacks.append(simulate(capture, effects, draws))
    again = simulate(capture, effects, EpisodeDraws(seed, ("report", capture.id, "again")))
    means = [stack.mean(axis=0) for stack in stacks]
    smooth = [_difference(capture, means[0], mean) for mean in means[1:]]
    by_noise = _difference(capture, means[-1], again.mean(axis=0))
    reach_dn = max(float(np.percentile(np.abs(smooth[0]), 99)), 2.0)
    low, high, stretched = _range(capture)
    toned = _toned(capture, effects)
    whole = [_display(stack[0], low, high, own) for stack, own in zip(stacks, toned, strict=False)]
    part = _most_different(smooth[0])
    return ComparedFrames(
        capture.id,
        capture.kind,
        [_reduced(image) for image in whole],
        [np.ascontiguousarray(image[part]) for image in whole],
        [_reduced(_coloured(d, reach_dn)) for d in smooth],
        reach_dn,
        stretched,
        [_rms(capture, difference) for difference in smooth],
        _rms(capture, by_noise),
    )


def _difference(
    capture: RealCapture, first: NDArray[np.float32], second: NDArray[np.float32]
) -> NDArray[np.float32]:
    """(H, W) one mean frame less another, smoothed a little; 0 where nothing is expected [DN]."""
    return _smoothed(np.where(capture.valid[..., None], first - second, 0.0).mean(axis=-1))


def _rms(capture: RealCapture, difference: NDArray[np.float32]) -> float:
    return float(np.sqrt(np.mean(difference[capture.valid] ** 2))) if capture.valid.any() else 0.0


def _range(capture: RealCapture) -> tuple[float, float, bool]:
    """Values shown as black and white, and whether they are stretched apart."""
    low, high = np.percentile(capture.real_dn[0], (0.2, 99.8))
    context = capture.context
    black, white = float(context.black_level_dn), float(context.white_level_dn)
    if high - low < 0.35 * (white - black):
        margin = 0.1 * max(high - low, 4.0)
        return float(low - margin), float(high + margin), True
    return min(black, float(low)), float(high), False


def _toned(capture: RealCapture, effects: Sequence[PlacedEffect]) -> tuple[bool, bool, bool]:
    """For the real frame, the simulation before and that after: True with a tone curve of its own."""
    after = any(effect.use == _TONE for effect in effects)
    return capture.coding is not None or after, False, after


def _display(image: NDArray[np.float32], low: float, high: float, has_tone: bool) -> NDArray[np.uint8]:
    """(H, W, 3) as it is to be looked at: linear light through the curve of screens, others as they are."""
    share = np.clip((image - low) / (high - low), 0, 1)
    shown = np.rint(255 * (share if has_tone else srgb_from_linear(share))).astype(np.uint8)
    return np.repeat(shown, 3, axis=-1) if shown.shape[-1] == 1 else shown


def _smoothed(difference: NDArray[Any]) -> NDArray[np.float32]:
    import cv2

    return np.asarray(cv2.GaussianBlur(difference.astype(np.float32), (0, 0), 0.7))


def _coloured(difference: NDArray[np.float32], reach_dn: float) -> NDArray[np.uint8]:
    place = np.clip(0.5 + 0.5 * difference / reach_dn, 0, 1)
    return np.asarray(255 * DIVERGING(place)[..., :3]).astype(np.uint8)


def _most_different(difference: NDArray[np.float32]) -> tuple[slice, slice]:
    import cv2

    height, width = difference.shape
    side = min(CROP_PX, height, width)
    energy = cv2.boxFilter(difference**2, -1, (side, side), borderType=cv2.BORDER_CONSTANT)
    half = side // 2
    inside = energy[half : height - half + 1 : 4, half : width - half + 1 : 4]
    row, column = np.unravel_index(int(np.argmax(inside)), inside.shape)
    top = min(4 * int(row), height - side)
    left = min(4 * int(column), width - side)
    return slice(top, top + side), slice(left, left + side)


def _reduced(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    import cv2

    height, width = image.shape[:2]
    if width <= _WIDEST_PX:
        return image
    size = _WIDEST_PX, max(1, round(height * _WIDEST_PX / width))
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA))
