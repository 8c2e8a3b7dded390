"""What an image file says of its size, and whether it is whole, before anything is decoded.

Decoders believe the header: a file of a megabyte may claim gigabytes, and rows that are missing become black.
Pure functions of bytes.

References
----------
PNG: ISO/IEC 15948. JPEG: ITU-T T.81, Annex B. TIFF 6.0, and BigTIFF. WebP: RFC 9649. BMP: Microsoft,
``BITMAPINFOHEADER``. PGM and PPM: Netpbm.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass


class HeaderError(ValueError):
    """A header that is broken, or a file that does not hold what its header promises."""


@dataclass(frozen=True)
class ImageHeader:
    """What a file says of the image in it.

    Parameters
    ----------
    format
        ``PNG``, ``JPEG``, ``TIFF``, ``WebP``, ``BMP`` or ``PNM``.
    width_px, height_px
        Size [px].
    sample_bytes
        Bytes of all samples of a pixel once decoded.
    """

    format: str
    width_px: int
    height_px: int
    sample_bytes: int

    @property
    def decoded_bytes(self) -> int:
        """Memory of the decoded image [bytes]."""
        return self.width_px * self.height_px * self.sample_bytes


def read_header(content: bytes) -> ImageHeader:
    """The header of an image file that is whole.

    Raises
    ------
    HeaderError
        When the format is not known, the header broken, or the file cut short; says which.
    """
    for start, reader in _READERS:
        if content.startswith(start):
            try:
                header = reader(content)
            except (struct.error, IndexError, OverflowError) as error:
                raise HeaderError(_SHORT) from error
            if header.width_px < 1 or header.height_px < 1:
                raise HeaderError(f"it says its size is {header.width_px} x {header.height_px}")
            return header
    raise HeaderError("it is empty" if not content else f"it is none of {FORMATS}")


FORMATS = "PNG, JPEG, TIFF, WebP, BMP, PGM, PPM"
_SHORT = "it breaks off in the middle"


def _png(content: bytes) -> ImageHeader:
    kind, width, height, depth, colour = struct.unpack_from(">4sIIBB", content, 12)
    channels = {0: 1, 2: 3, 3: 3, 4: 4, 6: 4}.get(colour)
    if kind != b"IHDR" or channels is None or depth not in (1, 2, 4, 8, 16):
        raise HeaderError("its header is broken")
    offset = 8
    while (kind := content[offset + 4 : offset + 8]) != b"IEND":
        (length,) = struct.unpack_from(">I", content, offset)
        if kind in (b"acTL", b"fdAT"):
            raise HeaderError("it is an animation")
        offset += 12 + length
    return ImageHeader("PNG", width, height, channels * (2 if depth == 16 else 1))


_NO_LENGTH = frozenset({0x01, 0xD8, *range(0xD0, 0xD8)})
_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_SCAN, _END = 0xDA, b"\xff\xd9"


def _jpeg(content: bytes) -> ImageHeader:
    offset, header = 2, None
    while True:
        if content[offset] != 0xFF:
            raise HeaderError("its header is broken")
        while content[offset] == 0xFF:  # markers may be filled up
            offset += 1
        marker = content[offset]
        offset += 1
        if marker in _NO_LENGTH:
            continue
        if marker == _SCAN:
            break
        (length,) = struct.unpack_from(">H", content, offset)
        if marker in _FRAMES:
            depth, height, width, channels = struct.unpack_from(">BHHB", content, offset + 2)
            if header or depth not in (8, 12) or channels not in (1, 3, 4):
                raise HeaderError("its header is broken")
            # A progressive file is decoded by way of its coefficients, of two bytes each.
            header = ImageHeader("JPEG", width, height, channels * (3 if marker in (0xC2, 0xC6) else 1))
        offset += length
    if header is None:
        raise HeaderError("its header is broken")
    if content.find(_END, offset) < 0:
        raise HeaderError(_SHORT)
    return header


_TYPE_SIZES = {1: 1, 3: 2, 4: 4, 16: 8}
_LETTERS = {1: "B", 3: "H", 4: "I", 16: "Q"}
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

    Parameters
    ----------
    directory
        Where the directory of the image begins; the first one's, when left out.
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


def _webp(content: bytes) -> ImageHeader:
    (size,) = struct.unpack_from("<I", content, 4)
    kind = content[8:16]
    if size + 8 > len(content):
        raise HeaderError(_SHORT)
    if kind == b"WEBPVP8X":
        if content[20] & 2:
            raise HeaderError("it is an animation")
        wide, high = (int.from_bytes(content[at : at + 3], "little") for at in (24, 27))
        return ImageHeader("WebP", wide + 1, high + 1, 4)
    if kind == b"WEBPVP8L":
        (packed,) = struct.unpack_from("<I", content, 21)
        return ImageHeader("WebP", (packed & 0x3FFF) + 1, (packed >> 14 & 0x3FFF) + 1, 4)
    if kind == b"WEBPVP8 ":
        wide, high = struct.unpack_from("<HH", content, 26)
        return ImageHeader("WebP", wide & 0x3FFF, high & 0x3FFF, 4)
    raise HeaderError("its header is broken")


def _bmp(content: bytes) -> ImageHeader:
    start, size, width, height, _, bits, packed = struct.unpack_from("<IIiiHHI", content, 10)
    if size < 40 or packed not in (0, 3) or bits not in (1, 4, 8, 16, 24, 32):
        raise HeaderError("its header is broken, or it is compressed")
    if start + (width * bits + 31) // 32 * 4 * abs(height) > len(content):
        raise HeaderError(_SHORT)
    return ImageHeader("BMP", width, abs(height), 4)


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
    (b"\x89PNG\r\n\x1a\n", _png),
    (b"\xff\xd8\xff", _jpeg),
    (b"II*\0", _tiff),
    (b"MM\0*", _tiff),
    (b"II+\0", _tiff),
    (b"MM\0+", _tiff),
    (b"RIFF", _webp),
    (b"BM", _bmp),
    *((b"P%d" % kind, _pnm) for kind in (2, 3, 5, 6)),
)
