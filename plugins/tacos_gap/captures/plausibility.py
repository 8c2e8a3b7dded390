"""What captures cannot tell, and settings that contradict the pictures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from tacos_framework.errors import Fault
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
    """What cannot be right about a capture: the key at fault, what, what was expected, and what to do."""
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
            f"Multiply it by {_times_as_bright(capture):.3g} if it is in other units.",
        )


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
    """Sentences on what a capture cannot be used for."""
    real, context = capture.real_dn, capture.context
    if (real >= context.white_level_dn).mean() > CLIPPED_SHARE:
        yield f"{capture.id}: nearly all pixels are saturated; only saturation can be measured."
    elif capture.kind != "dark" and real.max() == real.min():
        yield f"{capture.id}: every pixel is {real.min():g}; a constant image tells nothing."
    elif capture.kind != "dark" and (real <= 0).mean() > CLIPPED_SHARE:
        yield f"{capture.id}: nearly all pixels are 0; only the dark can be measured."
    if capture.frames == 1 and capture.kind != "board":
        yield (
            f"{capture.id}: a single frame has no real-against-real noise floor and does not tell fixed "
            f"patterns from noise; the simulator's own noise floor is used."
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
        yield f"{capture.id}: the simulator's noise is unknown, so noise is estimated and not compared."


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
