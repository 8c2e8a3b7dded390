"""Sample frames as data URIs, and how large to show them beside one another."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tacos_framework import UserError
from tacos_report.study_data import CameraResult
from tacos_report.view_geometry import half_extents, horizon_from_top

_JPEG_QUALITY = 88


@dataclass(frozen=True)
class EmbeddedImage:
    """An embedded image; width and height are those of the file, before any reduction [px]."""

    uri: str
    width_px: int
    height_px: int


MOST_ENLARGED = 1.5
"""How much larger than its pixels a frame is shown at most [screen px / px]: more would only blur."""


@dataclass(frozen=True)
class FramePlacement:
    """Position of a frame in a row of frames, in percent of the row's width."""

    width: float
    top: float


def picture(path: Path, widest_px: int, *, lossless: bool = False) -> EmbeddedImage | None:
    """The image embedded as JPEG (or PNG), reduced to at most `widest_px`; None where it cannot be read."""
    import cv2
    import numpy as np

    from tacos_files.images import read_samples

    try:
        image = read_samples(path)
    except UserError:
        return None
    image = np.ascontiguousarray(image if image.ndim == 2 else image[..., ::-1])
    height_px, width_px = image.shape[:2]
    if width_px > widest_px:
        size = widest_px, max(1, round(height_px * widest_px / width_px))
        image = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    kind, options = (".png", []) if lossless else (".jpg", [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
    _, data = cv2.imencode(kind, image, options)
    mime = "image/png" if lossless else "image/jpeg"
    return EmbeddedImage(
        f"data:{mime};base64,{base64.b64encode(data.tobytes()).decode()}", width_px, height_px
    )


def row_width_px(images: Sequence[EmbeddedImage], places: Sequence[FramePlacement]) -> int:
    """Width of a row of frames at which none is enlarged beyond `MOST_ENLARGED` [screen px]."""
    widths = (image.width_px * 100 / place.width for image, place in zip(images, places, strict=True))
    return round(MOST_ENLARGED * min(widths))


def side_by_side(cameras: Sequence[CameraResult], gap: float = 1.6) -> list[FramePlacement]:
    """Sizes at which equal angles about the axis look equal, with all horizons at one height.

    Where a field of view is not known, all frames get the same width and start at the top.

    `gap`: space between frames [percent of the row].
    """
    room = 100.0 - gap * (len(cameras) - 1)
    if not all({"hfov_deg", "vfov_deg"} <= camera.derived.keys() for camera in cameras):
        return [FramePlacement(room / len(cameras), 0.0) for _ in cameras]
    extents = [half_extents(camera.derived["hfov_deg"], camera.derived["vfov_deg"]) for camera in cameras]
    scale = room / sum(2 * half_width for half_width, _ in extents)  # percent per focal length
    horizons = [
        horizon_from_top(half_height, camera.pitch_deg)
        for camera, (_, half_height) in zip(cameras, extents, strict=True)
    ]
    return [
        FramePlacement(2 * half_width * scale, (max(horizons) - horizon) * scale)
        for (half_width, _), horizon in zip(extents, horizons, strict=True)
    ]
