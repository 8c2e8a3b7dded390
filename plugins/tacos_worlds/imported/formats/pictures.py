"""Pictures of textures, decoded within limits."""

from __future__ import annotations

import io
import warnings

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from tacos_worlds.imported.formats.file_bytes import Unreadable

MOST_PIXELS = 16384 * 16384
"""Larger pictures are refused before they are decoded [px]."""


def picture(data: bytes, where: str, most_px: int) -> NDArray[np.uint8]:
    """(H, W, 4) sRGB and opacity, row 0 at the bottom (v = 0), no edge above `most_px`.

    Raises
    ------
    Unreadable
        Where it is damaged, cut short, too large, or of a format that is not known.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # ours is the limit below
            image = Image.open(io.BytesIO(data))
        width, height = image.size
        if width * height > MOST_PIXELS:
            raise Unreadable(f"{where} has {width} x {height} pixels, more than {MOST_PIXELS}")
        image.draft("RGB", (most_px, most_px))  # lets JPEG be decoded at a fraction of its size
        loaded = image.convert("RGBA")
    except (UnidentifiedImageError, OSError, SyntaxError, Image.DecompressionBombError) as error:
        raise Unreadable(f"{where} cannot be decoded: {error}") from error
    if max(loaded.size) > most_px:
        loaded.thumbnail((most_px, most_px), Image.Resampling.BOX)
    return np.ascontiguousarray(np.asarray(loaded)[::-1])
