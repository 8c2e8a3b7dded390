"""Samples of image files, decoded only once the header says what that takes."""

from __future__ import annotations

import warnings
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tacos_files.image_headers import (
    FORMATS,
    TEXTURE_FORMATS,
    UNREADABLE,
    HeaderError,
    ImageHeader,
    OtherFormat,
    read_header,
)
from tacos_files.tiff_as_stored import tiff_as_stored
from tacos_framework import Fault, UserError
from tacos_framework.files import limits, read_bytes, too_large

if TYPE_CHECKING:
    from PIL.Image import Image


def read_samples(path: Path, *, where: str | None = None, within: Path | None = None) -> NDArray[Any]:
    """The samples of an image file as stored: (H, W), or (H, W, 3) in the order R, G, B; alpha is left out.

    Parameters are those of `tacos_framework.files.regular.read_bytes`.

    Raises `UserError` when it cannot be read, is no image, cut short, damaged or too large.
    """
    name = str(path) if where is None else where
    return decode_samples(read_bytes(path, "image_mb", where=where, within=within), name, path.name)


def decode_samples(content: bytes, where: str, name: str) -> NDArray[Any]:
    """The samples of an image file whose bytes are at hand, as `read_samples` gives them.

    `where`, `name`: what the fault is of, and what to call the file in it.
    """
    header = checked_header(content, where, name)
    if header.format != "TIFF":
        return _decoded(content, header, where, name)
    try:
        stored = tiff_as_stored(content)
    except HeaderError as error:
        raise UserError(_unreadable(where, name, error)) from error
    planes = [_decoded(plane, header, where, name) for plane in stored.planes]
    samples = planes[0] if len(planes) == 1 else np.stack(planes, axis=-1)
    return samples >> stored.shift if stored.shift else samples


def _decoded(content: bytes, header: ImageHeader, where: str, name: str) -> NDArray[Any]:
    import cv2

    before = cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_ERROR)  # it warns of unknown tags
    try:
        image = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error as error:
        raise UserError(_damaged(where, name, str(error).strip())) from error
    finally:
        cv2.utils.logging.setLogLevel(before)
    if image is None or image.shape[:2] != (header.height_px, header.width_px):
        raise UserError(_damaged(where, name, f"its samples are no whole {header.format}"))
    samples: NDArray[Any] = np.asarray(image)
    return samples[..., 2::-1] if samples.ndim == 3 and samples.shape[2] in (3, 4) else samples


def decode_picture(content: bytes, where: str, name: str) -> Image:
    """A picture such as a texture, decoded as Pillow has it; parameters are those of `decode_samples`."""
    from PIL import Image as Pillow

    checked_header(content, where, name, of_texture=True)
    try:
        with warnings.catch_warnings():  # Pillow warns of sizes, which were checked, and of odd entries
            warnings.simplefilter("ignore")
            image = Pillow.open(BytesIO(content))
            image.load()
    except (*UNREADABLE, Pillow.DecompressionBombError) as error:
        raise UserError(_damaged(where, name, str(error))) from error
    return image


def checked_header(content: bytes, where: str, name: str, *, of_texture: bool = False) -> ImageHeader:
    """The header of an image that is whole and not too large; `of_texture` as in `read_header`.

    Raises `UserError` when it is neither.
    """
    try:
        header = read_header(content, of_texture=of_texture)
    except HeaderError as error:
        raise UserError(
            _unreadable(where, name, error, TEXTURE_FORMATS if of_texture else FORMATS)
        ) from error
    size = f"{header.width_px} x {header.height_px} pixels of {name}"
    if header.decoded_bytes > limits().bytes_of("image_mb"):
        raise UserError(too_large(where, f"the image of {size}", header.decoded_bytes, "image_mb"))
    return header


def _unreadable(where: str, name: str, error: HeaderError, formats: str = FORMATS) -> Fault:
    what = f"{name} is no image that can be read: {error}"
    remedy = "Save it as one of these." if isinstance(error, OtherFormat) else "Copy or save it anew."
    return Fault(where, what, formats, remedy)


def _damaged(where: str, name: str, reason: str) -> Fault:
    return Fault(where, f"{name} is damaged: {reason}", "a whole image", "Copy or save it anew.")
