"""Pictures of textures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from tacos_files.images import decode_picture


def picture(data: bytes, where: str, most_px: int) -> NDArray[np.uint8]:
    """(H, W, 4) sRGB and opacity, row 0 at the bottom (v = 0), no edge above `most_px`.

    Raises
    ------
    UserError
        Where it is damaged, cut short, too large, or of a format that is not known.
    """
    loaded = decode_picture(data, where, where).convert("RGBA")
    if max(loaded.size) > most_px:
        loaded.thumbnail((most_px, most_px), Image.Resampling.BOX)
    return np.ascontiguousarray(np.asarray(loaded)[::-1])
