"""Size and completeness of an image file, before anything is decoded.

Decoders believe the header: a file of a megabyte may claim gigabytes, and rows that are missing become black.
Pure functions of bytes.

References
----------
TIFF 6.0, and BigTIFF. PGM and PPM: Netpbm.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from io import BytesIO
from typing import Any

UNREADABLE = (
    OSError,
    SyntaxError,
    ValueError,
    EOFError,
    LookupError,
    TypeError,
    OverflowError,
    struct.error,
)
"""What Pillow's readers raise on files that are damaged, `PIL.UnidentifiedImageError` among them."""


class HeaderError(ValueError):
    """A header that is broken, or a file that does not hold what its header promises."""


class OtherFormat(HeaderError):
    """Content of another format than those that are read."""


@dataclass(frozen=True)
class ImageHeader:
    """Size, depth and channels of an image, by its header."""

    format: str
    """``PNG``, ``JPEG``, ``TIFF``, ``WebP``, ``BMP``, ``PNM``, ``DDS``, ``GIF`` or ``TGA``."""
    width_px: int
    height_px: int
    """Size [px]."""
    sample_bytes: int
    """Bytes of all samples of a pixel once decoded."""

    @property
    def decoded_bytes(self) -> int:
        """Memory of the decoded image [bytes]."""
        return self.width_px * self.height_px * self.sample_bytes


def read_header(content: bytes, *, of_texture: bool = False) -> ImageHeader:
    """The header of an image file that is whole.

    `of_texture`: true if the formats that programs of models write count, too.

    Raises `HeaderError` when the format is not known, the header broken, or the file cut short; says which.
    """
    for start, reader in _READERS + (_OF_TEXTURES if of_texture else ()):
        if content.startswith(start):
            try:
                header = reader(content)
            except (struct.error, IndexError, OverflowError) as error:
                raise HeaderError(_SHORT) from error
            if header.width_px < 1 or header.height_px < 1:
                raise HeaderError(f"it says its size is {header.width_px} x {header.height_px}")
            return header
    formats = TEXTURE_FORMATS if of_texture else FORMATS
    if not content:
        raise HeaderError("it is empty")
    known = named_format(content)
    raise OtherFormat(f"it is {known}, none of {formats}" if known else f"it is none of {formats}")


_OTHERS = {
    b"PK\x03\x04": "a ZIP archive",
    b"\x1f\x8b": "a file packed by gzip",
    b"v/1\x01": "OpenEXR",
    b"SIMPLE  =": "FITS",
}
"""First bytes of formats that are taken for others, as npz is for npy, and their names."""


def named_format(content: bytes) -> str:
    """The name of a format of archives or images that is read nowhere here; empty for others."""
    return next((name for start, name in _OTHERS.items() if content.startswith(start)), "")


FORMATS = "PNG, JPEG, TIFF, WebP, BMP, PGM, PPM"
TEXTURE_FORMATS = f"{FORMATS}, TGA, DDS, GIF"
_SHORT = "it breaks off in the middle"


def _by_pillow(content: bytes) -> ImageHeader:
    """The header of any format but TIFF and PNM, whose depth Pillow does not tell."""
    from PIL.BmpImagePlugin import BmpImageFile
    from PIL.DdsImagePlugin import DdsImageFile
    from PIL.GifImagePlugin import GifImageFile
    from PIL.ImageFile import ImageFile
    from PIL.JpegImagePlugin import JpegImageFile
    from PIL.PngImagePlugin import PngImageFile
    from PIL.TgaImagePlugin import TgaImageFile
    from PIL.WebPImagePlugin import WebPImageFile

    # Not by `Image.open`, which has a limit of its own and takes a photograph of several for MPO.
    kinds: dict[bytes, Callable[[BytesIO], ImageFile]] = {
        b"\x89P": PngImageFile,
        b"\xff\xd8": JpegImageFile,
        b"RI": WebPImageFile,
        b"BM": BmpImageFile,
        b"DD": DdsImageFile,
        b"GI": GifImageFile,
    }
    if content[:4] == b"RIFF" and int.from_bytes(content[4:8], "little") + 8 > len(content):
        raise HeaderError(_SHORT)
    try:
        image = kinds.get(content[:2], TgaImageFile)(BytesIO(content))
    except UNREADABLE as error:
        raise HeaderError(f"its header is broken: {error}") from error
    if getattr(image, "is_animated", False):
        raise HeaderError("it is an animation")
    name = str(image.format)
    if content.rfind(_ENDS.get(name, b"")) < 0 or _end_of_rows(image) > len(content):
        raise HeaderError(_SHORT)
    # OpenCV makes colours of palettes, and colours and alpha of greys with alpha.
    channels = 4 if name == "BMP" or image.mode in ("P", "LA") else len(image.getbands())
    depth = 2 if ";16" in str(image.tile) else 1
    # A progressive JPEG is decoded by way of its coefficients, of two bytes each.
    work = 3 if name == "JPEG" and "progressive" in image.info else 1
    return ImageHeader(name, *image.size, channels * depth * work)


def _end_of_rows(image: Any) -> int:
    """End of the rows of a BMP that is not packed; 0 for others."""
    rows = [(start, args[1]) for kind, _, start, args in image.tile if kind == "raw"]
    return max((start + stride * image.height for start, stride in rows), default=0)


