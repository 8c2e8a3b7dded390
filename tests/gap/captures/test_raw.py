"""Camera RAW: the samples as the sensor gave them. The file is a DNG made here, of the fewest tags."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from tacos_framework.errors import UserError
from tacos_gap.captures.images import read_image

BYTE, ASCII, SHORT, LONG, SRATIONAL = 1, 2, 3, 4, 10
CODES = {BYTE: "B", ASCII: "c", SHORT: "H", LONG: "I", SRATIONAL: "ii"}


def dng(samples: np.ndarray) -> bytes:
    """An uncompressed 16-bit DNG of an RGGB mosaic (Adobe, Digital Negative Specification)."""
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
        count = len(values) // 2 if kind == SRATIONAL else len(values)
        value = struct.pack("<I", places[tag]) if tag in places else packed[tag].ljust(4, b"\0")
        entries += struct.pack("<HHI", tag, kind, count) + value
    body = b"".join(content + b"\0" * (len(content) % 2) for content in long_ones.values())
    head = b"II*\0" + struct.pack("<I", 8) + struct.pack("<H", len(tags)) + entries + b"\0" * 4
    return head + body + samples.astype("<u2").tobytes()


def test_raw_samples_come_as_they_are(tmp_path: Path) -> None:
    pytest.importorskip("rawpy", reason="the extra raw is not installed")
    samples = np.random.default_rng(0).integers(0, 65535, (64, 96)).astype(np.uint16)
    path = tmp_path / "photo.dng"
    path.write_bytes(dng(samples))
    np.testing.assert_array_equal(read_image(path, "captures.yaml:1:1")[..., 0], samples)


def test_a_raw_file_without_its_reader_names_the_extra(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "rawpy", None)
    (tmp_path / "photo.dng").write_bytes(b"")
    with pytest.raises(UserError, match=r"pip install 'tacos-framework\[raw\]'"):
        read_image(tmp_path / "photo.dng", "captures.yaml:1:1")
