"""STL files: triangles without names, colours or a unit.

Source: 3D Systems 1989, "StereoLithography Interface Specification".
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from tacos_worlds.kit.mesh_files.damage import Damaged, refuse_triangles
from tacos_worlds.kit.mesh_files.polygons import surface_of
from tacos_worlds.kit.mesh_files.precision import rounding_note
from tacos_worlds.kit.mesh_files.references import References
from tacos_worlds.kit.models.model import Model, Skin

_HEAD, _ROW = 84, 50
_SOLID = re.compile(rb"^[ \t]*solid([^\r\n]*)", re.MULTILINE | re.IGNORECASE)
_VERTEX = re.compile(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)", re.IGNORECASE)


def read_stl(content: bytes, references: References, most_px: int, most_triangles: int | None) -> Model:
    """Triangles of a binary or a text file; parameters are those of `read_obj`, and `most_px` has no effect.

    Binary files may begin with 'solid' as well: their length tells them.
    """
    del most_px
    binary = len(content) >= _HEAD and len(content) == _HEAD + _ROW * _promised(content)
    text = not binary and content.lstrip()[:5].lower() == b"solid" and b"facet" in content.lower()
    if not text and len(content) < _HEAD + _ROW * max(_promised(content), 1):
        raise Damaged(f"it breaks off: its header promises {_promised(content)} triangles")
    count = content.lower().count(b"endfacet") if text else _promised(content)
    refuse_triangles(references.where, count, most_triangles)
    pieces = _of_text(content) if text else {"": _of_rows(content, count, references)}
    surfaces = []
    for name, corners in pieces.items():
        vertices, place = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
        indices = np.column_stack([place.reshape(-1), np.zeros((place.size, 2), np.int64)])
        path = (name or Path(references.file_name).stem,)
        surfaces.append(surface_of(path, 0, vertices, np.full(len(corners), 3), indices))
    everything = np.concatenate([surface.vertices for surface in surfaces])
    references.notes += rounding_note(everything, single=not text)
    return Model(tuple(surfaces), (Skin("grey", np.full(3, 0.5)),), notes=tuple(references.notes))


def _promised(content: bytes) -> int:
    return int.from_bytes(content[80:84], "little")


def _of_rows(content: bytes, count: int, references: References) -> np.ndarray:
    """(T, 3, 3) of a binary file."""
    kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    rows = np.frombuffer(content, kind, count, _HEAD)
    if rows["attribute"].any():
        references.notes.append("colours of STL are not carried out: all is grey")
    return np.asarray(rows["corners"], np.float64)


def _of_text(content: bytes) -> dict[str, np.ndarray]:
    """(T, 3, 3) of each solid of a text file, by its name."""
    starts = list(_SOLID.finditer(content))
    ends = [*(found.start() for found in starts[1:]), len(content)]
    pieces: dict[str, np.ndarray] = {}
    for number, (found, end) in enumerate(zip(starts, ends, strict=True)):
        name = found[1].decode("utf-8", "replace").strip()
        corners = np.array(_VERTEX.findall(content, found.end(), end), dtype=np.float64).reshape(-1, 3)
        if len(corners) % 3 or len(corners) != 3 * content.lower().count(b"endfacet", found.end(), end):
            raise Damaged(f"solid {name or number} has {len(corners)} corners, or a facet that does not end")
        if len(corners):
            pieces[f"{name} {number}" if name in pieces else name] = corners.reshape(-1, 3, 3)
    if not pieces:
        raise Damaged("it holds no triangles")
    return pieces