_ENDS = {"PNG": b"IEND", "JPEG": b"\xff\xd9"}
"""What stands at the end of a whole file; decoders refuse others that are cut short."""


_TYPE_SIZES = {1: 1, 3: 2, 4: 4, 13: 4, 16: 8}
_LETTERS = {1: "B", 3: "H", 4: "I", 13: "I", 16: "Q"}
_MOST_STRIPS = 1_000_000


def _tiff(content: bytes) -> ImageHeader:
    tags = dict(tiff_tags(content))

    def largest(tag: int, default: int) -> int:
        return max(tags.get(tag) or (default,))

    width, height = largest(256, 0), largest(257, 0)
    bits, channels = largest(258, 1), largest(277, 1)
    if bits > 64 or channels > 16:
        raise HeaderError("its header is broken")
    sample_bytes = max(channels, 3 if largest(262, 1) in (3, 6) else 1) * max(1, -(-bits // 8))
    for starts, sizes in ((273, 279), (324, 325)):
        for start, size in zip(tags.get(starts, ()), tags.get(sizes, ()), strict=False):
            if start + size > len(content):
                raise HeaderError(_SHORT)
    if 273 not in tags and 324 not in tags:
        raise HeaderError("it holds no samples")
    rows = min(largest(278, height), height)
    tile = largest(322, width) * largest(323, rows)  # decoded one by one, into memory of this size
    if tile > width * height + 4096 * 4096:
        raise HeaderError("its tiles are larger than the image")
    return ImageHeader("TIFF", width, height, sample_bytes)


def tiff_tags(content: bytes, directory: int | None = None) -> Iterator[tuple[int, tuple[int, ...]]]:
    """Whole numbers by tag, of an image of a TIFF file; a tag that comes twice has all its values.

    `directory`: where the directory of the image begins; the first one's, when left out.
    """
    order = "<" if content[:2] == b"II" else ">"
    (version,) = struct.unpack_from(order + "H", content, 2)
    if version == 42:
        offset = struct.unpack_from(order + "I", content, 4)[0] if directory is None else directory
        (count,) = struct.unpack_from(order + "H", content, offset)
        start, entry, letter = offset + 2, "HHI", "I"
    elif version == 43:
        offset = struct.unpack_from(order + "Q", content, 8)[0] if directory is None else directory
        (count,) = struct.unpack_from(order + "Q", content, offset)
        start, entry, letter = offset + 8, "HHQ", "Q"
    else:
        raise HeaderError("its header is broken")
    head, inline = struct.calcsize(order + entry), struct.calcsize(order + letter)
    if start + count * (head + inline) > len(content):
        raise HeaderError(_SHORT)
    found: dict[int, tuple[int, ...]] = {}
    for position in range(start, start + count * (head + inline), head + inline):
        tag, kind, number = struct.unpack_from(order + entry, content, position)
        if kind not in _TYPE_SIZES:
            continue
        if number > _MOST_STRIPS:
            raise HeaderError("its header is broken")
        at = position + head
        if number * _TYPE_SIZES[kind] > inline:
            (at,) = struct.unpack_from(order + letter, content, at)
        found[tag] = found.get(tag, ()) + struct.unpack_from(f"{order}{number}{_LETTERS[kind]}", content, at)
    yield from found.items()


_PNM = re.compile(
    rb"P([2356])(?:\s+(?:#[^\n]*\n\s*)*)(\d{1,9})(?:\s+(?:#[^\n]*\n\s*)*)(\d{1,9})(?:\s+(?:#[^\n]*\n\s*)*)(\d{1,5})\s"
)


def _pnm(content: bytes) -> ImageHeader:
    found = _PNM.match(content[:4096])
    if not found:
        raise HeaderError("its header is broken")
    kind, width, height, white = (int(group) for group in found.groups())
    channels, depth = 3 if kind in (3, 6) else 1, 2 if white > 255 else 1
    # As text, a sample takes a digit and a blank at least.
    least = width * height * channels * (2 if kind < 4 else depth) - (kind < 4)
    if not 0 < white < 65536 or found.end() + least > len(content):
        raise HeaderError(_SHORT if white else "its header is broken")
    return ImageHeader("PNM", width, height, channels * depth)


_READERS: tuple[tuple[bytes, Callable[[bytes], ImageHeader]], ...] = (
    (b"\x89PNG\r\n\x1a\n", _by_pillow),
    (b"\xff\xd8\xff", _by_pillow),
    (b"II*\0", _tiff),
    (b"MM\0*", _tiff),
    (b"II+\0", _tiff),
    (b"MM\0+", _tiff),
    (b"RIFF", _by_pillow),
    (b"BM", _by_pillow),
    *((b"P%d" % kind, _pnm) for kind in (2, 3, 5, 6)),
)
_OF_TEXTURES: tuple[tuple[bytes, Callable[[bytes], ImageHeader]], ...] = (
    (b"DDS ", _by_pillow),
    (b"GIF8", _by_pillow),
    *((bytes((0, 0, kind)), _by_pillow) for kind in (2, 3, 10, 11)),  # TGA, which begins without a name
    *((bytes((0, 1, kind)), _by_pillow) for kind in (1, 9)),
)
