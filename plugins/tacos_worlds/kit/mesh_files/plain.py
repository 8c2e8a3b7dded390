"""What OBJ and PLY files promise, before they are parsed."""

from __future__ import annotations

import re
from collections.abc import Sequence

from tacos_framework import Fault, UserError
from tacos_framework.files import limits, too_large
from tacos_worlds.kit.mesh_files.mtl import read_library, statement_notes
from tacos_worlds.kit.mesh_files.references import References

_FACE = re.compile(rb"^f[ \t]", re.MULTILINE)
_MOST_GROUPS, _LONGEST = 5000, 10_000
"""Beyond either, parsing takes the square of it."""
_GROUP = re.compile(rb"^(?:usemtl|o|g)[ \t]", re.MULTILINE)
_LONG_LINE = re.compile(rb"[^\n]{%d}" % _LONGEST)
_LIBRARY = re.compile(rb"^[ \t]*mtllib([^\n]*)", re.MULTILINE)
_STATEMENT = re.compile(rb"^[ \t]*(l|p|curv2?|surf|cstype)[ \t]", re.MULTILINE)
_PLY_SIZES = {
    **dict.fromkeys(("char", "uchar", "int8", "uint8"), 1),
    **dict.fromkeys(("short", "ushort", "int16", "uint16"), 2),
    **dict.fromkeys(("int", "uint", "float", "int32", "uint32", "float32"), 4),
    **dict.fromkeys(("double", "float64"), 8),
}


def in_utf_8(content: bytes, references: References) -> bytes:
    """The text of an OBJ file in UTF-8; older programs write names in Latin-1.

    Raises UserError when it is no text.
    """
    if b"\0" in content:
        raise UserError(Fault(references.where, "is no text", "an OBJ file", "Export the model again."))
    try:
        content.decode("utf-8-sig")
    except UnicodeDecodeError:
        references.notes.append("names are not in UTF-8, and are read as Latin-1")
        return content.decode("latin-1").encode("utf-8")
    return content


def check_obj(content: bytes, references: References) -> int:
    """Triangles of an OBJ file, at least; its library of materials is read.

    Raises UserError when it is larger than memory or time allow.
    """
    where = references.where
    if len(content) > limits().bytes_of("obj_mb"):  # text takes twenty times its size while it is parsed
        raise UserError(too_large(where, "the OBJ file", len(content), "obj_mb"))
    if len(_GROUP.findall(content)) > _MOST_GROUPS or _LONG_LINE.search(content):
        what = f"has more than {_MOST_GROUPS} groups and materials, or a line of more than {_LONGEST} bytes"
        raise UserError(Fault(where, what, "", "Join objects, or export glTF."))
    try:
        _read_libraries([found.decode("utf-8").strip() for found in _LIBRARY.findall(content)], references)
    except UserError:
        return 0  # kept among the faults of the references
    used = {found.decode("ascii") for found in set(_STATEMENT.findall(content))}
    references.notes += statement_notes(used)
    return len(_FACE.findall(content))


def _read_libraries(names: Sequence[str], references: References) -> None:
    """Read all libraries of materials as one, under the name of the first: trimesh asks for that alone."""
    contents = {name: references.bytes_of(name) for name in names}
    if not names or len(set(contents.values())) == 0:
        return
    library = read_library("\n".join(each.decode("utf-8", "replace") for each in contents.values()))
    references.use_library(names[0], library)


def check_ply(content: bytes, references: References) -> int:
    """Triangles of a PLY file, at least.

    Raises UserError when its header is broken, or promises more than the file holds.
    """
    end = content.find(b"end_header")
    colours: set[str] = set()
    try:
        if not content.startswith(b"ply") or end < 0:
            raise ValueError("it has no header of a PLY file")
        text, counts, least = content[:end].decode("utf-8"), {"face": 0}, 0
        binary = "binary" in text.split("\n", 2)[1]
        count = 0
        for words in map(str.split, text.splitlines()):
            if words[:1] == ["element"]:
                count = counts[words[1]] = int(words[2])
                if count < 0:
                    raise ValueError(f"it has {count} of {words[1]}")
                least += 0 if binary else count * 2
            elif words[:1] == ["property"]:
                least += count * _PLY_SIZES[words[2] if words[1] == "list" else words[1]] if binary else 0
                colours |= {words[1]} if words[-1] in ("red", "green", "blue") else set()
        if least > len(content) - end:
            raise ValueError(f"its header promises {least} bytes at least, and it breaks off")
    except (ValueError, LookupError) as error:
        raise UserError(
            Fault(references.where, f"cannot be read: {error}", "a whole PLY file", "Export the model again.")
        ) from error
    where, points = references.where, counts.get("vertex", 0)
    if not counts["face"]:
        remedy = "Make a mesh of them (Poisson reconstruction in MeshLab or CloudCompare) and export that."
        raise UserError(Fault(where, f"is a cloud of {points} points, without faces", "a mesh", remedy))
    if colours & {"ushort", "uint16"}:  # of which trimesh keeps the lower byte
        remedy = "Export colours with 8 bits."
        raise UserError(Fault(where, "has colours of 16 bits", "colours of the type uchar", remedy))
    return counts["face"]
