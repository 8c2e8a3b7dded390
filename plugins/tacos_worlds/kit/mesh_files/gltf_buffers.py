"""The binary side of glTF 2.0: containers, buffers and accessors.

Sizes are checked against what is there before anything is allocated, and no file outside the model's folder
is opened.

Source: Khronos Group, glTF 2.0 specification, sections 3.6 (binary data storage) and 4 (GLB).
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import UserError
from tacos_framework.files import limits, parse_json, too_large
from tacos_worlds.kit.mesh_files.damage import Damaged
from tacos_worlds.kit.mesh_files.packed import MESHOPT, meshopt_view
from tacos_worlds.kit.mesh_files.references import References

Json = dict[str, Any]

_GLB_MAGIC, _JSON_CHUNK, _BINARY_CHUNK = 0x46546C67, 0x4E4F534A, 0x004E4942
_DTYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Buffers:
    """The header of a glTF file, and its numbers.

    - `header`: the JSON object.

    Raises Damaged where the container is not glTF 2.0. Raises UserError where its JSON is too large, or none.
    """

    def __init__(self, content: bytes, references: References) -> None:
        self.references, self._size = references, len(content)
        text, self._embedded = _container(content)
        if len(text) > limits().bytes_of("json_mb"):
            raise UserError(too_large(references.where, "its JSON", len(text), "json_mb"))
        if not content or content.lstrip()[:1] == b"<":
            raise Damaged(f"it is {'a web page, as a download that failed' if content else 'empty'}")
        header = parse_json(text.decode("utf-8-sig"), references.where, "glTF", "Export the model again.")
        asset = header.get("asset") if isinstance(header, dict) else None
        if not isinstance(asset, dict) or not str(asset.get("version", "")).startswith("2"):
            raise Damaged("it is not glTF 2.0: asset.version is missing or another")
        self.header: Json = header
        self._checked: dict[str, list[Json]] = {}
        self._buffers: dict[int, memoryview] = {}
        self._unpacked: dict[str, memoryview] = {}

    def listed(self, name: str) -> list[Json]:
        if name not in self._checked:  # once, as large buildings have lists of 10^5 entries
            entries = self.header.get(name, [])
            if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
                raise Damaged(f"{name} is not a list of objects")
            self._checked[name] = entries
        return self._checked[name]

    def entry(self, name: str, index: object) -> Json:
        entries = self.listed(name)
        if not isinstance(index, int) or not 0 <= index < len(entries):
            raise Damaged(f"{name}[{index!r}] does not exist, there are {len(entries)}")
        return entries[index]

    def view(self, index: object) -> memoryview:
        entry, where = self.entry("bufferViews", index), f"bufferViews[{index}]"
        extension = next((name for name in MESHOPT if name in entry.get("extensions", {})), None)
        if extension is None or self._has_plain(entry.get("buffer"), extension):
            return _cut(self._buffer(entry.get("buffer")), entry, where)
        if where not in self._unpacked:
            packed = entry["extensions"][extension]
            content = bytes(_cut(self._buffer(packed.get("buffer")), packed, where))
            self._unpacked[where] = meshopt_view(content, packed, extension, self.references.where)
        return self._unpacked[where]

    def _has_plain(self, buffer: object, extension: str) -> bool:
        """True if a buffer has data for readers that do not unpack."""
        entry = self.entry("buffers", buffer)
        stands_in = entry.get("extensions", {}).get(extension, {}).get("fallback", False)
        return not stands_in and ("uri" in entry or (buffer == 0 and self._embedded is not None))

    def image(self, index: object) -> bytes:
        entry = self.entry("images", index)
        return self._at(entry) if "uri" in entry else bytes(self.view(entry.get("bufferView")))

    def has_data(self, index: object) -> bool:
        """True if an accessor has bytes of its own."""
        return "bufferView" in self.entry("accessors", index)

    def count(self, index: object) -> int:
        """How many items an accessor has, as it says, before any is read."""
        return _natural(self.entry("accessors", index).get("count"), f"accessors[{index}].count")

    def accessor(self, index: object) -> NDArray[Any]:
        """(N, width) numbers, normalised integers as floats in -1..1 or 0..1."""
        entry = self.entry("accessors", index)
        where, count = f"accessors[{index}]", self.count(index)
        dtype, width = self._layout(entry, where)
        if "bufferView" in entry:
            values = self._strided(entry, where, count, dtype, width)
        else:
            values = np.zeros((_held(count, self._size), width), dtype)
        if isinstance(sparse := entry.get("sparse"), dict):
            values = self._replaced(values, sparse, where, dtype, width)
        if entry.get("normalized") and dtype.kind in "iu":
            return np.maximum(values / float(np.iinfo(dtype).max), -1.0)
        return values

    def _layout(self, entry: Json, where: str) -> tuple[np.dtype[Any], int]:
        try:
            return np.dtype(_DTYPES[entry["componentType"]]).newbyteorder("<"), _WIDTHS[entry["type"]]
        except (KeyError, TypeError) as error:
            raise Damaged(f"{where} has an unknown componentType or type") from error

    def _strided(self, entry: Json, where: str, count: int, dtype: np.dtype[Any], width: int) -> NDArray[Any]:
        data = self.view(entry["bufferView"])
        offset = _natural(entry.get("byteOffset", 0), f"{where}.byteOffset")
        item = dtype.itemsize * width
        stride = self.entry("bufferViews", entry["bufferView"]).get("byteStride") or item
        stride = _natural(stride, f"{where}.byteStride")
        if count and offset + (count - 1) * stride + item > len(data):
            raise Damaged(f"{where} claims {count} items, beyond the {len(data)} bytes of its view")
        array: NDArray[Any] = np.ndarray((count, width), dtype, data, offset, (stride, dtype.itemsize))
        return array.copy()

    def _replaced(
        self, values: NDArray[Any], sparse: Json, where: str, dtype: np.dtype[Any], width: int
    ) -> NDArray[Any]:
        """Values with those of a sparse accessor put in."""
        count = _natural(sparse.get("count"), f"{where}.sparse.count")
        indices, others = sparse.get("indices", {}), sparse.get("values", {})
        index_type, _ = self._layout({"type": "SCALAR", **indices}, f"{where}.sparse.indices")
        rows = self._strided(indices, f"{where}.sparse.indices", count, index_type, 1)[:, 0]
        if len(rows) and int(rows.max()) >= len(values):
            raise Damaged(f"{where}.sparse names item {int(rows.max())} of {len(values)}")
        values[rows] = self._strided(others, f"{where}.sparse.values", count, dtype, width)
        return values

    def _buffer(self, index: object) -> memoryview:
        entry = self.entry("buffers", index)
        assert isinstance(index, int)
        if index not in self._buffers:
            if "uri" in entry:
                data = self._at(entry)
            elif self._embedded is None or index:
                raise Damaged(f"buffers[{index}] has no data")
            else:
                data = self._embedded
            length = _natural(entry.get("byteLength"), f"buffers[{index}].byteLength")
            if length > len(data):
                raise Damaged(f"buffers[{index}] is cut short: {len(data)} of {length} bytes are there")
            self._buffers[index] = memoryview(data)[:length]
        return self._buffers[index]

    def _at(self, entry: Json) -> bytes:
        return self.references.bytes_of(str(entry["uri"]), quoted=True)


def _container(data: bytes) -> tuple[bytes, bytes | None]:
    """The JSON and the binary chunk of a GLB; all of a .gltf is JSON."""
    if data[:4] != struct.pack("<I", _GLB_MAGIC):
        return data, None
    if len(data) < 20:
        raise Damaged("it ends within its header")
    version, total = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise Damaged(f"it is glTF {version}.0, not glTF 2.0")
    if total > len(data):
        raise Damaged(f"it is cut short: {len(data)} of {total} bytes are there")
    chunks: dict[int, bytes] = {}
    at = 12
    while at + 8 <= total:
        length, kind = struct.unpack_from("<II", data, at)
        if at + 8 + length > total:
            raise Damaged("a chunk reaches beyond its end")
        chunks.setdefault(kind, data[at + 8 : at + 8 + length])
        at += 8 + length
    if _JSON_CHUNK not in chunks:
        raise Damaged("it has no JSON chunk")
    return chunks[_JSON_CHUNK], chunks.get(_BINARY_CHUNK)


def _cut(buffer: memoryview, entry: Json, where: str) -> memoryview:
    offset = _natural(entry.get("byteOffset", 0), f"{where}.byteOffset")
    length = _natural(entry.get("byteLength"), f"{where}.byteLength")
    if offset + length > len(buffer):
        raise Damaged(f"{where} reaches beyond its buffer")
    return buffer[offset : offset + length]


def _natural(value: object, where: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise Damaged(f"{where} is {value!r}, not a number of 0 or more")
    return value


def _held(count: int, size_bytes: int) -> int:
    """A count of zeros that no bytes stand behind, kept to what a file of its size might mean."""
    if count > max(size_bytes, 1 << 20):
        raise Damaged(f"an accessor without data claims {count} items")
    return count
