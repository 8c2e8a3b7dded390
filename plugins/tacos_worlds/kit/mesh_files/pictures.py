"""Pictures of textures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image

MISSING = "what it is a picture of is drawn plain"
"""Effect of a picture that is not there."""

UNSEEN_REFLECTANCE = 0.5
"""Of a surface whose picture is not there, white in its material as most are under a picture [1]."""


def picture(loaded: Image.Image, most_px: int) -> NDArray[np.uint8]:
    """(H, W, 4) sRGB and opacity, row 0 at the bottom (v = 0), no edge above `most_px`."""
    if loaded.mode.startswith("I"):  # greys of 16 bits, which Pillow would clip at 255
        loaded = Image.fromarray((np.asarray(loaded).astype(np.int64) >> 8).clip(0, 255).astype(np.uint8))
    loaded = loaded.convert("RGBA")
    if max(loaded.size) > most_px:
        loaded.thumbnail((most_px, most_px), Image.Resampling.BOX)
    return np.ascontiguousarray(np.asarray(loaded)[::-1])
