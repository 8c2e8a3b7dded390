"""OBJ files, as mesh programs, scanners and BIM write them.

Source: Wavefront 1995, "Object files (.obj)", Advanced Visualizer, appendix B1.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Fault, UserError
from tacos_framework.camera import linear_from_srgb
from tacos_framework.files import limits, too_large
from tacos_worlds.kit.mesh_files.damage import Damaged, points_alone, refuse_triangles
from tacos_worlds.kit.mesh_files.mtl import Library, MtlMaterial, read_library
from tacos_worlds.kit.mesh_files.mtl_skins import MtlSkins
from tacos_worlds.kit.mesh_files.polygons import surface_of
from tacos_worlds.kit.mesh_files.precision import rounding_note
from tacos_worlds.kit.mesh_files.references import References
from tacos_worlds.kit.models.model import Model, Skin, Surface

_FACE = re.compile(rb"^[ \t]*fo?[ \t]", re.MULTILINE)
_MOST_GROUPS, _LONGEST = 5000, 10_000
_NOT_DRAWN = {
    **dict.fromkeys(("l", "p"), "lines and points (l, p) are left out: only faces are drawn"),
    **dict.fromkeys(
        ("curv", "curv2", "surf", "cstype"),
        "free-form curves and surfaces are left out: export them as polygons",
    ),
}


@dataclass(frozen=True)
class _Part:
    """Faces that share their names, their material, and what their corners name."""

    names: tuple[str, ...]
    material: str
    has_uv: bool
    has_normals: bool


@dataclass(eq=False)
class _Lines:
    """Lines of numbers, kept as text until all can be read at once."""

    texts: list[str] = field(default_factory=list)
    places: list[int] = field(default_factory=list)

    def add(self, text: str, place: int) -> None:
        self.texts.append(text)
        self.places.append(place)

    def numbers(self, kind: type) -> NDArray[Any]:
        """All numbers, one after another; lines that hold anything else are named."""
        with warnings.catch_warnings():
            warnings.simplefilter(
                "error", DeprecationWarning
            )  # of text that is no numbers, which ends the array
            try:
                return np.fromstring(" ".join(self.texts).replace("/", " "), kind, sep=" ")
            except (DeprecationWarning, ValueError):
                for text, place in zip(self.texts, self.places, strict=True):
                    try:
                        [kind(word) for word in text.replace("/", " ").split()]
                    except ValueError as error:
                        raise Damaged(f"line {place} cannot be read ({error})") from error
                raise

    def rows(self, least: int) -> tuple[NDArray[np.float64], Mapping[int, list[float]]]:
        """(N, `least`) the first numbers of each line, and by line those of colours, the fourth to sixth."""
        numbers = self.numbers(float)
        if len(numbers) in (least * len(self.texts), 6 * len(self.texts)) and len(numbers):
            width = len(numbers) // len(self.texts)
            if all(len(text.split()) == width for text in self.texts):
                table = numbers.reshape(-1, width)
                more = dict(enumerate(table[:, 3:].tolist())) if width == 6 else {}
                return table[:, :least], more
        values = [[float(word) for word in text.split()] for text in self.texts]
        for row, place in zip(values, self.places, strict=True):
            if len(row) < least:
                if least == 3 or not row:
                    raise Damaged(f"line {place} cannot be read (it has {len(row)} numbers)")
                row.append(0.0)  # a texture coordinate of a curve
        table = np.array([row[:least] for row in values], np.float64).reshape(-1, least)
        return table, {index: row[3:6] for index, row in enumerate(values) if len(row) >= 6}


def read_obj(content: bytes, references: References, most_px: int, most_triangles: int | None) -> Model:
    """Surfaces and skins of an OBJ file with its libraries of materials.

    - `most_px`: longest edge of textures [px].
    - `most_triangles`: as many at most; by default the limit ``mesh_triangles``.

    Raises Damaged where a line is not what the format says; the message names it. Raises UserError where
    files it names cannot be read, or it is too large.
    """
    where = references.where
    if len(content) > limits().bytes_of("obj_mb"):  # text takes many times its size while it is parsed
        raise UserError(too_large(where, "the OBJ file", len(content), "obj_mb"))
    refuse_triangles(where, len(_FACE.findall(content)), most_triangles)
    read = _Reader()
    read.lines(_text(content, references))
    if len(read.parts) > _MOST_GROUPS:
        what = f"has more than {_MOST_GROUPS} groups and materials"
        raise UserError(Fault(where, what, "", "Join objects, or export glTF."))
    library = _library(read.libraries, references)
    references.notes += dict.fromkeys(_NOT_DRAWN[each] for each in read.not_drawn)
    surfaces, skins = read.model(library, references, most_px, Path(references.file_name).stem)
    if read.vertex_count and not (surfaces or read.not_drawn):
        raise points_alone(where, read.vertex_count)
    refuse_triangles(where, sum(len(each.triangles) for each in surfaces), most_triangles)
    return Model(tuple(surfaces), tuple(skins), notes=tuple(references.notes))


def _text(content: bytes, references: References) -> str:
    """The text, with continued lines joined."""
    return re.sub(r"\\[ \t]*(\r\n|\r|\n)", " ", references.text_of(content, "an OBJ file"))


class _Reader:
    """What the lines of a file say, in their order: indices below 0 count back from where they stand."""

    def __init__(self) -> None:
        self.parts: dict[_Part, _Lines] = {}
        self.libraries: list[str] = []
        self.not_drawn: dict[str, None] = {}
        self._rows = {"v": _Lines(), "vt": _Lines(), "vn": _Lines()}

    @property
    def vertex_count(self) -> int:
        return len(self._rows["v"].texts)

    def lines(self, text: str) -> None:
        """Read all lines."""
        names, material = {"o": "", "g": ""}, ""
        for place, line in enumerate(text.splitlines(), start=1):
            words = line.split(maxsplit=1)
            if not words:
                continue
            key, rest = words[0], words[1] if len(words) > 1 else ""
            if key in self._rows:
                plain = rest.partition("#")[0].replace(",", ".")  # many countries write decimal commas
                self._rows[key].add(plain, place)
            elif key in ("f", "fo"):
                path = tuple(dict.fromkeys(each for each in names.values() if each))
                try:
                    self._face(path, material, rest.partition("#")[0].strip(), place)
                except ValueError as error:
                    raise Damaged(f"line {place} cannot be read ({error}): {line.strip()[:60]!r}") from error
            elif key in names:
                names[key] = "" if key == "g" and rest.strip() in ("default", "off") else rest.strip()
                names["g"] = "" if key == "o" else names["g"]
            elif key == "usemtl":
                material = rest.strip()
            elif key == "mtllib":
                self.libraries.append(rest.strip())
            elif key in _NOT_DRAWN:
                self.not_drawn[key] = None

    def _face(self, names: tuple[str, ...], material: str, text: str, place: int) -> None:
        """Sort a face by what its corners name; those that count back, or lack some of it, are rewritten."""
        count, slashes, doubled = len(text.split()), text.count("/"), text.count("//")
        if count < 3:
            return  # a face without an extent
        form = {(0, 0): (False, False), (count, 0): (True, False), (2 * count, 0): (True, True)}.get(
            (slashes, doubled), (False, True) if (slashes, doubled) == (2 * count, count) else None
        )
        if form is None or "-" in text or "/ " in f"{text} ":
            corners = [self._corner(word) for word in text.split()]
            form = all(uv for _, uv, _ in corners), all(normal for _, _, normal in corners)
            keep = [index for index, used in enumerate((True, *form)) if used]
            text = " ".join("/".join(str(corner[index]) for index in keep) for corner in corners)
        self.parts.setdefault(_Part(names, material, *form), _Lines()).add(text, place)

    def _corner(self, word: str) -> tuple[int, int, int]:
        """Of a corner the numbers of its vertex, texture coordinates and normal; 0 for what it lacks."""
        named = (*word.split("/"), "", "")[:3]
        vertex, uv, normal = (
            self._counted(text, len(rows.texts))
            for text, rows in zip(named, self._rows.values(), strict=True)
        )
        return vertex, uv, normal

    @staticmethod
    def _counted(text: str, so_far: int) -> int:
        index = int(text) if text else 0
        if -index > so_far:
            raise ValueError(f"it names item {index} of {so_far}")
        return index if index >= 0 else so_far + index + 1

    def model(
        self, library: Library, references: References, most_px: int, stem: str
    ) -> tuple[list[Surface], list[Skin]]:
        """A surface and a skin for each part."""
        tables, given = {}, dict[int, list[float]]()
        for key, lines in self._rows.items():
            tables[key], more = lines.rows(2 if key == "vt" else 3)
            given |= more if key == "v" else {}
        look_single = any("e+" in text for text in self._rows["v"].texts)
        references.notes += rounding_note(tables["v"], single=look_single)
        colours = _vertex_colours(given, len(tables["v"]), references)
        plain = Skin("colours", np.full(3, 0.5) if colours is None else np.ones(3))
        maker = MtlSkins(references, most_px)
        skins = [maker.skin(name, each) for name, each in library.materials.items()]
        number = {name: index for index, name in enumerate(library.materials)}
        references.notes += _unknown({part.material for part in self.parts}, number)
        surfaces = []
        for part, faces in self.parts.items():
            used = [0, *([1] if part.has_uv else []), *([2] if part.has_normals else [])]
            corners = np.ones((sum(sizes := [len(text.split()) for text in faces.texts]), 3), np.int64)
            corners[:, used] = faces.numbers(int).reshape(-1, len(used))
            corners -= 1
            for column, (key, table) in enumerate(tables.items()):
                least, most = int(corners[:, column].min()), int(corners[:, column].max())
                if column in used and not 0 <= least <= most < len(table):
                    wrong = (most if most >= len(table) else least) + 1
                    at = int(np.argmax(corners[:, column] == wrong - 1))
                    place = faces.places[int(np.searchsorted(np.cumsum(sizes), at, "right"))]
                    raise Damaged(f"line {place} names item {wrong} of {len(table)} ({key})")
            material = (part.material,) if part.material else ()
            look = library.materials.get(part.material, MtlMaterial())
            surfaces.append(
                surface_of(
                    tuple(dict.fromkeys((*part.names, *material))) or (stem,),
                    number.get(part.material, len(skins)),
                    tables["v"],
                    np.array(sizes, np.int64),
                    corners,
                    uv=tables["vt"] * look.scale + look.offset if part.has_uv else None,
                    normals=tables["vn"] if part.has_normals else None,
                    colours=colours,
                )
            )
        return surfaces, [*skins, plain]


def _vertex_colours(
    given: Mapping[int, list[float]], count: int, references: References
) -> NDArray[np.float64] | None:
    """(V, 3) linear, white where a vertex has none."""
    if not given:
        return None
    codes, colours = np.array(list(given.values())), np.ones((count, 3))
    if codes.max() > 1:
        references.notes.append("colours of vertices are above 1, and are read as 0 to 255")
        codes = codes / 255
    colours[list(given)] = linear_from_srgb(np.clip(codes, 0, 1))
    return colours


def _unknown(used: Iterable[str], known: Mapping[str, int]) -> Iterator[str]:
    missing = sorted(name for name in used if name and name not in known)
    if missing:
        shown = ", ".join(missing[:5]) + (f" and {len(missing) - 5} more" if len(missing) > 5 else "")
        yield f"{shown}: no library of materials (mtllib) has them, and they are drawn grey"


def _library(lines: Sequence[str], references: References) -> Library:
    """All libraries of materials as one; a line may name several, or one with blanks in its name."""
    texts: dict[str, str] = {}
    for line in lines:
        whole = line.strip().strip('"')
        for name in [whole] if references.has(whole) or " " not in whole else whole.split():
            if references.lacks(name, "its materials lack their colours and pictures"):
                continue
            try:
                texts.setdefault(name, references.text_of(references.bytes_of(name), "an MTL file"))
            except UserError:
                continue  # kept among the faults of the references: all are told at once
    library = read_library(texts)
    references.notes += library.notes
    return library
