"""Expectations that pictures make of themselves, where no simulator made one.

The diagnosis is then asked how these pictures part from what their target would have been in an ideal camera.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.capture import Noise, RealCapture
from tacos_gap.captures.noise_estimate import estimate_noise
from tacos_gap.captures.sharp_edges import with_sharp_edges
from tacos_gap.captures.targets.bracket import expected_of, measure_bracket
from tacos_gap.captures.targets.chart import (
    expected_patches,
    find_chart,
    light_on,
    patch_colours,
    patch_errors,
    reference_colours,
)
from tacos_gap.captures.targets.chart_pixels import in_colour, in_file
from tacos_gap.captures.targets.even_noise import even_noise
from tacos_gap.captures.targets.photon_transfer import pooled_noise, zero_levels_dn
from tacos_gap.captures.targets.slanted_edge import find_edge, sharp_edge
from tacos_gap.captures.targets.two_tone import with_print
from tacos_gap.captures.targets.wall import even_expectation, smooth_light

LEVEL_UNCERTAINTY = 0.05
"""Of a level that was read from the pictures themselves: a twentieth, the bend a lens leaves at the principal
point of a wall or a curve at the white of a chart."""

_SATURATED = 0.5
"""Share of clipped pixels from which on a wall has no level of its own."""


@dataclass(frozen=True)
class Expected:
    """A capture with an expectation, or without one and the reason, in a sentence."""

    capture: RealCapture
    lacks: str = ""


def with_own_expectations(
    captures: Sequence[RealCapture],
) -> tuple[tuple[RealCapture, ...], tuple[str, ...]]:
    """Give captures that lack an expectation the one their own pictures make, by their kind; and all a noise.

    Returns: the captures that have an expectation or need none, in their order; and a sentence for each that
    was left out.
    """
    gains = _by_gain(captures)
    noise = {gain: pooled_noise(members) for gain, members in gains.items()}
    zero_dn = {gain: zero_levels_dn(members) for gain, members in gains.items()}
    found = {each.capture.id: each for each in _brackets(captures)}
    kept, said = [], []
    for capture in captures:
        if capture.kind == "board" or capture.expected_dn is not None:
            own = capture.noise if capture.noise.known else estimate_noise(capture)
            kept.append(replace(capture, noise=own))
            continue
        expected = found.get(capture.id) or _expected(capture)
        if expected.lacks:
            said.append(f"{capture.id}: {expected.lacks}")
        else:
            above = _above_the_darks(expected.capture, zero_dn[capture.context.gain_db])
            kept.append(_with_noise(above, noise[capture.context.gain_db]))
    return tuple(kept), tuple(said)


def _by_gain(captures: Sequence[RealCapture]) -> dict[float, list[RealCapture]]:
    gains: dict[float, list[RealCapture]] = {}
    for capture in captures:
        gains.setdefault(capture.context.gain_db, []).append(capture)
    return gains


def _above_the_darks(capture: RealCapture, zero_dn: NDArray[np.float64]) -> RealCapture:
    """A wall or an edge as it would look above the believed pedestal; its files have that of the darks.

    Else its light would hold the error of the pedestal, and the darks say that it is there.
    """
    off_dn = (zero_dn - capture.context.black_level_dn).astype(np.float32)
    if capture.kind not in ("flat", "edge") or capture.expected_dn is None or not off_dn.any():
        return capture
    return replace(capture, expected_dn=capture.expected_dn - off_dn)


def _with_noise(capture: RealCapture, pooled: Noise | None) -> RealCapture:
    """With an unknown noise estimated, now that edges and mosaics are not taken for it."""
    if capture.noise.known:
        return capture
    single = capture.frames == 1 and capture.kind in ("edge", "chart", "flat")
    own = pooled or (even_noise(capture) if single else None) or estimate_noise(capture)
    return replace(capture, noise=own)


# kind by kind ---------------------------------------------------------------------------------------------


def _expected(capture: RealCapture) -> Expected:
    if capture.kind == "flat":
        return _wall(capture)
    if capture.kind == "edge":
        return Expected(_edge(capture))
    if capture.kind == "chart":
        return _chart(capture)
    return Expected(
        capture,
        f"nothing says what a {capture.kind} should look like; it is left out. Give `simulated`, or a "
        f"`scene` recipe that renders it.",
    )


def _wall(capture: RealCapture) -> Expected:
    mean = capture.real_dn.mean(axis=0)
    if np.mean(mean >= 0.98 * capture.context.white_level_dn) > _SATURATED:
        return Expected(capture, "most of its pixels are clipped, so its level is unknown; it is left out.")
    expected = even_expectation(mean, capture.geometry.centre_px, mosaic=capture.is_mosaic)
    return Expected(
        replace(
            capture,
            expected_dn=expected[None],
            level_uncertainty=max(capture.level_uncertainty, LEVEL_UNCERTAINTY),
            own_level=True,
        )
    )


def _edge(capture: RealCapture) -> RealCapture:
    """One straight edge by its line and its two sides; print by its ink; other edges window by window."""
    mean = capture.real_dn.mean(axis=0)
    green = mean.shape[-1] // 2
    edge = find_edge(mean[..., green])
    if edge is None:
        return with_print(capture) or with_sharp_edges(capture)
    planes, near = zip(*(sharp_edge(mean[..., c], edge) for c in range(mean.shape[-1])), strict=True)
    return replace(
        capture,
        expected_dn=np.stack(planes, axis=-1)[None],
        valid=capture.valid & near[0],
        edge_angle_deg=capture.edge_angle_deg if capture.edge_angle_deg is not None else edge.angle_deg,
        level_uncertainty=max(capture.level_uncertainty, LEVEL_UNCERTAINTY),
        own_edges=True,
    )


def _chart(capture: RealCapture) -> Expected:
    """The patches of a table, or those of a ColorChecker that is found, in the light its greys tell."""
    if capture.patches is not None:
        boxes, colours = capture.patches
        expected, inside = expected_patches(capture, boxes, colours - capture.context.black_level_dn)
        return Expected(replace(capture, expected_dn=expected, valid=capture.valid & inside))
    above_dn = capture.real_dn.mean(axis=0) - capture.context.black_level_dn
    if (picture := in_colour(above_dn, capture.context.cfa)) is None:
        return Expected(
            capture,
            "a chart needs a picture in colour, or the filters of its mosaic (`cfa`); it is left out.",
        )
    found = find_chart(picture)
    if found is None:
        return Expected(
            capture,
            "no ColorChecker was found in it; it is left out. It should face the camera and be at least a "
            "quarter as wide as the picture; or give `chart: {patches: FILE}`.",
        )
    boxes = in_file(found.boxes(), capture)
    light = light_on(capture, patch_colours(capture, boxes), patch_errors(capture, boxes))
    if light is None:
        return Expected(
            capture,
            "of the greys of its ColorChecker fewer than four lie between full scale and the noise above the "
            "pedestal; it is left out. Expose so that the white patch stays below full scale; check "
            "black_level_dn.",
        )
    colours = reference_colours() * light.white_dn
    expected, inside = expected_patches(capture, boxes, colours)
    return Expected(
        replace(
            capture,
            expected_dn=expected,
            valid=capture.valid & inside,
            patches=(boxes, colours + capture.context.black_level_dn),
            level_uncertainty=max(capture.level_uncertainty, LEVEL_UNCERTAINTY),
        )
    )


def _brackets(captures: Sequence[RealCapture]) -> Iterator[Expected]:
    groups: dict[str, list[RealCapture]] = {}
    for capture in captures:
        if capture.kind == "bracket" and capture.expected_dn is None:
            groups.setdefault(f"{capture.group} {capture.real_dn.shape[1:]}", []).append(capture)
    for members in groups.values():
        if len({each.context.exposure_s for each in members}) < 2:
            yield from (
                Expected(each, "a bracket needs a second exposure time in its group; it is left out.")
                for each in members
            )
            continue
        bracket = measure_bracket(members)
        even = smooth_light(bracket.rate, mosaic=members[0].is_mosaic)
        if even is not None:
            bracket = replace(bracket, rate=even)
        for each in members:
            expected = replace(
                each,
                expected_dn=expected_of(bracket, each),
                valid=each.valid & bracket.known,
                level_uncertainty=max(each.level_uncertainty, LEVEL_UNCERTAINTY),
                expected_frames=each.frames if each.frames > 1 and even is None else 0,
                own_level=True,
                own_light="smooth" if even is not None else "pixel by pixel",
            )
            yield Expected(expected)
