"""Doubts about captures, though nothing is for certain: sentences that say what to do."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import reduce
from itertools import pairwise
from operator import or_

import numpy as np

from tacos_files.camera_images import LOSSY_SUFFIXES
from tacos_gap.captures.alignment import FEWEST_UNUSED, low_bits_unused, shifted_left, used_bits
from tacos_gap.captures.capture import RealCapture
from tacos_gap.captures.noise_estimate import thinned
from tacos_gap.captures.plausibility import exposure_groups

CONTRADICTION = 1.5
"""Ratio of levels over that of exposure times, or the reverse, beyond which one of them is doubted."""

_DIM_DN = 8.0
_FEWEST_LIT = 20
"""Samples that both pictures of a bracket must show for their ratio to count."""

_PILE = 0.01
"""Share of pixels at the largest values that makes them the end of the codes in use."""

_BLUR_PX = 0.5
"""Path during an exposure from which on it blurs what is sharp."""

_BELOW_FULL_SCALE = 0.98
_OPPOSITE = -0.5
"""Correlation between real and expected red less blue below which the two are taken to be swapped."""


def doubts(captures: Sequence[RealCapture]) -> Iterator[str]:
    """Doubts about captures, each in a sentence that begins with what it is about."""
    for capture in captures:
        yield from _of_frames(capture)
        yield from _of_zeros(capture)
        yield from _of_colours(capture)
        yield from _of_motion(capture)
    yield from _of_darks(captures)
    yield from _of_full_scale(captures)
    yield from _of_alignment(captures)
    yield from _of_orientation(captures)
    yield from _of_exposures(captures)


def doubt_of_files(name: str, suffixes: Sequence[str]) -> Iterator[str]:
    if lossy := sorted(LOSSY_SUFFIXES & {suffix.lower() for suffix in suffixes}):
        yield (
            f"{name}: its files are lossy ({', '.join(lossy)}), so that noise and detail are as much "
            f"the codec's as the camera's; take PNG, TIFF or RAW if the camera has them."
        )


def _of_frames(capture: RealCapture) -> Iterator[str]:
    """Sentence on frames of one still that differ as pictures of two things do; what moves is a sequence."""
    told_apart = capture.expected_dn is not None and len(capture.expected_dn) > 1
    if capture.kind in ("board", "sequence") or capture.frames < 2 or told_apart:
        return
    black_dn = capture.context.black_level_dn
    levels = [float(np.median(thinned(frame))) - black_dn for frame in capture.real_dn]
    dimmest, brightest = int(np.argmin(levels)), int(np.argmax(levels))
    if levels[brightest] > CONTRADICTION * max(levels[dimmest], _DIM_DN):
        yield (
            f"{capture.id}: frame {brightest + 1} is brighter ({levels[brightest]:.3g} DN above the black "
            f"level) than frame {dimmest + 1} ({levels[dimmest]:.3g} DN); make sure that they are of one "
            f"thing and of one light, and that exposure was not automatic."
        )


def _of_zeros(capture: RealCapture) -> Iterator[str]:
    if capture.kind == "dark" and not capture.real_dn.any():
        yield (
            f"{capture.id}: every pixel is 0, so that noise below the pedestal is cut off and none is seen; "
            f"raise the camera's black level if it can be set, or take a longer exposure."
        )


def _of_colours(capture: RealCapture) -> Iterator[str]:
    real = capture.real_dn
    if real.shape[-1] != 3 or not np.ptp(real):
        return
    if np.array_equal(real[..., 0], real[..., 1]) and np.array_equal(real[..., 1], real[..., 2]):
        yield (
            f"{capture.id}: its three channels are the same, as of a mono image stored as colour; set "
            f"camera.channels to 1."
        )
    elif capture.expected_dn is not None and capture.kind != "dark":
        seen, expected = (
            (image[..., 0] - image[..., 2])[capture.valid]
            for image in (real.mean(axis=0), capture.expected_dn.mean(axis=0))
        )
        if min(np.ptp(seen), np.ptp(expected)) > _DIM_DN:
            with np.errstate(invalid="ignore"):
                along = float(np.corrcoef(seen, expected)[0, 1])
            if along < _OPPOSITE:
                yield (
                    f"{capture.id}: red is bright where blue is expected to be; make sure that files and "
                    f"`simulated` both hold red, green, blue in this order."
                )


def _of_motion(capture: RealCapture) -> Iterator[str]:
    velocity = capture.context.velocity_px_s
    if not isinstance(velocity, np.ndarray) or not capture.exposure_stated or capture.expected_dn is None:
        return
    path_px = float(np.median(np.linalg.norm(velocity, axis=-1))) * capture.context.exposure_s
    if path_px < _BLUR_PX:
        return
    yield f"{capture.id}: by velocity_px_s and exposure_ms the picture moves by {path_px:.2g} px while " + (
        "the shutter is open, and `simulated` holds that blur (motion_blurred): effect.motion-blur is what "
        "is there beyond it."
        if capture.motion_blurred
        else "the shutter is open, and `simulated` is sharp: effect.motion-blur is to be expected. If "
        "`simulated` does hold that blur, say motion_blurred: true."
    )


def _of_darks(captures: Sequence[RealCapture]) -> Iterator[str]:
    """Darks brighter than walls that had as much time: kinds that were mixed up, or a cap left off."""
    darks = [capture for capture in captures if capture.kind == "dark"]
    walls = [(_middle(c), c) for c in captures if darks and c.kind == "flat" and c.exposure_stated]
    for dark in darks:
        level = _middle(dark)
        context = dark.context
        dimmer = [
            (below, wall.id)
            for below, wall in walls
            if below < level - _DIM_DN
            and wall.context.gain_db == context.gain_db
            and wall.context.exposure_s >= context.exposure_s
        ]
        if dimmer:
            below, wall = min(dimmer)
            yield (
                f"{dark.id}: it is a dark, and brighter ({level:g} DN) than the flat {wall} ({below:g} DN), "
                f"which had no less time; make sure that kinds are not mixed up, and that the cap was on."
            )


def _of_full_scale(captures: Sequence[RealCapture]) -> Iterator[str]:
    lit = [capture for capture in captures if capture.kind != "dark"]
    if not lit:
        return
    white = lit[0].context.white_level_dn
    brightest = max(lit, key=lambda capture: float(capture.real_dn.max()))
    top = float(brightest.real_dn.max())
    at_top = (brightest.real_dn >= top - 1).any(axis=0) & brightest.valid[..., None]
    expected = brightest.expected_dn
    brighter = (
        expected is not None and at_top.any() and np.median(expected[:, at_top]) > top / _BELOW_FULL_SCALE
    )
    if at_top.mean() > _PILE and brighter and top < _BELOW_FULL_SCALE * white:
        yield (
            f"{brightest.id}: its pixels pile up at {top:g} DN, where more light is expected, below the "
            f"believed full scale of {white:g}; check camera.bit_depth and white_level_dn. If they are "
            f"right, the sensor saturates there."
        )


def _of_alignment(captures: Sequence[RealCapture]) -> Iterator[str]:
    if not captures or (bits := int(captures[0].context.white_level_dn).bit_length()) <= 8:
        return
    unused = low_bits_unused(reduce(or_, (used_bits(thinned(capture.real_dn[:1])) for capture in captures)))
    if unused >= FEWEST_UNUSED and bits - unused >= 8:
        yield f"camera: {shifted_left(bits - unused, unused)}"


def _of_orientation(captures: Sequence[RealCapture]) -> Iterator[str]:
    if captures and all(c.geometry.full_height_px > c.geometry.full_width_px for c in captures):
        yield (
            "camera: all files are higher than wide; make sure that nothing turned them, as rows must be "
            "those that the sensor reads out."
        )


def _of_exposures(captures: Sequence[RealCapture]) -> Iterator[str]:
    for members in exposure_groups(captures).values():
        series = sorted(members, key=lambda capture: capture.context.exposure_s)
        for a, b in pairwise(series):
            times = b.context.exposure_s / a.context.exposure_s
            if times == 1 or (as_bright := _times_as_bright(a, b)) is None:
                continue
            if not 1 / CONTRADICTION < as_bright / times < CONTRADICTION:
                yield (
                    f"{b.id}: it is {as_bright:.3g} times as bright as {a.id} at {times:.3g} times its "
                    f"exposure; check the exposure times, and that exposure, gain and tone were "
                    f"not automatic."
                )


def _middle(capture: RealCapture) -> float:
    """Middle value of the files [DN]."""
    return float(np.median(thinned(capture.real_dn)))


def _times_as_bright(a: RealCapture, b: RealCapture) -> float | None:
    """Ratio of the signals of b to those of a; None where too few are neither dim nor saturated in both."""
    if a.real_dn.shape[1:] != b.real_dn.shape[1:]:
        return None
    black, white = a.context.black_level_dn, a.context.white_level_dn
    first, second = (thinned(each.real_dn.mean(axis=0)) - black for each in (a, b))
    both = (np.minimum(first, second) > _DIM_DN) & (np.maximum(first, second) < 0.95 * white - black)
    if np.count_nonzero(both) < _FEWEST_LIT:
        return None
    return float(np.median(second[both]) / np.median(first[both]))
