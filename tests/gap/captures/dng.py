"""A camera RAW file of the fewest tags."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Any

import numpy as np

BYTE, ASCII, SHORT, LONG, RATIONAL, SRATIONAL = 1, 2, 3, 4, 5, 10
CODES = {BYTE: "B", ASCII: "c", SHORT: "H", LONG: "I", RATIONAL: "II", SRATIONAL: "ii"}


def dng(samples: np.ndarray, more: Mapping[int, tuple[int, Any]] | None = None) -> bytes:
    """An uncompressed 16-bit DNG of an RGGB mosaic (Adobe, Digital Negative Specification).

    `samples`: (H, W) its samples. `more`: tags beside its own, or in their place: type and values.
    """
    height, width = samples.shape
    matrix = [value for row in np.eye(3, dtype=int).tolist() for one in row for value in (one, 1)]
    tags = {
        254: (LONG, [0]),
        256: (LONG, [width]),
        257: (LONG, [height]),
        258: (SHORT, [16]),
        259: (SHORT, [1]),
        262: (SHORT, [32803]),
        271: (ASCII, b"Test\0"),
        272: (ASCII, b"Test\0"),
        273: (LONG, [0]),
        274: (SHORT, [1]),
        277: (SHORT, [1]),
        278: (LONG, [height]),
        279: (LONG, [samples.nbytes]),
        284: (SHORT, [1]),
        33421: (SHORT, [2, 2]),
        33422: (BYTE, [0, 1, 1, 2]),
        50706: (BYTE, [1, 4, 0, 0]),
        50708: (ASCII, b"Test\0"),
        50717: (LONG, [65535]),
        50721: (SRATIONAL, matrix),
    }
    tags = dict(sorted({**tags, **(more or {})}.items()))
    begin = 8 + 2 + 12 * len(tags) + 4
    packed = {
        tag: bytes(values)
        if kind == ASCII
        else struct.pack("<" + "".join(CODES[kind][0] * len(values)), *values)
        for tag, (kind, values) in tags.items()
    }
    long_ones = {tag: content for tag, content in packed.items() if len(content) > 4}
    places, end = {}, begin
    for tag, content in long_ones.items():
        places[tag], end = end, end + len(content) + len(content) % 2
    packed[273] = struct.pack("<I", end)
    entries = b""
    for tag, (kind, values) in tags.items():
        count = len(values) // 2 if kind in (RATIONAL, SRATIONAL) else len(values)
        value = struct.pack("<I", places[tag]) if tag in places else packed[tag].ljust(4, b"\0")
        entries += struct.pack("<HHI", tag, kind, count) + value
    body = b"".join(content + b"\0" * (len(content) % 2) for content in long_ones.values())
    head = b"II*\0" + struct.pack("<I", 8) + struct.pack("<H", len(tags)) + entries + b"\0" * 4
    return head + body + samples.astype("<u2").tobytes()
