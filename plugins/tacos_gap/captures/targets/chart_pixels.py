"""The colours of a chart's pixels, in files of three channels or behind the filters of a mosaic."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.capture import RealCapture

CELLS = ((0, 0), (0, 1), (1, 0), (1, 1))
"""Row and column of the four photosites of a mosaic's cell, in the order of the letters of its filters."""


def in_colour(image: NDArray[np.floating], cfa: str | None) -> NDArray[np.floating] | None:
    """(H, W, 3) a picture in colour, of a mosaic at half its size; None of a grey one."""
    if image.shape[-1] == 3:
        return image
    if cfa is None:
        return None
    height, width = (2 * (size // 2) for size in image.shape[:2])
    planes = [image[row:height:2, column:width:2, 0] for row, column in CELLS]
    of_letter = {letter: [p for p, own in zip(planes, cfa, strict=True) if own == letter] for letter in "RGB"}
    return np.stack([np.mean(of_letter[letter], axis=0) for letter in "RGB"], axis=-1)


def in_file(boxes: NDArray[np.int64], capture: RealCapture) -> NDArray[np.int64]:
    """Boxes of the picture that `in_colour` gives, in the pixels of its file [px]."""
    return boxes * 2 if capture.is_mosaic else boxes


def filter_of(capture: RealCapture) -> NDArray[np.int64]:
    """(H, W) number of the colour of each photosite of a mosaic, 0 to 2 for R, G, B."""
    numbers = np.array(["RGB".index(letter) for letter in capture.context.cfa or ""]).reshape(2, 2)
    height, width = capture.real_dn.shape[1:3]
    return np.tile(numbers, (height // 2 + 1, width // 2 + 1))[:height, :width]
