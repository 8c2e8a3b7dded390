"""Image files of captures: PNG, TIFF and others OpenCV reads, NumPy arrays, camera RAW."""

from __future__ import annotations

from pathlib import Path
from tokenize import TokenError
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.errors import Fault, UserError

_PNG_BEGIN, _PNG_END = b"\x89PNG", b"IEND"

_LARGEST_DN = 1e9
"""Beyond any file or expectation; what is larger overflows somewhere, not here."""

RAW_SUFFIXES = frozenset({".dng", ".cr2", ".cr3", ".nef", ".arw", ".raf", ".rw2", ".orf"})


def read_image(path: Path, where: str) -> NDArray[Any]:
    """An image as stored: (H, W, C) with C = 1 or 3 in the order R, G, B.

    Parameters
    ----------
    path
        ``.npy``, a camera's RAW file (needs rawpy), or anything OpenCV reads.
    where
        What names the file, for messages.

    Raises
    ------
    UserError
        When it is not there, cannot be read, or holds what is no image.
    """
    try:
        if path.is_dir():
            raise UserError(Fault(where, f"{path.name} is a folder", "files", f"{path.name}/*.png"))
        if not path.is_file():
            raise UserError(Fault(where, f"there is no file {path.name!r}", str(path), "Correct the path."))
    except OSError as error:
        raise UserError(Fault(where, f"{path.name[:60]!r} cannot be a file: {error.strerror}")) from error
    if path.suffix.lower() == ".npy":
        image = read_array(path, where)
    elif path.suffix.lower() in RAW_SUFFIXES:
        image = _read_raw(path, where)
    else:
        image = _read_file(path, where)
    if image.ndim == 2:
        image = image[..., None]
    if not image.size or image.ndim != 3 or image.shape[2] not in (1, 3):
        raise UserError(
            Fault(where, f"{path.name} has the shape {image.shape}", "(height, width) or (height, width, 3)")
        )
    if image.dtype.kind == "f" and not np.isfinite(image).all():
        raise UserError(Fault(where, f"{path.name} holds NaN or infinite values", "finite numbers"))
    if max(abs(float(image.min())), abs(float(image.max()))) > _LARGEST_DN:
        raise UserError(Fault(where, f"{path.name} holds values beyond {_LARGEST_DN:g}", "digital numbers"))
    return image


def read_array(path: Path, where: str) -> NDArray[Any]:
    """An array of numbers from ``.npy``; never one that runs code.

    Its header is a Python literal: a broken one raises what Python's own parser does, or asks for any memory.
    """
    try:
        array: NDArray[Any] = np.load(path, allow_pickle=False)
    except (OSError, ValueError, EOFError, TokenError, SyntaxError, MemoryError, OverflowError) as error:
        raise UserError(
            Fault(where, f"{path.name} is no array: {error}", "a .npy file of numbers")
        ) from error
    if array.dtype.kind not in "buif":
        raise UserError(Fault(where, f"{path.name} holds {array.dtype}", "numbers"))
    return array.astype(np.uint8) if array.dtype == np.bool_ else array


def _read_file(path: Path, where: str) -> NDArray[Any]:
    import cv2

    try:
        content = path.read_bytes()
        if content.startswith(_PNG_BEGIN) and _PNG_END not in content[-64:]:  # else rows that lack are black
            raise UserError(Fault(where, f"{path.name} breaks off in the middle", "", "Copy it anew."))
        image = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    except (OSError, cv2.error) as error:
        raise UserError(Fault(where, f"{path.name} cannot be read: {error}")) from error
    if image is None:
        raise UserError(Fault(where, f"{path.name} is no image that can be read", "PNG, TIFF, JPEG or .npy"))
    if image.ndim == 3:
        image = image[..., 2::-1] if image.shape[2] in (3, 4) else image[..., :1]
    return np.asarray(image)


def _read_raw(path: Path, where: str) -> NDArray[Any]:
    try:
        import rawpy
    except ImportError:
        raise UserError(
            Fault(where, f"{path.name} is a RAW file", "", "pip install 'tacos-framework[raw]'")
        ) from None
    try:
        with rawpy.imread(str(path)) as raw:
            mosaic = raw.raw_image_visible
            if mosaic is None:  # RGB in a RAW container
                raise UserError(Fault(where, f"{path.name} holds no mosaic", "samples of single pixels"))
            return np.array(mosaic)
    except (rawpy.LibRawError, OSError) as error:
        raise UserError(Fault(where, f"{path.name} is no RAW file that can be read: {error}")) from error
