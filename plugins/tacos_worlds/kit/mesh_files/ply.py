"""PLY files, as scanners write them: text or binary, of either byte order.

Source: Turk 1994, "The PLY Polygon File Format".
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera import linear_from_srgb
from tacos_worlds.kit.mesh_files.damage import Damaged, points_alone, refuse_triangles
from tacos_worlds.kit.mesh_files.mtl import MtlMaterial
from tacos_worlds.kit.mesh_files.mtl_skins import MtlSkins
from tacos_worlds.kit.mesh_files.polygons import surface_of
from tacos_worlds.kit.mesh_files.precision import rounding_note
from tacos_worlds.kit.mesh_files.references import References
from tacos_worlds.kit.models.model import Model, Skin

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
_UV_NAMES = (("texture_u", "texture_v"), ("u", "v"), ("s", "t"), ("texcoord_u", "texcoord_v"))
_COLOUR_NAMES = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"), ("r", "g", "b"))
_INDEX_NAMES = ("vertex_indices", "vertex_index")


@dataclass(frozen=True)
class _Property:
    name: str
    kind: str
    count_kind: str = ""  # of lists


@dataclass(frozen=True)
class _Element:
    name: str
    count: int
    properties: tuple[_Property, ...]


@dataclass(frozen=True, eq=False)
class _List:
    """Values of a list property, and how many each row has."""

    sizes: NDArray[np.int64]
    values: NDArray[Any]


Columns = Mapping[str, Any]


def read_ply(content: bytes, references: References, most_px: int, most_triangles: int | None) -> Model:
    """The one surface of a PLY file, or one for each of its textures; parameters are those of `read_obj`."""
    try:
        form, elements, pictures, body = _header(content)
    except (ValueError, LookupError) as error:
        raise Damaged(f"its header is none of a PLY file ({error})") from error
    counts = {element.name: element.count for element in elements}
    where, faces = references.where, counts.get("face", 0) + counts.get("tristrips", 0)
    if not faces:
        raise points_alone(where, counts.get("vertex", 0))
    refuse_triangles(where, faces, most_triangles)
    tables = dict(_tables(form, elements, body))
    model = _model(tables, pictures, references, most_px)
    refuse_triangles(where, model.triangle_count, most_triangles)
    return model


def _header(content: bytes) -> tuple[str, list[_Element], list[str], bytes]:
    """Form, elements and names of pictures by the header, and the bytes after it."""
    end = content.find(b"end_header")
    line_end = min((at for at in (content.find(b"\n", end), content.find(b"\r", end)) if at >= 0), default=-1)
    if not content.startswith(b"ply") or end < 0 or line_end < 0:
        raise ValueError("it does not begin with ply, or has no end_header")
    body = content[line_end + 1 :]
    if content[line_end : line_end + 2] == b"\r\n":
        body = body[1:]
    form, elements, pictures = "", list[_Element](), list[str]()
    for line in content[:end].decode("utf-8", "replace").splitlines():
        words = line.split()
        if words[:1] == ["format"]:
            form = words[1]
        elif words[:1] == ["element"]:
            if (count := int(words[2])) < 0:
                raise ValueError(f"it has {count} of {words[1]}")
            elements.append(_Element(words[1], count, ()))
        elif words[:1] == ["property"]:
            kinds = [_TYPES[word] for word in (words[2:4] if words[1] == "list" else words[1:2])]
            added = _Property(words[-1], kinds[-1], kinds[0] if len(kinds) == 2 else "")
            last = elements[-1]
            elements[-1] = _Element(last.name, last.count, (*last.properties, added))
        elif [word.lower() for word in words[:2]] == ["comment", "texturefile"]:
            pictures.append(line.strip().split(maxsplit=2)[2])
    if form not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise ValueError(f"its format is {form or 'not said'}")
    return form, elements, pictures, body


def _tables(form: str, elements: list[_Element], body: bytes) -> Iterator[tuple[str, Columns]]:
    """The columns of each element, by name."""
    order, at = ">" if "big" in form else "<", 0
    numbers = _text_numbers(body) if form == "ascii" else None
    data: NDArray[Any] = np.frombuffer(body, np.uint8) if numbers is None else numbers
    for element in elements:
        columns, at = _columns(element, data, at, order, text=numbers is not None)
        yield element.name, columns


def _text_numbers(body: bytes) -> NDArray[np.float64]:
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # of text that is no numbers, which ends the array
        return np.fromstring(body.decode("ascii"), sep=" ")


def _columns(
    element: _Element, data: NDArray[Any], at: int, order: str, *, text: bool
) -> tuple[Columns, int]:
    """Columns of the rows that begin at a place of `data`, and the place after them.

    Lists are read as if all rows had as many entries as the first, and one by one where they do not.
    """

    def kind(name: str) -> np.dtype[Any]:
        return np.dtype(np.float64) if text else np.dtype(order + name)

    def wanted(end: int) -> None:
        if end > len(data):
            raise Damaged(f"it breaks off: its header promises {element.count} of {element.name}")

    if not element.count:
        return {}, at
    unit = 8 if text else 1
    fields, offset = list[tuple[str, Any]](), at
    for index, each in enumerate(element.properties):
        if each.count_kind:
            first = kind(each.count_kind)
            wanted(offset + first.itemsize // unit)
            many = int(data[offset : offset + first.itemsize // unit].view(first)[0])
            if not 0 <= many <= len(data):
                raise Damaged(f"a list of {element.name} claims {many} entries")
            fields.append((f"n{index}", first))
            offset += first.itemsize // unit
        fields.append((f"v{index}", (kind(each.kind), (many,)) if each.count_kind else kind(each.kind)))
        offset += kind(each.kind).itemsize // unit * (many if each.count_kind else 1)
    row = np.dtype(fields)
    end = at + element.count * (row.itemsize // unit)
    if end <= len(data) or not any(each.count_kind for each in element.properties):
        wanted(end)
        rows = np.frombuffer(data[at:end].tobytes(), row)
        if all((rows[name] == rows[name][0]).all() for name in row.names or () if name.startswith("n")):
            return {
                each.name: _List(rows[f"n{index}"].astype(np.int64), rows[f"v{index}"].reshape(-1))
                if each.count_kind
                else rows[f"v{index}"]
                for index, each in enumerate(element.properties)
            }, end
    return _one_by_one(element, data, at, kind, unit, wanted)


def _one_by_one(
    element: _Element, data: NDArray[Any], at: int, kind: Any, unit: int, wanted: Any
) -> tuple[Columns, int]:
    """Columns of rows whose lists differ in length."""
    values: dict[str, list[NDArray[Any]]] = {each.name: [] for each in element.properties}
    sizes: dict[str, list[int]] = {each.name: [] for each in element.properties if each.count_kind}
    plan = [
        (each.name, kind(each.count_kind) if each.count_kind else None, kind(each.kind))
        for each in element.properties
    ]
    for _ in range(element.count):
        for name, count_kind, of_values in plan:
            many = 1
            if count_kind is not None:
                step = count_kind.itemsize // unit
                wanted(at + step)
                many = int(data[at : at + step].view(count_kind)[0])
                if many < 0:
                    raise Damaged(f"a list of {element.name} claims {many} entries")
                sizes[name].append(many)
                at += step
            step = of_values.itemsize // unit * many
            wanted(at + step)
            values[name].append(data[at : at + step].view(of_values))
            at += step
    joined = {name: np.concatenate(each) for name, each in values.items()}
    return {
        name: _List(np.array(sizes[name], np.int64), each) if name in sizes else each
        for name, each in joined.items()
    }, at


def _model(tables: Mapping[str, Columns], pictures: list[str], references: References, most_px: int) -> Model:
    vertex, face = tables.get("vertex", {}), tables.get("face", {})
    if not all(axis in vertex for axis in "xyz"):
        raise Damaged("its vertices have no x, y, z")
    vertices = np.column_stack([vertex[axis] for axis in "xyz"]).astype(np.float64)
    single = all(vertex[axis].dtype.itemsize == 4 for axis in "xyz")
    references.notes += rounding_note(vertices, single=single)
    polygons = next((face[name] for name in _INDEX_NAMES if isinstance(face.get(name), _List)), None)
    if polygons is None and "tristrips" in tables:
        polygons, face = _of_strips(tables["tristrips"]), {}
    if polygons is None:
        raise Damaged("its faces have no vertex_indices")
    sizes, corner = polygons.sizes, polygons.values.astype(np.int64)
    if len(corner) and not 0 <= corner.min() <= corner.max() < len(vertices):
        raise Damaged(f"a face names vertex {corner.max()} of {len(vertices)}")
    colours = _colours(vertex, references)
    of_vertex = corner
    if colours is None and (of_faces := _colours(face, references)) is not None:
        vertices, colours = vertices[corner], np.repeat(of_faces, sizes, axis=0)
        corner = np.arange(len(corner))
    uv, uv_row = _texture_coordinates(vertex, face, sizes, of_vertex)
    normals = None
    if all(axis in vertex for axis in ("nx", "ny", "nz")):
        normals = np.column_stack([vertex[axis] for axis in ("nx", "ny", "nz")]).astype(np.float64)
    corners = np.column_stack([corner, uv_row, of_vertex if normals is not None else 0 * of_vertex])
    which = 0 * sizes
    if len(pictures) > 1 and uv is not None and "texnumber" in face:
        which = np.asarray(face["texnumber"], np.int64).clip(0, len(pictures) - 1)
    skins, stem = MtlSkins(references, most_px), Path(references.file_name).stem
    surfaces, made = [], list[Skin]()
    for number in np.unique(which):
        own = which == number
        name = stem if len(pictures) < 2 else f"{stem} {number}"
        surfaces.append(
            surface_of(
                (name,),
                len(made),
                vertices,
                sizes[own],
                corners[np.repeat(own, sizes)],
                uv=uv,
                normals=normals,
                colours=colours,
            )
        )
        shown = pictures[number] if pictures and uv is not None else ""
        plain = (0.5,) * 3 if colours is None and not shown else (1.0,) * 3
        made.append(skins.skin(name, MtlMaterial(diffuse=plain, picture=shown, roughness=0.8)))
    if pictures and uv is None:
        references.notes.append(f"{pictures[0]} is left out: the file has no texture coordinates")
    return Model(tuple(surfaces), tuple(made), notes=tuple(references.notes))


def _of_strips(strips: Columns) -> _List:
    """Triangles of strips, which -1 ends."""
    (first,) = (each for each in strips.values() if isinstance(each, _List))
    triangles = list[NDArray[np.int64]]()
    for strip in np.split(first.values, np.cumsum(first.sizes)[:-1]):
        for run in np.split(strip.astype(np.int64), np.flatnonzero(strip == -1)):
            run = run[run >= 0]
            rows = np.column_stack([run[:-2], run[1:-1], run[2:]])
            rows[1::2] = rows[1::2, ::-1]
            triangles.append(rows)
    values = np.concatenate([np.zeros((0, 3), np.int64), *triangles])
    return _List(np.full(len(values), 3), values.reshape(-1))


def _texture_coordinates(
    vertex: Columns, face: Columns, sizes: NDArray[np.int64], of_vertex: NDArray[np.int64]
) -> tuple[NDArray[np.float64] | None, NDArray[np.int64]]:
    """Texture coordinates of vertices or of the corners of faces, and the row of each corner."""
    of_corners = face.get("texcoord")
    if isinstance(of_corners, _List) and np.array_equal(of_corners.sizes, 2 * sizes):
        return of_corners.values.astype(np.float64).reshape(-1, 2), np.arange(len(of_vertex))
    for names in _UV_NAMES:
        if all(name in vertex for name in names):
            return np.column_stack([vertex[name] for name in names]).astype(np.float64), of_vertex
    return None, 0 * of_vertex


def _colours(columns: Columns, references: References) -> NDArray[np.float64] | None:
    """(N, 3) linear; whole numbers of 8 or 16 bits by their size, floats up to 1 or up to 255."""
    names = next((each for each in _COLOUR_NAMES if all(name in columns for name in each)), None)
    if names is None:
        return None
    codes = np.column_stack([columns[name] for name in names]).astype(np.float64)
    largest, kind = float(np.nan_to_num(codes).max(initial=0.0)), columns[names[0]].dtype
    white = {"u1": 255.0, "u2": 65535.0}.get(kind.str[1:])
    if white is None:  # floats, numbers of text files, and whole numbers larger than they need to be
        white = next(each for each in (1.0, 255.0, 65535.0, largest) if largest <= each)
        if white > 1 and (codes % 1).any():
            references.notes.append(f"colours of up to {largest:g} are read as of 0 to {white:g}")
    return np.asarray(linear_from_srgb(np.clip(codes / white, 0, 1)))
