"""Image files of cameras: PNG, TIFF and others OpenCV reads, NumPy arrays, camera RAW."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_files.arrays import read_npy
from tacos_files.image_headers import FORMATS
from tacos_files.images import decode_samples
from tacos_framework import Fault, UserError
from tacos_framework.files import limits, read_bytes, too_large

_LARGEST_DN = 1e9
"""Beyond any file or expectation; what is larger overflows somewhere, not here."""

_MOST_DN = 65535
_ONE_VALUE = 0.99

_RAW_BYTES = 2
"""Bytes of a sample of a mosaic, as LibRaw unpacks it."""

RAW_SUFFIXES = frozenset(
    {".dng", ".cr2", ".cr3", ".nef", ".nrw", ".arw", ".raf", ".rw2", ".rwl", ".orf", ".pef", ".srw", ".3fr"}
)
_HEIF_SUFFIXES = frozenset({".heic", ".heif", ".hif", ".avif"})
_HEIF = frozenset(
    b"ftyp" + brand
    for brand in (b"heic", b"heix", b"heim", b"heis", b"hevc", b"mif1", b"msf1", b"avif", b"avis")
)
"""What stands in such a file from its fifth byte on, whatever it is called."""

_NO_HEIF = (
    "Let the camera save RAW or JPEG files (iPhone: Settings, Camera, Formats, Most Compatible), or convert "
    "what is there to PNG or TIFF."
)
"""Its readers turn pictures, and nothing here knows how its codec loses detail: no extra reads it."""

LOSSY_SUFFIXES = _HEIF_SUFFIXES | {".jpg", ".jpeg", ".jfif", ".mpo", ".webp"}

PICTURE_SUFFIXES = (
    RAW_SUFFIXES | LOSSY_SUFFIXES | {*(".png", ".tif", ".tiff", ".bmp", ".pgm", ".ppm", ".npy")}
)
"""Of photographs, as the import looks for them."""

_LOSSY = {b"\xff\xd8\xff": "JPEG", b"RIFF": "WebP"}
"""First bytes of files whose coding changes noise, and the names of the codings."""

_LOSSY_REMEDY = "Have the camera save raw frames: PNG, TIFF, npy, PGM or its RAW format."


def usual_bit_depth(largest_dn: int) -> int:
    """The smallest bit depth of cameras that holds a sample.

    >>> usual_bit_depth(4094)
    12
    """
    return next((bits for bits in (8, 10, 12, 14) if largest_dn < 1 << bits), 16)


def has_one_value(image: NDArray[Any]) -> bool:
    """True if all but 1 % of the samples are equal, as in frames without light or clipped throughout: two of
    them may be equal without being copies."""
    return bool(np.mean(image == np.median(image)) > _ONE_VALUE)


def roughness(image: NDArray[np.integer]) -> float:
    """Mean difference of pixels two columns apart, as the photosites of one colour are, over the mean.

    Of an image (H, W) whose samples have their two bytes exchanged it is that of random numbers.
    """
    exact = image.astype(np.float64)
    return float(np.abs(exact[:, 2:] - exact[:, :-2]).mean() / max(exact.mean(), 1e-9))


def read_frame(path: Path, where: str, within: Path | None = None) -> NDArray[Any]:
    """A frame in the digital numbers of a camera: (H, W, C) uint8 or uint16 in this machine's byte order.

    Parameters are those of `read_image`. Whole numbers of other types are taken where 16 bits hold them.

    Raises `UserError` as for `read_image`, and for files whose coding changes noise, or that hold other
    numbers.
    """
    image = read_image(path, where, within, lossless=True)
    if image.dtype == np.uint8:
        return image
    if image.dtype.kind not in "iuf" or (image != np.rint(image)).any():
        raise UserError(
            Fault(
                where,
                f"{path.name} holds numbers that are not whole ({image.dtype})",
                "whole digital numbers from 0 to 65535",
                "Save digital numbers as the camera gave them, not averaged or scaled.",
            )
        )
    if image.min() < 0 or image.max() > _MOST_DN:
        raise UserError(
            Fault(
                where,
                f"{path.name} holds numbers from {image.min():g} to {image.max():g}",
                "whole digital numbers from 0 to 65535",
                "Save digital numbers as the camera gave them.",
            )
        )
    return image.astype(np.uint16)


def read_image(path: Path, where: str, within: Path | None = None, *, lossless: bool = False) -> NDArray[Any]:
    """An image as stored: (H, W, C) with C = 1 or 3 in the order R, G, B.

    - `path`: ``.npy``, a camera's RAW file (needs rawpy), PNG, TIFF, JPEG, WebP, BMP, PGM or PPM.
    - `where`: what names the file, for messages.
    - `within`: the folder it must lie in, links followed; None for any.
    - `lossless`: refuse JPEG and WebP, for what is measured of noise.

    Raises `UserError` when it is not there, cannot be read, or holds what is no image.
    """
    if path.suffix.lower() == ".npy":
        image = read_array(path, where, within)
    elif path.suffix.lower() in RAW_SUFFIXES:
        image = _read_raw(path, where, within)
    else:
        content = read_bytes(path, "image_mb", where=where, within=within)
        if content[4:12] in _HEIF:
            raise UserError(
                Fault(where, f"{path.name} is HEIF or AVIF, which cannot be read", FORMATS, _NO_HEIF)
            )
        coding = next((name for start, name in _LOSSY.items() if content.startswith(start)), None)
        if lossless and coding:
            what = f"{path.name} is {coding}, whose coding smooths noise and follows a tone curve"
            raise UserError(Fault(where, what, "frames as the sensor gave them", _LOSSY_REMEDY))
        image = decode_samples(content, where, path.name)
    if image.ndim == 2:
        image = image[..., None]
    if not image.size or image.ndim != 3 or image.shape[2] not in (1, 3):
        raise UserError(
            Fault(where, f"{path.name} has the shape {image.shape}", "(height, width) or (height, width, 3)")
        )
    if image.dtype.kind == "f" and not np.isfinite(image).all():
        raise UserError(Fault(where, f"{path.name} holds NaN or infinite values", "finite numbers"))
    if image.itemsize > 2 and max(abs(float(image.min())), abs(float(image.max()))) > _LARGEST_DN:
        raise UserError(Fault(where, f"{path.name} holds values beyond {_LARGEST_DN:g}", "digital numbers"))
    return image


def read_array(path: Path, where: str, within: Path | None = None) -> NDArray[Any]:
    """An array of numbers from ``.npy``; never one that runs code. Parameters are those of `read_image`."""
    array = read_npy(path, where=where, within=within)
    return array.astype(np.uint8) if array.dtype == np.bool_ else array


@contextmanager
def opened_raw(path: Path, where: str, within: Path | None = None) -> Iterator[Any]:
    """A camera's RAW file as rawpy has it, its size known; it may be read inside alone.

    Raises `UserError` when rawpy is not installed, or the file is too large, or LibRaw cannot read it, now or
    inside.
    """
    try:
        import rawpy
    except ImportError:
        raise UserError(
            Fault(where, f"{path.name} is a RAW file", "", "pip install 'tacos-framework[raw]'")
        ) from None
    content = read_bytes(path, "image_mb", where=where, within=within)
    try:
        with rawpy.imread(BytesIO(content)) as raw:
            size_bytes = raw.sizes.raw_width * raw.sizes.raw_height * _RAW_BYTES
            if size_bytes > limits().bytes_of("image_mb"):
                raise UserError(too_large(where, f"the mosaic of {path.name}", size_bytes, "image_mb"))
            yield raw
    except (rawpy.LibRawError, OSError) as error:
        reason = error.args[0].decode() if error.args and isinstance(error.args[0], bytes) else error
        what = f"{path.name} is no RAW file that can be read: {reason}"
        raise UserError(Fault(where, what, "camera RAW", "Copy it anew, or convert it to DNG.")) from error


def check_bit_depth(image: NDArray[Any], bit_depth: int, where: str, name: str) -> None:
    """Raise `UserError` where a file of 8 bits is said to hold samples of more."""
    if image.dtype == np.uint8 and bit_depth > 8:
        what = f"{name} has 8 bits, and bit_depth says {bit_depth}"
        remedy = f"Save frames with 16 bits, as the camera gave all {bit_depth}, or set bit_depth: 8."
        raise UserError(Fault(where, what, f"{bit_depth}-bit samples in files of 16 bits", remedy))


def _read_raw(path: Path, where: str, within: Path | None) -> NDArray[Any]:
    with opened_raw(path, where, within) as raw:
        mosaic = raw.raw_image_visible
        if mosaic is None:  # RGB in a RAW container
            raise UserError(Fault(where, f"{path.name} holds no mosaic", "samples of single pixels"))
        return level_blacks(
            np.array(mosaic), raw.raw_colors_visible, raw.black_level_per_channel, raw.white_level
        )


def black_of_raw(blacks_dn: Sequence[float]) -> int:
    """The black level of all samples of a RAW file once read: the mean of its channels' [DN]."""
    return round(sum(blacks_dn) / len(blacks_dn))


def level_blacks(
    mosaic: NDArray[Any], channel: NDArray[np.uint8], blacks_dn: Sequence[float], white_dn: float
) -> NDArray[Any]:
    """A mosaic whose channels are moved to one black level; saturated samples stay as they are.

    `channel`: (H, W) index of each sample into `blacks_dn`.
    """
    away = black_of_raw(blacks_dn) - np.rint(blacks_dn).astype(np.int64)
    if not away.any():
        return mosaic
    moved = np.clip(mosaic + away[channel], 0, _MOST_DN).astype(mosaic.dtype)
    return np.where(mosaic >= white_dn, mosaic, moved)
