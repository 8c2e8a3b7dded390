"""Limits of captures, and settings that contradict the pictures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Fault
from tacos_gap.captures.alignment import REMEDY, is_share_of_full_scale
from tacos_gap.captures.capture import RealCapture

CLIPPED_SHARE = 0.9
"""Share of clipped pixels above which a capture tells next to nothing."""

FACTOR_OF_DOUBT = 6.0
"""Real over expected signal, or the reverse, beyond which units are doubted before exposures."""

FACTOR_OF_ERROR = 60.0
"""The same, beyond which the two cannot be in the same units."""

_DIM_DN = 8.0
"""Signal below which ratios say nothing [DN]."""


def faults_of(capture: RealCapture) -> Iterator[tuple[str, str, str, str]]:
    """Impossible facts about a capture: the key at fault, what, what was expected, and what to do."""
    real, white = capture.real_dn, capture.context.white_level_dn
    if real.max() > white:
        yield (
            "real",
            f"values of {capture.id!r} reach {real.max():g}",
            f"at most the white level, {white:g}",
            "Correct camera.bit_depth or white_level_dn; values are right-aligned.",
        )
    elif is_share_of_full_scale(real):
        what = f"values of {capture.id!r} run from {real.min():.3g} to {real.max():.3g}"
        yield "real", what, f"digital numbers up to the white level, {white:g}", REMEDY
    elif real.min() < 0:
        yield "real", f"values of {capture.id!r} go down to {real.min():g}", "0 or above", ""
    elif twins := _copies(capture):
        yield (
            "real",
            f"frames {twins[0] + 1} and {twins[1] + 1} of {capture.id!r} are the same, pixel by pixel",
            "frames with independent noise",
            "Take another frame, or leave the copy out.",
        )
    elif _times_as_bright(capture) > FACTOR_OF_ERROR or _times_as_bright(capture) < 1 / FACTOR_OF_ERROR:
        assert capture.expected_dn is not None
        yield (
            "simulated",
            f"values of {capture.id!r} run from {capture.expected_dn.min():g} to "
            f"{capture.expected_dn.max():g}, those of the files from {real.min():g} to {real.max():g}",
            f"digital numbers up to {white:g}, as in the files",
            _in_the_units_of_the_files(capture, capture.expected_dn),
        )


def _in_the_units_of_the_files(capture: RealCapture, expected_dn: NDArray[np.float32]) -> str:
    """Remedy for an expectation far from the files: a factor where one may be missing."""
    black, white = capture.context.black_level_dn, capture.context.white_level_dn
    real, expected = (float(image[:, capture.valid].mean()) for image in (capture.real_dn, expected_dn))
    if real - black < _DIM_DN:
        return f"The files hold no light above the black level, {black:g}: is this capture a dark?"
    if expected_dn.min() >= 0 and 0 < expected_dn.max() <= 1:
        return f"Shares of full scale have to be multiplied by {white:g}, with the black level in them."
    if expected <= black:
        return f"It has to hold the black level, {black:g}, and the light above it."
    if expected < real:
        return f"Multiply it by about {_in_figures(real / expected)} if it is in other units."
    if expected > white:
        return f"Divide it by about {_in_figures(expected / real)} if it is in other units."
    return "Make sure that light, exposure_ms and gain_db were those of the files."


def _in_figures(number: float) -> str:
    """A factor above 1 to three figures, without an exponent.

    >>> _in_figures(256.7), _in_figures(87999.0)
    ('257', '88000')
    """
    return f"{float(f'{number:.3g}'):.10g}"


def _copies(capture: RealCapture) -> tuple[int, int] | None:
    """Two frames that show the same noise; dark, even and noiseless ones may well be alike."""
    real, noise = capture.real_dn, capture.noise
    noiseless = noise.known and not any(noise.photon_dn) and not any(noise.thermal_dn2)
    if capture.kind == "dark" or noiseless:
        return None
    inside = (real[0] > 0) & (real[0] < capture.context.white_level_dn)
    if inside.mean() < 1 - CLIPPED_SHARE or np.ptp(real[0]) < _DIM_DN:
        return None
    for second in range(1, len(real)):
        for first in range(second):
            if np.array_equal(real[first], real[second]):
                return first, second
    return None


def _times_as_bright(capture: RealCapture) -> float:
    """Mean signal of the frames over the expected one; 1 where either says nothing about units."""
    if capture.expected_dn is None or capture.kind == "dark" or not capture.valid.any():
        return 1.0
    black, white = capture.context.black_level_dn, capture.context.white_level_dn
    real = float(capture.real_dn[:, capture.valid].mean()) - black
    expected = float(capture.expected_dn[:, capture.valid].mean()) - black
    if real < _DIM_DN and expected < _DIM_DN:
        return 1.0
    if real > 0.8 * (white - black) and expected > real:  # saturated: any expectation above is fine
        return 1.0
    return max(real, 1e-3) / max(expected, 1e-3)


def limitations_of(capture: RealCapture) -> Iterator[str]:
    real, context = capture.real_dn, capture.context
    if (real >= context.white_level_dn).mean() > CLIPPED_SHARE:
        yield f"{capture.id}: nearly all pixels are saturated; only saturation can be measured."
    elif capture.kind != "dark" and real.max() == real.min():
        yield f"{capture.id}: every pixel is {real.min():g}; a constant image has no information."
    elif capture.kind != "dark" and (real <= 0).mean() > CLIPPED_SHARE:
        yield f"{capture.id}: nearly all pixels are 0; only the dark can be measured."
    if capture.frames == 1 and capture.kind != "board":
        yield (
            f"{capture.id}: a single frame has no real-against-real noise floor and does not tell fixed "
            f"patterns from noise; its noise floor is that of simulated noise alone."
        )
    if not capture.valid.any():
        yield f"{capture.id}: its mask leaves no pixel."
    ratio = _times_as_bright(capture)
    if ratio > FACTOR_OF_DOUBT or ratio < 1 / FACTOR_OF_DOUBT:
        yield (
            f"{capture.id}: the files are {ratio:.2g} times as bright as expected; make sure that bit depth, "
            f"units and exposure times agree before an exposure error is believed."
        )
    if capture.expected_dn is None and capture.kind == "edge":
        yield f"{capture.id}: nothing is simulated; its edges are taken to be sharp in the world."
    if not capture.noise.known:
        yield f"{capture.id}: `noise` is unknown, so it is estimated from the files and not compared."


def order_faults(captures: Sequence[RealCapture], where_of: Mapping[str, str]) -> Iterator[Fault]:
    """Faults of exposure series that grow darker with time: exposures that were mixed up."""
    for name, members in exposure_groups(captures).items():
        series = sorted(members, key=lambda capture: capture.context.exposure_s)
        levels = [float(np.median(capture.real_dn)) for capture in series]
        for (a, below), (b, above) in pairwise(zip(series, levels, strict=True)):
            clipped = 0.98 * a.context.white_level_dn
            longer = b.context.exposure_s > a.context.exposure_s * 1.2
            if longer and above < 0.8 * below - 2 and below < clipped:
                yield Fault(
                    where_of[b.id],
                    f"{b.id!r} at {b.context.exposure_s * 1e3:g} ms is darker ({above:g}) than {a.id!r} at "
                    f"{a.context.exposure_s * 1e3:g} ms ({below:g}), in the group {name!r}",
                    "a group that varies in exposure_ms only",
                    "Check the exposure times.",
                )


def exposure_groups(captures: Iterable[RealCapture]) -> dict[str, list[RealCapture]]:
    """Captures that differ in their stated exposure times only, by the name of their group."""
    groups: dict[str, list[RealCapture]] = {}
    for capture in captures:
        if capture.group is not None and capture.kind != "dark" and capture.exposure_stated:
            groups.setdefault(capture.group, []).append(capture)
    return groups
