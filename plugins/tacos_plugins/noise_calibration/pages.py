"""Shared parts of the pages of both noise procedures: pictures, and figures with intervals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera import display_image
from tacos_plugins.noise_calibration.frame_files import FrameStack
from tacos_report.page import PagePicture, image_uri

_WIDEST_PX = 900


def shown(value: float, interval: Sequence[float] | None = None) -> str:
    """A number with three digits, and its interval.

    >>> shown(0.23994, (0.2379, 0.2419))
    '0.240 (0.238 to 0.242)'
    """
    text = f"{value:#.3g}"
    return text if interval is None else f"{text} ({interval[0]:#.3g} to {interval[1]:#.3g})"


def frame_picture(
    stack: FrameStack, black_level_dn: float, white_level_dn: float, caption: str
) -> PagePicture:
    """The first frame, encoded for a display and not above a width that a page needs."""
    image: NDArray[Any] = stack.picture
    every = -(-image.shape[1] // _WIDEST_PX)
    shrunk = image[::every, ::every]
    display = display_image(np.maximum(shrunk, black_level_dn), black_level_dn, white_level_dn)
    return PagePicture(
        image_uri(np.repeat(display, 3, axis=-1) if display.shape[-1] == 1 else display), caption
    )
