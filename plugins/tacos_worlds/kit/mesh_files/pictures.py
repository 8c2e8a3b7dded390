"""Pictures of textures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image


def picture(loaded: Image.Image, most_px: int) -> NDArray[np.uint8]:
    """(H, W, 4) sRGB and opacity, row 0 at the bottom (v = 0), no edge above `most_px`."""
    loaded = loaded.convert("RGBA")
    if max(loaded.size) > most_px:
        loaded.thumbnail((most_px, most_px), Image.Resampling.BOX)
    return np.ascontiguousarray(np.asarray(loaded)[::-1])
