"""Linear sRGB: luminance, and the way to a display and back."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

LUMINANCE_WEIGHTS = (0.2126, 0.7152, 0.0722)
"""Shares of linear sRGB's red, green and blue in luminance (IEC 61966-2-1, Rec. 709)."""


def luminance(rgb: ArrayLike) -> NDArray[np.float64]:
    """Luminance of linear sRGB.

    `rgb`: (..., 3) linear light, white has equal channels [any].

    Returns: (...), in the unit of the channels.

    >>> luminance([1.0, 1.0, 1.0]).round(12).item()
    1.0
    """
    return np.asarray(rgb, dtype=np.float64) @ np.array(LUMINANCE_WEIGHTS)


def srgb_from_linear(linear: ArrayLike) -> NDArray[np.float64]:
    """Encode linear light for a display.

    `linear`: light, 1 is white; clipped to 0..1 [1].

    Returns: sRGB code values, 0..1; same shape [1].

    Source: IEC 61966-2-1:1999.

    >>> srgb_from_linear([0.0, 0.18, 1.0]).round(4).tolist()
    [0.0, 0.4614, 1.0]
    """
    light = np.clip(np.asarray(linear, dtype=np.float64), 0.0, 1.0)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def linear_from_srgb(encoded: ArrayLike) -> NDArray[np.float64]:
    """Linear light of sRGB code values; undoes :func:`srgb_from_linear`.

    `encoded`: sRGB code values, 0..1 [1].

    Returns: light, 1 is white; same shape [1].

    Source: IEC 61966-2-1:1999.

    >>> linear_from_srgb([0.0, 0.4614, 1.0]).round(4).tolist()
    [0.0, 0.18, 1.0]
    """
    code = np.asarray(encoded, dtype=np.float64)
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)


LINEAR_OF_SRGB_BYTE: NDArray[np.float64] = linear_from_srgb(np.arange(256) / 255)
"""(256,) linear value of each sRGB byte: `LINEAR_OF_SRGB_BYTE[image]` is a picture in linear light."""
LINEAR_OF_SRGB_BYTE.flags.writeable = False


def display_image(
    image_dn: NDArray[np.generic], black_level_dn: float, white_level_dn: float, *, coded: bool = False
) -> NDArray[np.uint8]:
    """A frame as people expect to see it.

    - `image_dn`: (..., C) file values, pedestal included [DN].
    - `black_level_dn`, `white_level_dn`: the values shown as black and as white [DN].
    - `coded`: whether the file is coded for a display already, rather than linear.

    Returns: same shape, uint8 sRGB code values, 0..255.

    >>> display_image(np.uint8([16, 55, 255]), 16, 255).tolist()
    [0, 112, 255]
    """
    share = (np.asarray(image_dn, dtype=np.float64) - black_level_dn) / (white_level_dn - black_level_dn)
    return np.rint(255 * (np.clip(share, 0.0, 1.0) if coded else srgb_from_linear(share))).astype(np.uint8)
