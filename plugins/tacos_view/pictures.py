"""Arrays as pictures for people: frames, depth, ids, and sheets of them."""

from __future__ import annotations

import base64
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera import display_image

Picture = NDArray[np.uint8]
"""(H, W, 3) sRGB, row 0 at the top."""

_GAP_PX = 6
_PAPER = 253


def shown_frame(
    image_dn: NDArray[np.generic], black_level_dn: float, white_level_dn: float, *, coded: bool = False
) -> Picture:
    """An (H, W, C) frame as people expect to see it; one channel becomes grey. See `display_image`."""
    encoded = display_image(image_dn, black_level_dn, white_level_dn, coded=coded)
    return np.repeat(encoded, 3, axis=-1) if encoded.shape[-1] == 1 else encoded


def shown_depth(depth_m: NDArray[np.floating]) -> Picture:
    """Depth as colour: near is bright, by the inverse, so that what is far keeps its place; nothing is black.

    `depth_m`: (H, W), infinite where nothing is [m].
    """
    import cv2

    near = 1.0 / np.maximum(np.asarray(depth_m, np.float64), 1e-6)
    low, high = np.percentile(near[near > 0], (1, 99)) if (near > 0).any() else (0.0, 1.0)
    codes = np.clip(25 + 230 * (near - low) / max(high - low, 1e-9), 0, 255).astype(np.uint8)
    coloured = cv2.applyColorMap(codes, cv2.COLORMAP_INFERNO)[..., ::-1]
    return np.where(near[..., None] > 0, coloured, 0).astype(np.uint8)


def class_colours(count: int) -> NDArray[np.uint8]:
    """(count, 3) sRGB of as many classes; that of the background, the first, is grey."""
    turn = np.arange(count) * (math.sqrt(5) - 1) / 2 % 1  # golden angle: neighbours in number differ in hue
    hues = np.stack([(turn + third / 3) % 1 for third in range(3)], axis=-1)
    colours = (140 + 100 * np.cos(2 * math.pi * hues)).astype(np.uint8)
    colours[0] = 205
    return colours


def shown_objects(object_id: NDArray[np.integer], class_of_object: NDArray[np.integer]) -> Picture:
    """Objects in the colours of their classes, in shades that tell neighbours in number apart.

    `class_of_object`: (objects,) as `World.class_of_object` has it.
    """
    colours = class_colours(int(class_of_object.max(initial=0)) + 1)[class_of_object]
    shade = np.array([1.0, 0.8, 0.6])[np.arange(len(colours)) % 3]
    return np.asarray((colours * shade[:, None]).astype(np.uint8)[object_id])


def contact_sheet(tiles: Sequence[Picture], columns: int, *, widest_px: int = 1400) -> Picture:
    """Pictures in rows, each reduced to fit; smaller ones keep their pixels."""
    room = (widest_px - _GAP_PX * (columns - 1)) // columns
    fitted = [reduced(tile, room) for tile in tiles]
    width = max(tile.shape[1] for tile in fitted)
    rows = []
    for start in range(0, len(fitted), columns):
        row = fitted[start : start + columns]
        height = max(tile.shape[0] for tile in row)
        strip = np.full((height, columns * (width + _GAP_PX) - _GAP_PX, 3), _PAPER, np.uint8)
        for i, tile in enumerate(row):
            strip[: tile.shape[0], i * (width + _GAP_PX) : i * (width + _GAP_PX) + tile.shape[1]] = tile
        rows += [strip, np.full((_GAP_PX, strip.shape[1], 3), _PAPER, np.uint8)]
    return np.concatenate(rows[:-1])


def reduced(picture: Picture, widest_px: int) -> Picture:
    import cv2

    height, width = picture.shape[:2]
    if width <= widest_px:
        return picture
    size = widest_px, max(1, round(height * widest_px / width))
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA))


def encoded_png(picture: Picture) -> bytes:
    import cv2

    encoded, data = cv2.imencode(".png", np.ascontiguousarray(picture[..., ::-1]))
    if not encoded:
        raise ValueError(f"a picture of shape {picture.shape} could not be encoded as PNG")
    return bytes(data.tobytes())


def png_uri(picture: Picture) -> str:
    return f"data:image/png;base64,{base64.b64encode(encoded_png(picture)).decode()}"
