"""TIFF files so described that a decoder gives their samples as stored.

OpenCV turns a file as its header asks, weighs 8-bit colours by their alpha, takes planes that lie one behind
the other for pixels, and fills packed samples up to 16 bits. None of that is what a sensor gave.

References
----------
TIFF, Revision 6.0 (1992), and BigTIFF. Tags by their numbers there; 32803 of TIFF/EP, ISO 12234-2.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from tacos_files.image_headers import HeaderError, tiff_tags

_WIDTH, _HEIGHT, _BITS, _COMPRESSION, _PHOTOMETRIC = 256, 257, 258, 259, 262
_ORIENTATION, _SAMPLES, _PLANES, _ALPHA, _FORMAT, _KIND = 274, 277, 284, 338, 339, 254
_BLOCKS = ((273, 279), (324, 325))
"""Tags of where strips, or tiles, begin, and of how many bytes they have."""

_WHITE_IS_ZERO, _BLACK_IS_ZERO, _RGB, _MOSAIC = 0, 1, 2, 32803
_FOREIGN = {4: "a mask of transparency", 5: "CMYK", 8: "CIE L*a*b*", 9: "CIE L*a*b*", 10: "CIE L*a*b*"}
_WEIGHED_ALREADY = 1
_FLOATS = 3
_REDUCED, _REDUCED_OR_MASK = 1, 1 | 4
_INNER, _DNG_VERSION = 330, 50706
_PACKED_BITS = (10, 12, 14)
_FULL_BITS = 16

_MOST_IMAGES = 1000
"""Images of a file that are counted: a file may say that each is followed by another."""

_SHORT, _LONG, _LONG8 = 3, 4, 16
_LETTERS = {_SHORT: "H", _LONG: "I", _LONG8: "Q"}


@dataclass(frozen=True)
class TiffAsStored:
    """Planes of a TIFF to decode, as they are stored."""

    planes: tuple[bytes, ...]
    """Files: the whole one, or one per plane of samples."""
    shift: int
    """Bits by which a decoder fills samples up, to be taken back."""


def tiff_as_stored(content: bytes) -> TiffAsStored:
    """Describe the first image of a TIFF file that is whole, so that it decodes as stored.

    Raises `HeaderError` when its samples are not those of a picture of one or three channels, or when it
    holds several images.
    """
    tags = dict(tiff_tags(content))

    def of(tag: int, default: int) -> int:
        return (tags.get(tag) or (default,))[0]

    if _DNG_VERSION in tags or (_INNER in tags and of(_KIND, 0) & _REDUCED):
        raise HeaderError("it is camera RAW, of which TIFF shows a preview; give it its own suffix, as .dng")
    bits, samples = of(_BITS, 1), of(_SAMPLES, 1)
    light = of(_PHOTOMETRIC, _BLACK_IS_ZERO)
    _check(bits, samples, light, is_float=of(_FORMAT, 1) == _FLOATS)
    _check_alone(content, (of(_WIDTH, 0), of(_HEIGHT, 0)))
    changes: dict[int, Sequence[int]] = {}
    if of(_ORIENTATION, 1) != 1:
        changes[_ORIENTATION] = (1,)
    if light == _MOSAIC:
        changes[_PHOTOMETRIC] = (_BLACK_IS_ZERO,)
    shift = _FULL_BITS - bits if bits in _PACKED_BITS else 0
    if of(_PLANES, 1) == 2 and samples > 1:
        planes = _planes(content, tags, samples, changes)
        return TiffAsStored(tuple(planes), shift)
    if _ALPHA in tags:
        changes[_ALPHA] = (_WEIGHED_ALREADY,) * len(tags[_ALPHA])
    return TiffAsStored((_described(content, changes) if changes else content,), shift)


def _check(bits: int, samples: int, light: int, *, is_float: bool) -> None:
    if light in _FOREIGN:
        raise HeaderError(f"its samples are {_FOREIGN[light]}, and not what a sensor gave")
    if samples not in (1, 2, 3, 4) or (samples == 2 and bits > 8):
        raise HeaderError(f"it has {samples} samples a pixel of {bits} bits, where 1 or 3 can be read")
    if is_float and bits not in (32, 64):
        raise HeaderError(f"its samples are floating-point numbers of {bits} bits, where 32 can be read")
    if light == _WHITE_IS_ZERO and bits > 8:
        raise HeaderError("its 0 is white and not black")


def _check_alone(content: bytes, size: tuple[int, int]) -> None:
    """Refuse a second image of the same size, which nobody would miss; previews and masks may follow."""
    count = 1
    seen: set[int] = set()
    offset = _next(content, _first(content))
    while offset and offset not in seen and len(seen) < _MOST_IMAGES:
        seen.add(offset)
        try:
            tags = dict(tiff_tags(content, offset))
            following = _next(content, offset)
        except (struct.error, HeaderError):  # previews that are cut off do no harm
            break
        kind = tags.get(_KIND, (0,))[0]
        same = (tags.get(_WIDTH, (0,))[0], tags.get(_HEIGHT, (0,))[0]) == size
        count += same and not kind & _REDUCED_OR_MASK
        offset = following
    if count > 1:
        raise HeaderError(f"it holds {count} images; save each as a file of its own")


def _planes(
    content: bytes, tags: Mapping[int, tuple[int, ...]], samples: int, changes: Mapping[int, Sequence[int]]
) -> Iterator[bytes]:
    """A file per plane, at most three of them: what comes behind is alpha."""
    for plane in range(1 if samples < 3 else 3):
        own: dict[int, Sequence[int]] = {
            **changes,
            _SAMPLES: (1,),
            _PLANES: (1,),
            _PHOTOMETRIC: (_BLACK_IS_ZERO,),
            _BITS: tags.get(_BITS, (1,))[:1],
            _ALPHA: (),
        }
        if _FORMAT in tags:
            own[_FORMAT] = tags[_FORMAT][:1]
        for pair in _BLOCKS:
            for tag in pair:
                if tag in tags:
                    count = len(tags[tag]) // samples
                    own[tag] = tags[tag][plane * count : (plane + 1) * count]
        yield _described(content, own)


# directories ----------------------------------------------------------------------------------------------


def _form(content: bytes) -> tuple[str, str, str, int]:
    """Byte order, letters of a count of entries and of an offset, and where the first offset stands."""
    order = "<" if content[:2] == b"II" else ">"
    return (order, "Q", "Q", 8) if content[2:4] in (b"+\0", b"\0+") else (order, "H", "I", 4)


def _first(content: bytes) -> int:
    order, _, letter, at = _form(content)
    return int(struct.unpack_from(order + letter, content, at)[0])


def _entries(content: bytes, offset: int) -> tuple[dict[int, bytes], int]:
    """Entries of a directory as they are, by tag, and where it ends."""
    order, counted, letter, _ = _form(content)
    (count,) = struct.unpack_from(order + counted, content, offset)
    start, size = offset + struct.calcsize(order + counted), 4 + 2 * struct.calcsize(order + letter)
    found: dict[int, bytes] = {}
    for at in range(start, start + count * size, size):
        entry = content[at : at + size]
        found.setdefault(struct.unpack_from(order + "H", entry)[0], entry)
    return found, start + count * size


def _next(content: bytes, offset: int) -> int:
    """Offset of the next directory; 0 behind the last, and where the file ends before it says."""
    order, _, letter, _ = _form(content)
    _, end = _entries(content, offset)
    if end + struct.calcsize(order + letter) > len(content):
        return 0
    return int(struct.unpack_from(order + letter, content, end)[0])


def _described(content: bytes, changes: Mapping[int, Sequence[int]]) -> bytes:
    """The file with another directory behind it: whole numbers by tag instead of its own, none for none."""
    order, counted, letter, at = _form(content)
    field = struct.calcsize(order + letter)
    entries, _ = _entries(content, _first(content))
    tail = bytearray(len(content) % 2)
    for tag, values in changes.items():
        entries.pop(tag, None)
        if not values:
            continue
        kind = _SHORT if max(values) < 1 << 16 else _LONG if max(values) < 1 << 32 else _LONG8
        packed = struct.pack(f"{order}{len(values)}{_LETTERS[kind]}", *values)
        if len(packed) > field:
            place = len(content) + len(tail)
            tail += packed + bytes(len(packed) % 2)
            packed = struct.pack(order + letter, place)
        entries[tag] = struct.pack(f"{order}HH{letter}", tag, kind, len(values)) + packed.ljust(field, b"\0")
    begin = struct.pack(order + letter, len(content) + len(tail))
    directory = struct.pack(order + counted, len(entries)) + b"".join(entries[tag] for tag in sorted(entries))
    return b"".join((content[:at], begin, content[at + field :], tail, directory, bytes(field)))
