"""Limits of captures: the usual reasons of `LookAlike` and `ShownBy`."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tacos_framework import Captures, ObservedCapture, lit, of_kind, structured

FEWEST_VIEWS = 3
"""Views of a board below which lens, focal length and pose are mixed up."""

FEWEST_TIMES = 3
"""Exposure times of a series below which a curve cannot be told from a line."""

APART_DEG = 30.0
"""Angle between two edges from which on blur along one direction clearly shows more in one of them [deg]."""


def one_flat_without_stack(captures: Captures) -> bool:
    """Nothing but one lit frame: uneven light turns with nothing, and no noise is seen."""
    seen = lit(captures)
    return len(seen) == 1 and seen[0].frames == 1


def no_repeats(captures: Captures) -> bool:
    """No even field was taken twice, so that fixed patterns and noise are one."""
    return all(capture.frames == 1 for capture in of_kind(captures, "dark", "flat", "bracket"))


def one_or_two_levels(captures: Captures) -> bool:
    """One lit capture, of an even field or of a straight edge: points of a curve that a line runs through."""
    seen = lit(captures)
    return len(seen) == 1 and (not seen[0].is_structured or seen[0].edge_angle_deg is not None)


def one_exposure_of_a_scene(captures: Captures) -> bool:
    """One lit capture, of a scene: its levels may be the light's or a curve's."""
    seen = lit(captures)
    return len(seen) == 1 and seen[0].kind == "scene"


def one_scene_no_dark(captures: Captures) -> bool:
    """One capture, and none with the cap on: an offset may be stray light."""
    return not of_kind(captures, "dark") and len(captures) == 1


def one_exposure_no_dark(captures: Captures) -> bool:
    """One exposure time, and the cap never on: what grows with time is as large as what does not."""
    return not of_kind(captures, "dark") and len({each.context.exposure_s for each in captures}) == 1


def one_depth_one_place(captures: Captures) -> bool:
    """Sharpness is seen on one straight edge alone: at one distance and one place in the field."""
    seen = structured(captures)
    return len(seen) == 1 and seen[0].edge_angle_deg is not None


def one_velocity(captures: Captures) -> bool:
    """What moves does so at one velocity, in single frames."""
    moving = of_kind(captures, "sequence")
    known = [c.context.known_velocity_px_s("") for c in moving if c.context.velocity_px_s is not None]
    means = {tuple(np.round(v.reshape(-1, 2).mean(axis=0), 1).tolist()) for v in known}
    return len(means) < 2 and max((capture.frames for capture in moving), default=1) < 2


def flat_on(captures: Captures) -> bool:
    """All that shows displacement is one view, so that distance, tilt and lens are one."""
    return len(of_kind(captures, "board")) < 2 and not structured(captures)


def one_view(captures: Captures) -> bool:
    """One view of a board, and nothing else that shows displacement."""
    return len(of_kind(captures, "board")) == 1 and not structured(captures)


def any_of_kind(*kinds: str) -> Callable[[Captures], bool]:
    """Tests for a capture of some kinds."""
    return lambda captures: bool(of_kind(captures, *kinds))


def none_of_kind(*kinds: str) -> Callable[[Captures], bool]:
    """Tests that there is no capture of some kinds."""
    return lambda captures: not of_kind(captures, *kinds)


def repeated(*kinds: str) -> Callable[[Captures], bool]:
    """Tests for a capture of some kinds with two frames or more."""
    return lambda captures: any(capture.frames > 1 for capture in of_kind(captures, *kinds))


def structured_of_kind(*kinds: str) -> Callable[[Captures], bool]:
    """Tests for a capture of some kinds that shows edges or texture."""
    return lambda captures: bool(structured(of_kind(captures, *kinds)))


def levels_expected(captures: Captures) -> bool:
    """A lit capture of which it is known how bright it should be."""
    return any(not capture.own_edges for capture in lit(captures))


def fall_off_expected(captures: Captures) -> bool:
    """An even surface, or light of a bracket that was not measured behind the lens itself."""
    return any(each.kind == "flat" or each.is_structured for each in of_kind(captures, "flat", "bracket"))


def places_expected(captures: Captures) -> bool:
    """A board, or structure of which it is known where it should be."""
    return bool(of_kind(captures, "board")) or any(not each.own_edges for each in structured(captures))


def edges_or_known_motion(captures: Captures) -> bool:
    """Edges in all directions, straight ones in two, or a sequence of what moves at a known velocity."""
    seen = list(structured(captures))
    of_all = any(each.edge_angle_deg is None for each in seen)
    return known_motion(captures) or of_all or _span_deg([_across_deg(each) for each in seen]) > APART_DEG


def edges_of_one_direction(captures: Captures) -> bool:
    """Sharpness is seen on straight edges of one direction alone, which blur along a line spreads as any."""
    return bool(structured(captures)) and not edges_or_known_motion(captures)


def _across_deg(capture: ObservedCapture) -> float:
    """The direction across a straight edge, from the columns, by what is expected [deg]."""
    assert capture.expected_dn is not None
    down, along = np.gradient(capture.expected_dn[0].mean(axis=-1), axis=(0, 1))
    down, along = down[capture.valid], along[capture.valid]
    return float(np.degrees(0.5 * np.arctan2(2 * np.sum(down * along), np.sum(along**2 - down**2))))


def _span_deg(angles_deg: Sequence[float]) -> float:
    """Angle between the farthest two of some directions; 0 and 180 deg are one [deg]."""
    return max((abs((a - b + 90) % 180 - 90) for a in angles_deg for b in angles_deg), default=0.0)


def two_dark_exposures(captures: Captures) -> bool:
    return len({capture.context.exposure_s for capture in of_kind(captures, "dark")}) > 1


def two_gains(captures: Captures) -> bool:
    even = of_kind(captures, "dark", "flat", "bracket")
    return len({capture.context.gain_db for capture in even}) > 1


def a_series_of_exposures(captures: Captures) -> bool:
    """A bracket of `FEWEST_TIMES` exposure times or more in one group."""
    groups: dict[str, set[float]] = {}
    for capture in of_kind(captures, "bracket"):
        groups.setdefault(capture.group or capture.kind, set()).add(capture.context.exposure_s)
    return any(len(times) >= FEWEST_TIMES for times in groups.values())


def views_of_a_board(captures: Captures) -> bool:
    """`FEWEST_VIEWS` views of a chessboard or more."""
    return len(of_kind(captures, "board")) >= FEWEST_VIEWS


def colours_or_mono(captures: Captures) -> bool:
    """A chart with its patches; a camera without colour needs none."""
    return captures[0].real_dn.shape[-1] == 1 or any(capture.patches is not None for capture in captures)


def known_motion(captures: Captures) -> bool:
    return any(capture.context.velocity_px_s is not None for capture in of_kind(captures, "sequence"))
