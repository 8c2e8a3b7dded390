"""How a JPEG file was coded, as its own header says."""

from __future__ import annotations

from functools import lru_cache
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tacos_files.images import UNREADABLE
from tacos_framework.files.regular import read_bytes

SUFFIXES = (".jpg", ".jpeg")
_SAMPLINGS = ("4:4:4", "4:2:2", "4:2:0")
_LUMINANCE = 0  # number of the table by which luminance is quantised


class JpegCoding(NamedTuple):
    """The coding of a JPEG file.

    Parameters
    ----------
    quality
        As libjpeg counts it; the nearest where the camera has tables of its own.
    subsampling
        Of the colours: 4:4:4, 4:2:2 or 4:2:0; 4:4:4 where it has none, or another.
    """

    quality: int
    subsampling: str


def jpeg_coding(path: Path, *, where: str | None = None, within: Path | None = None) -> JpegCoding | None:
    """How a file was coded, by its header alone; None where it is no JPEG, or its header cannot be read.

    Parameters are those of `tacos_framework.files.regular.read_bytes`.

    Raises
    ------
    UserError
        When it cannot be read or is too large.
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
    return JpegCoding(
        nearest_quality(image.quantization[_LUMINANCE]), _SAMPLINGS[sampling if 0 <= sampling <= 2 else 0]
    )


def nearest_quality(table: list[int]) -> int:
    """The quality whose table of luminance is nearest to one of 64 steps, by the logarithm of the steps.

    >>> nearest_quality([1] * 64)
    100
    """
    off = np.log(_tables()) - np.log(np.maximum(table, 1))
    return 1 + int(np.argmin(np.sum(off**2, axis=1)))


@lru_cache(maxsize=1)
def _tables() -> NDArray[np.float64]:
    """(100, 64) tables of luminance of all qualities from 1 to 100, as the library itself writes them."""
    from PIL import Image
    from PIL.JpegImagePlugin import JpegImageFile

    tables = []
    for quality in range(1, 101):
        coded = BytesIO()
        Image.new("L", (8, 8)).save(coded, "JPEG", quality=quality)
        with Image.open(coded) as image:
            assert isinstance(image, JpegImageFile)
            tables.append(image.quantization[_LUMINANCE])
    return np.array(tables, float)
