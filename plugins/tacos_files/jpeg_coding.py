"""Coding of a JPEG file, by its own header."""

from __future__ import annotations

from functools import lru_cache
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tacos_files.image_headers import UNREADABLE
from tacos_framework.files import read_bytes

SUFFIXES = (".jpg", ".jpeg")
_SAMPLINGS = ("4:4:4", "4:2:2", "4:2:0")
_LUMINANCE, _CHROMINANCE = 0, 1  # numbers of the tables by which brightness and colours are quantised


class JpegCoding(NamedTuple):
    quality: int
    """As libjpeg counts it; the nearest where the camera has tables of its own."""
    subsampling: str
    """Of the colours: 4:4:4, 4:2:2 or 4:2:0; 4:4:4 where it has none, or another."""
    chroma_offset: int
    """Quality of the colours, likewise the nearest, less that of brightness; 0 where there are none."""


def jpeg_coding(path: Path, *, where: str | None = None, within: Path | None = None) -> JpegCoding | None:
    """Coding of a file, by its header alone; None if it is no JPEG, or its header cannot be read.

    Parameters are those of `tacos_framework.files.regular.read_bytes`.

    Raises `UserError` when it cannot be read or is too large.
    """
    if path.suffix.lower() not in SUFFIXES:
        return None
    from PIL.JpegImagePlugin import JpegImageFile, get_sampling

    try:
        image = JpegImageFile(BytesIO(read_bytes(path, "image_mb", where=where, within=within)))
    except UNREADABLE:
        return None
    if _LUMINANCE not in image.quantization:
        return None
    sampling = get_sampling(image)
    quality = nearest_quality(image.quantization[_LUMINANCE])
    of_colours = image.quantization.get(_CHROMINANCE) if image.mode != "L" else None
    offset = chroma_offset(of_colours, quality) if of_colours else 0
    return JpegCoding(quality, _SAMPLINGS[sampling if 0 <= sampling <= 2 else 0], offset)


def nearest_quality(table: list[int]) -> int:
    """The quality whose table of brightness is nearest to one of 64 steps, by the logarithm of the steps.

    >>> nearest_quality([1] * 64)
    100
    """
    return 1 + int(np.argmin(_distances(table, _LUMINANCE)))


def chroma_offset(table: list[int], quality: int) -> int:
    """The quality whose table of colours is nearest to one of 64 steps, less that of brightness.

    0 where that of brightness is as near: tables of the lowest qualities are alike.

    >>> chroma_offset([255] * 64, quality=3)
    0
    """
    distances = _distances(table, _CHROMINANCE)
    return 0 if distances[quality - 1] <= distances.min() else 1 + int(np.argmin(distances)) - quality


def _distances(table: list[int], number: int) -> NDArray[np.float64]:
    """(100,) how far a table is from those of all qualities."""
    off = np.log(_tables()[number]) - np.log(np.maximum(table, 1))
    return np.asarray(np.sum(off**2, axis=1))


@lru_cache(maxsize=1)
def _tables() -> NDArray[np.float64]:
    """(2, 100, 64) tables of brightness and colours, qualities from 1 to 100, as the library writes them."""
    from PIL import Image
    from PIL.JpegImagePlugin import JpegImageFile

    tables = []
    for quality in range(1, 101):
        coded = BytesIO()
        Image.new("RGB", (8, 8)).save(coded, "JPEG", quality=quality)
        with Image.open(coded) as image:
            assert isinstance(image, JpegImageFile)
            tables.append([image.quantization[number] for number in (_LUMINANCE, _CHROMINANCE)])
    return np.moveaxis(np.array(tables, float), 1, 0)
