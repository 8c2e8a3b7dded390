"""Statistics that cannot be measured in a capture, and why, in sentences."""

from __future__ import annotations

from collections.abc import Iterator

from tacos_gap.captures import RealCapture
from tacos_gap.statistics.colour import has_colours
from tacos_gap.statistics.displacement import has_texture
from tacos_gap.statistics.grid import LEAST_EVEN, LEAST_SIDE_PX, has_even_areas
from tacos_gap.statistics.sharpness import LEAST_TILE_PX, has_detail


def nothing_seen(capture: RealCapture) -> str | None:
    """Reason why nothing at all can be measured in a capture; None where something can."""
    height, width = capture.valid.shape
    if min(height, width) < LEAST_SIDE_PX:
        return (
            f"{capture.id}: {width} x {height} pixels are too few to measure anything in; take at least "
            f"{LEAST_SIDE_PX} x {LEAST_SIDE_PX}."
        )
    return None if capture.valid.any() else f"{capture.id}: its mask leaves no pixel; it is left out."


def is_cut_off(capture: RealCapture) -> bool:
    """True if all its pixels stand at one end of the files, where neither light nor noise shows.

    A board whose corners were found shows something, whatever its pixels are.
    """
    if capture.corners is not None:
        return False
    seen = capture.real_dn[:, capture.valid]
    return bool(seen.size) and bool((seen <= 0).all() or (seen >= capture.context.white_level_dn).all())


def unmeasured(capture: RealCapture) -> Iterator[str]:
    """Statistics that a capture of its kind should show, and this one cannot."""
    if capture.is_structured:
        if not has_texture(capture):
            yield f"{capture.id}: no part of what is expected has texture; displacement cannot be measured."
        if not has_detail(capture):
            yield (
                f"{capture.id}: no tile of {LEAST_TILE_PX} x {LEAST_TILE_PX} pixels has detail; sharpness "
                f"cannot be measured."
            )
    repeats = capture.frames > 1 and capture.expected_dn is not None and len(capture.expected_dn) == 1
    needs_even = capture.kind in ("dark", "flat", "bracket") if repeats else True
    if needs_even and not has_even_areas(capture):
        what = "fixed patterns" if repeats else "noise"
        yield f"{capture.id}: fewer than {LEAST_EVEN} pixels are free of edges; {what} cannot be measured."
    if capture.kind == "chart" and capture.real_dn.shape[-1] == 3 and not has_colours(capture):
        yield f"{capture.id}: its colours are too few or too alike; how channels mix cannot be measured."
