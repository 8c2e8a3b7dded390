"""What captures cannot tell, and settings that contradict the pictures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from tacos_framework.errors import Fault
from tacos_framework.gap.captures.capture import Capture

CLIPPED_SHARE = 0.9
"""Share of clipped pixels above which a capture tells next to nothing."""


def limitations_of(capture: Capture) -> Iterator[str]:
    """Sentences on what a capture cannot be used for."""
    real, context = capture.real_dn, capture.context
    if capture.kind != "dark" and real.max() == real.min():
        yield f"{capture.id}: every pixel is {real.min():g}; a constant image tells nothing."
    elif (real >= context.white_level_dn).mean() > CLIPPED_SHARE:
        yield f"{capture.id}: nearly all pixels are saturated; only saturation can be judged from it."
    elif capture.kind != "dark" and (real <= 0).mean() > CLIPPED_SHARE:
        yield f"{capture.id}: nearly all pixels are 0; only the dark can be judged from it."
    if capture.frames == 1 and capture.kind != "board":
        yield (
            f"{capture.id}: a single frame has no real-against-real floor and does not tell fixed patterns "
            f"from noise; the simulator's own floor is used."
        )
    if not capture.valid.any():
        yield f"{capture.id}: its mask leaves no pixel."
    if capture.expected_dn is None and capture.kind == "edge":
        yield f"{capture.id}: nothing is simulated; its edges are taken to be sharp in the world."
    if not capture.noise.known:
        yield f"{capture.id}: the simulator's noise is unknown, so noise is estimated and not judged."


def order_faults(captures: Sequence[Capture], where_of: Mapping[str, str]) -> Iterator[Fault]:
    """Faults of exposure series that grow darker with time: exposures that were mixed up."""
    for name, members in _groups(captures).items():
        series = sorted(members, key=lambda capture: capture.context.exposure_s)
        levels = [float(np.median(capture.real_dn)) for capture in series]
        for (a, below), (b, above) in pairwise(zip(series, levels, strict=True)):
            clipped = min(a.context.white_level_dn * 0.98, 1e9)
            longer = b.context.exposure_s > a.context.exposure_s * 1.2
            if longer and above < 0.8 * below - 2 and below < clipped:
                yield Fault(
                    where_of[b.id],
                    f"{b.id!r} at {b.context.exposure_s * 1e3:g} ms is darker ({above:g}) than {a.id!r} at "
                    f"{a.context.exposure_s * 1e3:g} ms ({below:g}), in the group {name!r}",
                    "a group that varies in exposure_ms only",
                    "Check the exposure times.",
                )


def _groups(captures: Iterable[Capture]) -> dict[str, list[Capture]]:
    groups: dict[str, list[Capture]] = {}
    for capture in captures:
        if capture.group is not None and capture.kind != "dark" and capture.exposure_stated:
            groups.setdefault(capture.group, []).append(capture)
    return groups
