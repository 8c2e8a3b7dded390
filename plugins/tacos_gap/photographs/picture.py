"""A photograph as it is sorted: what its file says, what it shows, a few numbers of its values."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tacos_files.camera_images import read_image
from tacos_framework import Fault, UserError
from tacos_gap.captures.alignment import REMEDY, is_share_of_full_scale, used_bits
from tacos_gap.photographs.facts import Facts, read_facts
from tacos_gap.photographs.shown import Shown, shown_in

_LATTICE = 0.03

USUAL_DEPTH = 12
"""Bits of a camera that writes 16-bit files of values that 9 bits hold: they are dark to it."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A photograph; its samples are read again when they are needed.

    - `facts`, `shown`: what it says and shows.
    - `mono`: whether it has one channel, or three that are equal.
    - `channels`: channels of the file.
    - `sample`: type of its samples, as NumPy calls it.
    - `bits`: bits of the camera, as far as its type and largest value tell.
    - `middle_dn`, `largest_dn`: middle and largest value of the file [DN].
    - `used_bits`: bits that any of its values uses.
    - `lattice`: whether its pixels differ two by two, as behind a mosaic of filters.
    """

    path: Path
    facts: Facts
    shown: Shown
    size_px: tuple[int, int]
    mono: bool
    channels: int
    sample: str
    bits: int
    middle_dn: float
    largest_dn: float
    used_bits: int
    lattice: bool

    @property
    def name(self) -> str:
        return printable_name(self.path)


def printable_name(path: Path) -> str:
    """The name of a file; what neither print nor YAML can hold is an underscore.

    >>> printable_name(Path("photos/wall\\n1.png"))
    'wall_1.png'
    """
    return "".join(letter if letter.isprintable() else "_" for letter in path.name)


def look_at(path: Path, black_dn: float | None, bit_depth: int | None, cfa: str | None = None) -> Picture:
    """Read a photograph and look at it, knowing its black level, bits and filters, or not.

    Raises UserError when the file is no picture, or holds no digital numbers.
    """
    facts = read_facts(path)
    image = read_image(path, str(path))
    if is_share_of_full_scale(image):
        what = f"values of {path.name} run from {image.min():.3g} to {image.max():.3g}"
        raise UserError(Fault(str(path), what, "digital numbers, as the camera wrote them", REMEDY))
    largest = float(image.max())
    bits = bit_depth or bits_of(max(largest, facts.white_level_dn or 0.0), image.dtype.name)
    black = black_dn if black_dn is not None else facts.black_level_dn or 0.0
    white = facts.white_level_dn or 2.0**bits - 1
    height, width, channels = image.shape
    mono = channels == 1 or bool((image == image[..., :1]).all())
    seen = image[..., :1] if mono else image
    return Picture(
        path,
        facts,
        shown_in(seen, min(black, 0.9 * white), white, (cfa or facts.cfa) if channels == 1 else None),
        (width, height),
        mono,
        channels,
        image.dtype.name,
        bits,
        middle_of(image),
        largest,
        used_bits(image),
        channels == 1 and _has_lattice(image[..., 0]),
    )


def middle_of(image: NDArray[np.generic]) -> float:
    """The mean of what lies within four spreads of the median, as whole numbers tell that to a half [DN].

    The median itself where half is cut off at 0.
    """
    values, counts = _counted(image)
    middle = _median_of(values, counts)
    if middle <= 0:
        return middle
    apart = np.abs(values - middle)
    spread = max(1.4826 * _median_of(apart, counts), 1.0)
    inside = apart <= 4 * spread
    return float(np.average(values[inside], weights=counts[inside]))


def _counted(image: NDArray[np.generic]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Values that occur, in order, and how often each does; codes are counted some rows at a time."""
    if image.dtype.kind != "u" or image.dtype.itemsize > 2:
        values, counts = np.unique(np.asarray(image, np.float64), return_counts=True)
        return values, counts
    codes = int(image.max()) + 1
    of_all = np.zeros(codes, np.int64)
    for rows in np.array_split(image, max(1, image.size >> 20)):
        of_all += np.bincount(rows.ravel(), minlength=codes)
    found = np.flatnonzero(of_all)
    return found.astype(np.float64), of_all[found]


def _median_of(values: NDArray[np.float64], counts: NDArray[np.int64]) -> float:
    order = np.argsort(values)
    before = np.cumsum(counts[order])
    middles = np.searchsorted(before, [(before[-1] - 1) // 2, before[-1] // 2], side="right")
    return float(values[order][middles].mean())


def bits_of(largest_dn: float, sample: str) -> int:
    """Bits of a camera by the largest value of its files and the type of their samples; an even number.

    >>> bits_of(200, "uint8"), bits_of(900, "uint16"), bits_of(1100, "uint16"), bits_of(270, "uint16")
    (8, 10, 12, 12)
    """
    if sample == "uint8":
        return 8
    needed = max(8, int(np.ceil(np.log2(largest_dn + 1))))
    return USUAL_DEPTH if sample == "uint16" and needed < 10 else needed + needed % 2


def _has_lattice(plane: NDArray[np.generic]) -> bool:
    """True if the four phases of two by two pixels have other means."""
    if min(plane.shape) < 2:
        return False
    phases = np.array(
        [float(np.asarray(plane[r::2, c::2], np.float64).mean()) for r in (0, 1) for c in (0, 1)]
    )
    return bool(np.ptp(phases) > _LATTICE * max(float(phases.mean()), 4.0))
