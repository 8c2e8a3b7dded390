"""What captures cannot tell apart by their nature, and the capture that would."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tacos_gap.captures import Capture

Captures = Sequence[Capture]


@dataclass(frozen=True)
class NextCapture:
    """A capture to take: its kind, and what it would tell."""

    kind: str
    why: str


@dataclass(frozen=True)
class Ambiguity:
    """Effects that look alike in some captures.

    Parameters
    ----------
    effects
        The effects.
    holds
        Whether these captures leave them alike.
    splits
        The capture that would tell them apart.
    """

    effects: frozenset[str]
    holds: Callable[[Captures], bool]
    splits: NextCapture


def _of_kind(captures: Captures, *kinds: str) -> list[Capture]:
    return [capture for capture in captures if capture.kind in kinds]


def _structured(captures: Captures) -> list[Capture]:
    return [capture for capture in captures if capture.is_structured]


def _one_flat_without_stack(captures: Captures) -> bool:
    lit = [capture for capture in captures if capture.kind != "dark"]
    return len(lit) == 1 and lit[0].frames == 1


def _no_repeats(captures: Captures) -> bool:
    return all(capture.frames == 1 for capture in captures if capture.kind in ("dark", "flat", "bracket"))


def _one_level(captures: Captures) -> bool:
    lit = [capture for capture in captures if capture.kind != "dark"]
    return len(lit) == 1 and not lit[0].is_structured


def _one_exposure_of_a_scene(captures: Captures) -> bool:
    lit = [capture for capture in captures if capture.kind != "dark"]
    return len(lit) == 1 and lit[0].kind == "scene"


def _one_scene_no_dark(captures: Captures) -> bool:
    return not _of_kind(captures, "dark") and len(captures) == 1


def _one_depth_one_place(captures: Captures) -> bool:
    return len(_structured(captures)) == 1 and _structured(captures)[0].edge_angle_deg is not None


def _one_velocity(captures: Captures) -> bool:
    moving = _of_kind(captures, "sequence")
    known = [c.context.velocity_px_s for c in moving if c.context.velocity_px_s is not None]
    means = {tuple(np.round(v.reshape(-1, 2).mean(axis=0), 1).tolist()) for v in known}
    return len(means) < 2 and max((capture.frames for capture in moving), default=1) < 2


def _flat_on(captures: Captures) -> bool:
    """All that shows displacement is one view, so that distance, tilt and lens are one."""
    return len(_of_kind(captures, "board")) < 2 and not _structured(captures)


def _one_view(captures: Captures) -> bool:
    return len(_of_kind(captures, "board")) == 1 and not _structured(captures)


AMBIGUITIES = (
    Ambiguity(
        frozenset({"vignetting", "illumination-gradient"}),
        _one_flat_without_stack,
        NextCapture("flat", "rotated by 90 degrees it tells vignetting from uneven light"),
    ),
    Ambiguity(
        frozenset({"vignetting", "lens-shading-correction"}),
        _one_flat_without_stack,
        NextCapture("flat", "a stack of frames: noise over the field tells light lost from values scaled"),
    ),
    Ambiguity(
        frozenset({"prnu", "conversion-gain-error"}),
        _no_repeats,
        NextCapture("flat", "two or more frames of one setting tell fixed patterns from noise"),
    ),
    Ambiguity(
        frozenset({"dsnu", "read-noise"}),
        _no_repeats,
        NextCapture("dark", "two or more frames of one setting tell fixed patterns from noise"),
    ),
    Ambiguity(
        frozenset({"tone-curve", "exposure-error"}),
        _one_exposure_of_a_scene,
        NextCapture("bracket", "levels against exposure times tell a curve from a scale"),
    ),
    Ambiguity(
        frozenset({"nonlinearity", "exposure-error", "tone-curve"}),
        _one_level,
        NextCapture("bracket", "levels against exposure times tell a curve from a scale"),
    ),
    Ambiguity(
        frozenset({"black-level", "veiling-glare"}),
        _one_scene_no_dark,
        NextCapture("dark", "with the cap on there is no stray light, but still an offset"),
    ),
    Ambiguity(
        frozenset({"defocus", "lens-blur"}),
        _one_depth_one_place,
        NextCapture("edge", "edges over the whole field: blur of the lens grows towards the corners"),
    ),
    Ambiguity(
        frozenset({"rolling-shutter", "pose-error"}),
        _one_velocity,
        NextCapture("sequence", "another velocity: readout bends by it, a pose does not"),
    ),
    Ambiguity(
        frozenset({"focal-length-error", "pose-error"}),
        _flat_on,
        NextCapture("board", "tilted views tell the focal length from the distance"),
    ),
    Ambiguity(
        frozenset({"lens-distortion", "pose-error"}),
        _one_view,
        NextCapture("board", "further tilted views tell the lens from a bent board"),
    ),
)


def confused_with(effect: str, captures: Captures) -> Iterator[tuple[str, NextCapture]]:
    """Effects these captures cannot tell from `effect`, each with the capture that would."""
    for ambiguity in AMBIGUITIES:
        if effect in ambiguity.effects and ambiguity.holds(captures):
            for other in sorted(ambiguity.effects - {effect}):
                yield other, ambiguity.splits
