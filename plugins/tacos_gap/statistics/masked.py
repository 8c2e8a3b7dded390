"""Images of which some pixels count."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def only_in(where: NDArray[np.bool_], image: NDArray[np.float32]) -> NDArray[np.float32]:
    """(..., H, W, C) images, 0 outside (H, W) `where`; the image itself where that is everywhere.

    A row at a time and by floats: by truth values, three channels at a time, numpy takes three times as long.
    """
    if where.all():
        return image
    *_, height, width, channels = image.shape
    samples = np.repeat(where.astype(np.float32), channels, axis=1)
    return np.asarray(image.reshape(-1, height, width * channels) * samples).reshape(image.shape)
