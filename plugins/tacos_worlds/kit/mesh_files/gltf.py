"""Whether a glTF file holds what it promises.

References
----------
glTF 2.0: https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

from pydantic import ValidationError

from tacos_framework import Fault, UserError
from tacos_framework.files import limits, parse_json, too_large
from tacos_worlds.kit.mesh_files.gltf_shapes import TRIANGLES, GltfFile, GltfPrimitive
from tacos_worlds.kit.mesh_files.references import References

_MAGIC, _JSON, _BINARY = b"glTF", b"JSON", b"BIN\0"
_HEAD, _CHUNK_HEAD = 12, 8
_STRIP, _FAN = 5, 6
_COMPRESSED = (
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "KHR_texture_basisu",
)
_DEEPEST = 500
"""Nodes below one another; what is placed is multiplied along the way."""
_SHOWN = 5


def glb_chunks(content: bytes, where: str) -> tuple[bytes, bytes | None]:
    """The JSON and the binary part, if there is one, of a binary glTF file.

    Raises
    ------
    UserError
        When it is none, or cut short.
    """
    try:
        magic, version, whole = struct.unpack_from("<4sII", content)
        if magic != _MAGIC or version != 2:
            raise ValueError("it is not a binary glTF file of version 2")
        if whole != len(content):
            raise ValueError(f"it should be {whole} bytes long and is {len(content)}")
        chunks: dict[bytes, bytes] = {}
        offset = _HEAD
        while offset < whole:
            length, kind = struct.unpack_from("<I4s", content, offset)
            offset += _CHUNK_HEAD
            if offset + length > whole or (not chunks and kind != _JSON):
                raise ValueError("its parts are longer than itself, or do not begin with JSON")
            chunks.setdefault(kind, content[offset : offset + length])
            offset += length
        return chunks[_JSON], chunks.get(_BINARY)
    except (ValueError, KeyError, struct.error) as error:
        raise _unreadable(where, str(error)) from error


def parse_tree(text: bytes, where: str) -> dict[str, Any]:
    """The JSON of a glTF file.

    Raises
    ------
    UserError
        When it is no JSON object, or too large.
    """
    if len(text) > limits().bytes_of("json_mb"):
        raise UserError(too_large(where, "its JSON", len(text), "json_mb"))
    try:
        tree = parse_json(text.decode("utf-8"), where, "glTF", "Export the model again.")
    except UnicodeDecodeError as error:
        raise _unreadable(where, str(error)) from error
    if not isinstance(tree, dict):
        raise _unreadable(where, "its JSON is not an object")
    return tree


def check_gltf(tree: dict[str, Any], binary: bytes | None, references: References, where: str) -> int:
    """Triangles of the scene of a glTF file, once it is certain that it holds what it promises.

    Parameters
    ----------
    tree, binary
        Its JSON, and the binary part of a GLB file.
    references
        Where files it names are read through; what is wrong with them is kept there.

    Raises
    ------
    UserError
        With what is wrong with its structure.
    """
    try:
        file = GltfFile.model_validate(tree)
    except ValidationError as error:
        found = error.errors(include_url=False, include_input=False)
        raise UserError(
            [
                Fault(where, f"its JSON is no glTF at {'.'.join(map(str, each['loc']))}: {each['msg']}")
                for each in found[:_SHOWN]
            ]
        ) from error
    if compressed := sorted(set(file.extensionsRequired) & set(_COMPRESSED)):
        remedy = "Export the model again without compression."
        raise UserError(Fault(where, f"needs {', '.join(compressed)}", "a model that is not packed", remedy))
    try:
        buffers = _buffers(file, binary, references)
        _check_views(file, [len(buffer) for buffer in buffers], where)
        _check_pictures(file, buffers, references)
        return _triangles(file)
    except UserError as error:
        references.faults.extend(error.faults)
        return 0
    except (ValueError, LookupError) as error:
        reason = "it names an entry that is not there" if isinstance(error, LookupError) else str(error)
        raise _unreadable(where, reason) from error


def _buffers(file: GltfFile, binary: bytes | None, references: References) -> list[bytes]:
    buffers = []
    for i, buffer in enumerate(file.buffers):
        content = binary if buffer.uri is None else references.bytes_of(buffer.uri, quoted=True)
        if content is None or (buffer.uri is None and i > 0):
            raise ValueError(f"buffer {i} has no data")
        if len(content) < buffer.byteLength:
            raise ValueError(f"buffer {i} breaks off after {len(content)} of {buffer.byteLength} bytes")
        buffers.append(content)
    return buffers


def _check_views(file: GltfFile, sizes: Sequence[int], where: str) -> None:
    """Views lie in their buffers and accessors in their views; all together they fit into memory."""
    for i, view in enumerate(file.bufferViews):
        if view.byteOffset + view.byteLength > sizes[view.buffer]:
            raise ValueError(f"bufferView {i} is not inside its buffer")
    for i, accessor in enumerate(file.accessors):
        if accessor.sparse is not None or accessor.bufferView is None:
            raise ValueError(f"accessor {i} is sparse, or has no data, which is not read")
        view = file.bufferViews[accessor.bufferView]
        stride = view.byteStride or accessor.item_bytes
        end = accessor.byteOffset + stride * (accessor.count - 1) + accessor.item_bytes
        if accessor.count and end > view.byteLength:
            raise ValueError(f"accessor {i} claims {accessor.count} items, more than its data holds")
    taken = sum(view.byteLength for view in file.bufferViews)
    taken = max(taken, sum(accessor.count * accessor.item_bytes for accessor in file.accessors))
    if taken > limits().bytes_of("mesh_mb"):
        raise UserError(too_large(where, "what its accessors claim", taken, "mesh_mb"))


def _check_pictures(file: GltfFile, buffers: Sequence[bytes], references: References) -> None:
    """Pictures are whole, and materials name pictures that are there."""
    for material in file.materials:
        for index in material.textures:
            if (source := file.textures[index].source) is not None:
                file.images[source]
    for i, image in enumerate(file.images):
        if image.uri is not None:
            references.picture(references.bytes_of(image.uri, quoted=True), f"picture {i}")
        elif image.bufferView is not None:
            view = file.bufferViews[image.bufferView]
            start = view.byteOffset
            references.picture(buffers[view.buffer][start : start + view.byteLength], f"picture {i}")
        else:
            raise ValueError(f"image {i} has no data")


def _triangles(file: GltfFile) -> int:
    """Triangles of the scene, those of a mesh as often as nodes place it."""
    per_mesh = [sum(_primitive(file, part) for part in mesh.primitives) for mesh in file.meshes]
    if not file.scenes:
        return 0
    placed, level = 0, list(file.scenes[file.scene].nodes)
    seen: set[int] = set()
    for _ in range(_DEEPEST):
        if not level:
            return placed
        if len(set(level)) < len(level) or not seen.isdisjoint(level):
            raise ValueError("a node stands in the scene more than once")
        seen.update(level)
        nodes = [file.nodes[i] for i in level]
        placed += sum(per_mesh[node.mesh] for node in nodes if node.mesh is not None)
        level = [child for node in nodes for child in node.children]
    raise ValueError(f"its nodes lie more than {_DEEPEST} deep")


def _primitive(file: GltfFile, part: GltfPrimitive) -> int:
    """Triangles of a part of a mesh, whose accessors fit each other."""
    accessors = {name: file.accessors[index] for name, index in part.attributes.items()}
    if part.material is not None:
        file.materials[part.material]
    if "POSITION" not in accessors:
        raise ValueError("a mesh has no positions")
    positions = accessors["POSITION"]
    if positions.type != "VEC3":
        raise ValueError(f"positions are {positions.type}, not VEC3")
    if any(accessor.count != positions.count for accessor in accessors.values()):
        raise ValueError("a mesh has attributes of different lengths")
    count = positions.count
    if part.indices is not None:
        indices = file.accessors[part.indices]
        if indices.type != "SCALAR" or indices.componentType not in (5121, 5123, 5125):
            raise ValueError("indices are no whole numbers")
        count = indices.count
    if part.mode == _FAN:
        raise ValueError("a mesh is a fan of triangles, which is not read: export triangles")
    if part.mode == _STRIP:
        return max(0, count - 2)
    if part.mode == TRIANGLES and count % 3:
        raise ValueError(f"a mesh of triangles has {count} corners")
    return count // 3 if part.mode == TRIANGLES else 0


def _unreadable(where: str, reason: str) -> UserError:
    return UserError(
        Fault(where, f"cannot be read: {reason}", "a whole glTF file", "Export the model again.")
    )
