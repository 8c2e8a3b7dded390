"""Captures that were photographed, what they can tell, and what it takes to tell the rest."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera import srgb_from_linear
from tacos_gap.answer.findings import Diagnosis
from tacos_gap.captures import RealCapture
from tacos_gap.captures.coverage import untold
from tacos_gap.report import words
from tacos_gap.report.limits_in_words import limits_in_words
from tacos_report.page import Block, ContactSheet, Folded, PagePicture, Paragraph, Table, image_uri
from tacos_report.quantities import number, unit_sign

MOST = 36
"""Pictures on a contact sheet."""

THUMBNAIL_PX = 180
"""Width of a picture on it [px]."""

TELLS = {
    "dark": "pedestal, read noise, dark current, hot pixels and noise of rows",
    "flat": "noise against signal, dark corners, pixels that respond unequally, flicker",
    "bracket": "linearity, saturation and the tone curve",
    "edge": "sharpness over the field, sharpening, colour fringes",
    "board": "distortion and focal length",
    "chart": "colour, white balance and tone",
    "scene": "sharpness, shifts of colour and place, compression; and scores of tasks",
    "sequence": "what changes from frame to frame: rolling shutter, motion blur, exposure control",
}


def photographed(captures: Sequence[RealCapture]) -> Iterator[Block]:
    pictures = tuple(
        PagePicture(image_uri(thumbnail(capture)), f"{capture.id}: {_taken(capture)}")
        for capture in captures[:MOST]
    )
    yield ContactSheet(pictures)
    if len(captures) > MOST:
        yield Paragraph(f"And {len(captures) - MOST} more, which the table at the end lists.")
    kinds = list(dict.fromkeys(capture.kind for capture in captures))
    rows = []
    for kind in kinds:
        of_kind = [capture for capture in captures if capture.kind == kind]
        frames = sum(capture.frames for capture in of_kind)
        count = f"{len(of_kind)} with {frames} frames" if frames > 1 else "1 with 1 frame"
        rows.append((kind, count, TELLS.get(kind, "")))
    yield Table(("kind", "captures", "shows"), tuple(rows))


def _taken(capture: RealCapture) -> str:
    said = [f"{capture.frames} frame{'s' if capture.frames > 1 else ''}"]
    if capture.exposure_stated:
        said.append(f"{number(1e3 * capture.context.exposure_s, 4)} ms")
    if capture.context.gain_db:
        said.append(f"{capture.context.gain_db:g} dB")
    return ", ".join(said)


def thumbnail(capture: RealCapture) -> NDArray[np.uint8]:
    """The first real frame, small, as a viewer would show it: black level black, full scale white."""
    frame = capture.whole.small_dn if capture.whole else capture.real_dn[0]
    return small_picture(frame, capture.context.black_level_dn, capture.context.white_level_dn)


def small_picture(frame: NDArray[Any], black_dn: float, white_dn: float) -> NDArray[np.uint8]:
    """(H, W) or (H, W, 3) file values (H, W, C), small, as a viewer would show them."""
    height, width = frame.shape[:2]
    size = THUMBNAIL_PX, max(1, round(height * THUMBNAIL_PX / width))
    values = np.asarray(frame, np.float32)
    small = cv2.resize(values, size, interpolation=cv2.INTER_AREA).reshape(size[1], size[0], -1)
    shown = np.rint(255 * srgb_from_linear(np.clip((small - black_dn) / (white_dn - black_dn), 0, 1)))
    image: NDArray[np.uint8] = shown.astype(np.uint8)
    return image[..., 0] if image.shape[-1] == 1 else image


def not_told(
    captures: Sequence[RealCapture], effects: Mapping[str, type[Any]], diagnosis: Diagnosis
) -> Iterator[Block]:
    """Captures needed to tell the effects these are blind to, and how small the others may be."""
    yield from effects_not_shown(captures, effects)
    if limits := diagnosis.detectable:
        yield Paragraph(
            "Other effects may be there below their detection limits. An effect at its limit shows in half "
            "of such captures, and one a third larger in all of them."
        )
        said = limits_in_words(limits, effects, captures[0].geometry)
        rows = tuple((words.effect_words(effect), limit) for effect, limit in said.items())
        table = Table(("effect", "would have shown from"), rows)
        yield Folded("Detection limits", (table,))


def effects_not_shown(captures: Sequence[RealCapture], effects: Mapping[str, type[Any]]) -> Iterator[Block]:
    if lacking := untold(captures, effects):
        rows = [
            (remedy, ", ".join(words.effect_words(name) for name in names))
            for remedy, names in sorted(lacking.items(), key=lambda item: -len(item[1]))
        ]
        yield Paragraph("Nothing can be said of these effects until the captures hold what shows them:")
        yield Table(("photograph", "to learn of"), tuple(rows))


def nuisance_rows(nuisances: Mapping[str, Mapping[str, Any]]) -> tuple[tuple[str, str], ...]:
    """Offsets of each capture's expectation by nuisances; equal ones share a row.

    >>> nuisance_rows({"flat_03": {"gain": 1.02, "shift_px": [0.31, -0.12]}})
    (('flat_03', 'gain 1.02, shift 0.31 \u22120.12 px'),)
    """
    captures: dict[str, list[str]] = {}
    for capture, values in nuisances.items():
        said = ", ".join(_nuisance(name, value) for name, value in values.items()).replace("-", "\u2212")
        captures.setdefault(said, []).append(capture)
    return tuple((words.first_of(names), said) for said, names in captures.items())


_UNITS = ("px", "deg", "dn", "mm")


def _nuisance(name: str, value: Any) -> str:
    stem, _, unit = name.rpartition("_")
    if unit not in _UNITS:
        stem, unit = name, ""
    numbers = value if isinstance(value, list | tuple) else [value]
    shown = " ".join(f"{v:.3g}" if isinstance(v, int | float) else str(v) for v in numbers)
    sign = unit_sign(unit.upper() if unit == "dn" else unit) if unit else ""
    return f"{stem.replace('_', ' ')} {shown} {sign}".rstrip()
