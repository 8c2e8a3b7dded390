"""A photograph as it is sorted: what its file says, what it shows, a few numbers of its values."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.images import read_image
from tacos_gap.photographs.facts import Facts, read_facts
from tacos_gap.photographs.shown import Shown, shown_in

_LATTICE = 0.03


@dataclass(frozen=True, eq=False)
class Picture:
    """A photograph; its samples are read again when they are needed.

    Parameters
    ----------
    path
        The file.
    facts, shown
        What it says and shows.
    size_px
        Width and height.
    mono
        Whether it has one channel, or three that are equal.
    bits
        Bits that its type and its largest value need.
    middle_dn
        Middle value of the file [DN].
    lattice
        Whether its pixels differ two by two, as behind a mosaic of filters.
    """

    path: Path
    facts: Facts
    shown: Shown
    size_px: tuple[int, int]
    mono: bool
    bits: int
    middle_dn: float
    lattice: bool


def look_at(path: Path, black_dn: float | None, bit_depth: int | None) -> Picture:
    """Read a photograph and look at it.

    Raises
    ------
    UserError
        When the file is no picture.
    """
    facts = read_facts(path)
    image = read_image(path, str(path))
    bits = bit_depth or _bits(image, facts)
    black = black_dn if black_dn is not None else facts.black_level_dn or 0.0
    white = facts.white_level_dn or 2.0**bits - 1
    height, width, channels = image.shape
    mono = channels == 1 or bool((image == image[..., :1]).all())
    seen = image[..., :1] if mono else image
    return Picture(
        path,
        facts,
        shown_in(seen, min(black, 0.9 * white), white),
        (width, height),
        mono,
        bits,
        float(np.median(image)),
        channels == 1 and _has_lattice(image[..., 0]),
    )


def _bits(image: NDArray[np.generic], facts: Facts) -> int:
    if image.dtype == np.uint8:
        return 8
    largest = max(float(facts.white_level_dn or 0), float(np.asarray(image).max()))
    return max(8, int(np.ceil(np.log2(largest + 1))))


def _has_lattice(plane: NDArray[np.generic]) -> bool:
    """Whether the four phases of two by two pixels have other means."""
    phases = np.array(
        [float(np.asarray(plane[r::2, c::2], np.float64).mean()) for r in (0, 1) for c in (0, 1)]
    )
    return bool(np.ptp(phases) > _LATTICE * max(float(phases.mean()), 4.0))
