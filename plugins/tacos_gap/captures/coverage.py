"""What a folder of captures cannot tell, however they come out, and what to photograph to know it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from tacos_gap.captures.capture import Capture

Captures = Sequence[Capture]

FEWEST_VIEWS = 3
"""Views of a board below which lens, focal length and pose are mixed up."""

FEWEST_TIMES = 3
"""Exposure times of a series below which a curve cannot be told from a line."""


@dataclass(frozen=True)
class Need:
    """What some effects need.

    Parameters
    ----------
    effects
        Names of the effects.
    met
        Whether captures meet it.
    remedy
        What to photograph.
    """

    effects: tuple[str, ...]
    met: Callable[[Captures], bool]
    remedy: str


def _of(captures: Captures, *kinds: str) -> list[Capture]:
    return [capture for capture in captures if capture.kind in kinds]


def _times(captures: Captures) -> set[float]:
    return {capture.context.exposure_s for capture in captures}


def _a_series(captures: Captures) -> bool:
    groups: dict[str, set[float]] = {}
    for capture in _of(captures, "bracket"):
        groups.setdefault(capture.group or capture.kind, set()).add(capture.context.exposure_s)
    return any(len(times) >= FEWEST_TIMES for times in groups.values())


NEEDS = (
    Need(
        ("black-level", "dsnu", "row-noise"),
        lambda all_of: bool(_of(all_of, "dark")),
        "kind dark: frames with the cap on",
    ),
    Need(
        ("dark-current",),
        lambda all_of: len(_times(_of(all_of, "dark"))) > 1,
        "kind dark at a second, ten times longer exposure",
    ),
    Need(
        ("vignetting", "illumination-gradient", "prnu", "conversion-gain-error"),
        lambda all_of: bool(_of(all_of, "flat", "bracket")),
        "kind flat: frames of an even surface",
    ),
    Need(
        ("prnu", "dsnu", "crosstalk", "denoise"),
        lambda all_of: any(capture.frames > 1 for capture in _of(all_of, "dark", "flat", "bracket")),
        "two or more frames of a flat, with the same settings",
    ),
    Need(
        ("tone-curve", "nonlinearity", "saturation"),
        _a_series,
        f"kind bracket: {FEWEST_TIMES} or more exposure times under the same light, in one group",
    ),
    Need(
        ("defocus", "lens-blur", "sharpening"),
        lambda all_of: any(capture.is_structured for capture in _of(all_of, "edge", "scene", "chart")),
        "kind edge: sharp edges all over the field",
    ),
    Need(
        ("lens-distortion", "focal-length-error"),
        lambda all_of: len(_of(all_of, "board")) >= FEWEST_VIEWS,
        f"kind board: {FEWEST_VIEWS} or more views, tilted by 20 to 40 degrees to different sides",
    ),
    Need(
        ("white-balance", "colour-matrix"),
        lambda all_of: all_of[0].real_dn.shape[-1] == 1 or any(capture.patches for capture in all_of),
        "kind chart: a colour chart with its patches",
    ),
    Need(
        ("rolling-shutter", "motion-blur"),
        lambda all_of: any(c.context.velocity_px_s is not None for c in _of(all_of, "sequence")),
        "kind sequence: something that moves at a known velocity_px_s",
    ),
    Need(
        ("flicker",),
        lambda all_of: any(capture.frames > 1 for capture in _of(all_of, "flat", "sequence")),
        "two or more frames under the lamps in question",
    ),
)
"""What effects need before a diagnosis can speak of them."""


def untold(captures: Captures) -> Iterator[tuple[tuple[str, ...], str]]:
    """Effects that these captures cannot show, or not tell from others, each with what would."""
    for need in NEEDS:
        if not need.met(captures):
            yield need.effects, need.remedy
