"""One mesh in every form in which programs write it is one mesh."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_framework.camera import linear_from_srgb
from tacos_framework.errors import UserError
from tacos_worlds.kit.mesh_files import read_model
from tacos_worlds.kit.mesh_files.polygons import triangulated
from tacos_worlds.kit.models.model import Model

POINTS = np.array([[x, y, z] for z in (0, 2.5) for y in (0, 3) for x in (0, 4)], float)
FACES = [(0, 1, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7, 3)]


def triangles_of(model: Model) -> np.ndarray:
    return np.concatenate([s.vertices[s.triangles] for s in model.surfaces])


def area_of(corners: np.ndarray) -> float:
    return float(
        np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
        / 2
    )


def as_sets(corners: np.ndarray) -> set[frozenset[tuple[float, ...]]]:
    return {frozenset(map(tuple, np.round(each, 4).tolist())) for each in corners}


def read(folder: Path, name: str, content: bytes | str) -> Model:
    (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
    return read_model(folder / name, most_px=64)


EXPECTED = as_sets(
    POINTS[np.array([*(f[:3] for f in FACES), *((f[0], f[2], f[3]) for f in FACES if len(f) == 4)])]
)


@settings(max_examples=60, deadline=None)
@given(
    counted_back=st.booleans(),
    between=st.integers(1, 8),
    newline=st.sampled_from(["\n", "\r\n", "\r"]),
    continued=st.booleans(),
    corner=st.sampled_from(["{0}", "{0}/{0}", "{0}//{0}", "{0}/{0}/{0}", "{0}/"]),
    extra=st.sampled_from(["", " # remark", " ", "\t"]),
    indent=st.sampled_from(["", "  ", "\t"]),
    coded=st.sampled_from(["utf-8", "utf-8-sig", "utf-16"]),
    point=st.sampled_from([".", ","]),
)
def test_an_obj_is_the_same_however_it_is_written(
    tmp_path_factory: pytest.TempPathFactory,
    counted_back: bool,
    between: int,
    newline: str,
    continued: bool,
    corner: str,
    extra: str,
    indent: str,
    coded: str,
    point: str,
) -> None:
    """Faces may stand between vertices, count back from there, and go on in the next line."""
    lines, written, left = [], 0, list(FACES)
    for place in POINTS:
        lines += [
            f"{kind} {' '.join(map(str, place[:width]))}".replace(".", point)
            for kind, width in (("v", 3), ("vt", 2), ("vn", 3))
        ]
        written += 1
        if written % between and written < len(POINTS):
            continue
        for face in [each for each in left if max(each) < written]:
            left.remove(face)
            words = [corner.format(i - written if counted_back else i + 1) for i in face]
            lines.append(
                "f " + (f" \\{newline}" if continued else " ").join(words) + ("" if continued else extra)
            )
    text = newline.join(indent + line for line in ["o B\u00fcro", *lines]) + newline
    folder = tmp_path_factory.mktemp("obj")
    (folder / "Room.OBJ").write_bytes(text.encode(coded))
    model = read_model(folder / "Room.OBJ", most_px=64)
    assert as_sets(triangles_of(model)) == EXPECTED
    assert [s.path for s in model.surfaces] == [("B\u00fcro",)]
    assert (model.surfaces[0].uv is not None) == ("/{0}" in corner.replace("//", ""))


@settings(max_examples=60, deadline=None)
@given(
    form=st.sampled_from(["ascii", "binary_little_endian", "binary_big_endian"]),
    position=st.sampled_from(["float", "double"]),
    count=st.sampled_from(["uchar", "int", "ushort"]),
    index=st.sampled_from(["int", "uint", "ushort"]),
    colour=st.sampled_from(["uchar", "ushort", "int", "float", "float 255", ""]),
    newline=st.sampled_from(["\n", "\r\n"]),
    name=st.sampled_from(["vertex_index", "vertex_indices"]),
    all_triangles=st.booleans(),
)
def test_a_ply_is_the_same_however_it_is_written(
    tmp_path_factory: pytest.TempPathFactory,
    form: str,
    position: str,
    count: str,
    index: str,
    colour: str,
    newline: str,
    name: str,
    all_triangles: bool,
) -> None:
    """Scanners write triangles and quads in one list, colours of any type, and either byte order."""
    white = {"uchar": 255, "ushort": 65535, "int": 255, "float": 1, "float 255": 255, "": 1}[colour]
    shade = np.linspace(0, 1, len(POINTS))[:, None] * [1, 0.5, 0.25] * white
    shade = shade if "float" in colour else shade.round()
    faces = [f for f in FACES if len(f) == 3] if all_triangles else FACES
    head = ["ply", f"format {form} 1.0", f"element vertex {len(POINTS)}"]
    head += [f"property {position} {axis}" for axis in "xyz"]
    head += [f"property {colour.split()[0]} {each}" for each in ("red", "green", "blue")] if colour else []
    head += [f"element face {len(faces)}", f"property list {count} {index} {name}", "end_header", ""]
    if form == "ascii":
        rows = [
            " ".join(f"{v:g}" for v in (*p, *(s if colour else ())))
            for p, s in zip(POINTS, shade, strict=True)
        ]
        rows += [" ".join(map(str, (len(f), *f))) for f in faces]
        body = newline.join(rows).encode() + newline.encode()
    else:
        letters = {"uchar": "B", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d"}
        order = ">" if "big" in form else "<"
        of_vertex = order + 3 * letters[position] + (3 * letters[colour.split()[0]] if colour else "")
        values = shade if "float" in colour else shade.astype(int)
        body = b"".join(
            struct.pack(of_vertex, *p, *(s.tolist() if colour else ()))
            for p, s in zip(POINTS, values, strict=True)
        )
        body += b"".join(
            struct.pack(f"{order}{letters[count]}{len(f)}{letters[index]}", len(f), *f) for f in faces
        )
    model = read(tmp_path_factory.mktemp("ply"), "scan.ply", newline.join(head).encode() + body)
    if all_triangles:
        assert len(triangles_of(model)) == len(faces)
    else:
        assert as_sets(triangles_of(model)) == EXPECTED
    (surface,) = model.surfaces
    assert (surface.colours is not None) == bool(colour)
    if surface.colours is not None:
        height = {tuple(p): linear_from_srgb(s / white) for p, s in zip(POINTS.tolist(), shade, strict=True)}
        expected = [height[tuple(each)] for each in surface.vertices.tolist()]
        np.testing.assert_allclose(surface.colours, expected, atol=2e-3)


@settings(max_examples=20, deadline=None)
@given(
    text=st.booleans(),
    head=st.sampled_from([b"", b"solid room", b"SOLID exported by a program", b"facet"]),
    shout=st.booleans(),
)
def test_an_stl_is_the_same_as_text_and_binary(
    tmp_path_factory: pytest.TempPathFactory, text: bool, head: bytes, shout: bool
) -> None:
    """Programs begin binary files with 'solid', too."""
    corners = POINTS[np.array([f[:3] for f in FACES])]
    if text:
        facets = "".join(
            "facet normal 0 0 0\n outer loop\n"
            + "".join(f"  vertex {x:e} {y} {z}\n" for x, y, z in each)
            + " endloop\nendfacet\n"
            for each in corners
        )
        content = f"solid two words\n{facets}endsolid\n"
        content = (content.upper() if shout else content).encode()
    else:
        rows = b"".join(struct.pack("<12fH", *np.zeros(3), *each.reshape(-1), 0) for each in corners)
        content = head.ljust(80) + struct.pack("<I", len(corners)) + rows
    model = read(tmp_path_factory.mktemp("stl"), "room.stl", content)
    assert as_sets(triangles_of(model)) == as_sets(corners)


@settings(max_examples=60, deadline=None)
@given(
    radii=st.lists(st.floats(0.2, 3), min_size=4, max_size=24),
    turn=st.tuples(*[st.floats(-3, 3)] * 3),
    away=st.sampled_from([0.0, 1e3, 5e6]),
)
def test_triangles_cover_a_polygon_that_is_not_convex_once(
    radii: list[float], turn: tuple[float, float, float], away: float
) -> None:
    """Floors of BIM programs are one polygon, round all corners of a storey."""
    from scipy.spatial.transform import Rotation

    angle = np.linspace(0, 2 * np.pi, len(radii), endpoint=False)
    flat = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]) * np.array(radii)[:, None]
    points = flat @ Rotation.from_rotvec(turn).as_matrix().T + away
    found = triangulated(points, np.array([len(points)]))
    x, y = flat[:, 0], flat[:, 1]
    shoelace = float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()) / 2
    assert len(found) == len(radii) - 2
    assert area_of(points[found]) == pytest.approx(shoelace, rel=1e-5 if away < 1e6 else 1e-3)


def test_a_floor_with_a_bay_does_not_reach_across_it(tmp_path: Path) -> None:
    outline = [(0, 0), (6, 0), (6, 4), (4, 4), (4, 1), (2, 1), (2, 4), (0, 4)]
    lines = [f"v {x} {y} 0" for x, y in outline] + ["f " + " ".join(map(str, range(1, 9)))]
    assert area_of(triangles_of(read(tmp_path, "floor.obj", "\n".join(lines)))) == pytest.approx(18)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "names item 4 of 3"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "line 4 .*names item 0"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nf -3 -2 -1\n", "line 3 .*names item -3 of 2"),
        ("a.obj", "v 0;5 0 0\n", "line 1 .*'?0;5'?"),
        ("a.obj", "v 0 0\n", "line 1 .*it has 2 numbers"),
        (
            "a.stl",
            "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nendloop\nendfacet\n",
            "has 1 corners",
        ),
        ("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\n", "end_header"),
        ("a.ply", "ply\nformat asci 1.0\nend_header\n", "its format is asci"),
    ],
)
def test_what_a_line_lacks_is_said(name: str, text: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=said):
        read(tmp_path, name, text)


@pytest.mark.parametrize(
    "written", ["C:\\models\\maps\\Tile.PNG", "maps/tile.png", '"TILE.png"', "./tile.png"]
)
def test_pictures_are_found_under_paths_of_another_machine(written: str, tmp_path: Path) -> None:
    from PIL import Image

    Image.new("RGB", (2, 2), (10, 20, 30)).save(tmp_path / "tile.png")
    (tmp_path / "my room.mtl").write_text(f"newmtl floor tile\nKd 0.5 1 1\nmap_Kd {written}\n")
    faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl floor tile\nf 1/1 2/2 3/3\n"
    model = read(tmp_path, "room.obj", f"mtllib my room.mtl\n{faces}")
    skin = model.skins[model.surfaces[0].skin]
    assert skin.texture is not None
    assert skin.texture[0, 0].tolist() == [10, 20, 30]
    assert skin.base_colour.tolist() == [0.5, 1, 1]
    assert sum("beside it is read" in note for note in model.notes) == ("maps" in written)


@pytest.mark.parametrize("coded", ["utf-8-sig", "utf-16", "latin-1"])
def test_a_library_is_the_same_however_it_is_written(coded: str, tmp_path: Path) -> None:
    """3ds Max has a # in names; others put remarks behind pictures and numbers."""
    from PIL import Image

    Image.new("RGB", (2, 2), (10, 20, 30)).save(tmp_path / "tile #1.png")
    text = "newmtl Bück #25\r\nKd 1 1 1 # white\r\nmap_Kd tile #1.png # wood\r\nd 1.0 # 0\r\n"
    (tmp_path / "a.mtl").write_bytes(text.encode(coded))
    obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl Bück #25\nf 1 2 3\n"
    model = read(tmp_path, "a.obj", obj.encode(coded))
    skin = model.skins[model.surfaces[0].skin]
    assert (skin.name, skin.opacity, skin.texture is not None) == ("Bück #25", 1.0, True)
    assert set(model.notes) <= {"names are not in UTF-8, and are read as Windows-1252"}


def test_materials_that_no_library_has_are_told_with_the_effect(tmp_path: Path) -> None:
    model = read(tmp_path, "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl oak\nf 1 2 3\n")
    assert model.notes == ("oak: no library of materials (mtllib) has them, and they are drawn grey",)


def test_files_of_materials_that_are_not_there_are_told_and_the_shape_is_drawn(tmp_path: Path) -> None:
    """Models are passed on without their libraries and pictures; nobody learns that from a grey wall."""
    faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl oak\nf 1 2 3\n"
    model = read(tmp_path, "a.obj", f"mtllib gone.mtl\n{faces}")
    assert len(triangles_of(model)) == 1
    assert model.notes[0] == (
        "refers to 'gone.mtl', which is not there: its materials lack their colours and pictures"
    )
    text = "newmtl oak\nKd 0.8 1 1\nmap_Kd /home/else/oak.png\nmap_d /home/else/oak.png\n"
    (tmp_path / "b.mtl").write_text(text)
    model = read(tmp_path, "b.obj", f"mtllib b.mtl\n{faces}")
    assert model.skins[0].texture is model.skins[0].mask is None
    assert model.skins[0].base_colour.tolist() == [0.4, 0.5, 0.5]
    effect = "what it is a picture of is drawn plain"
    assert model.notes == (f"refers to '/home/else/oak.png', which is not there: {effect}",)


@pytest.mark.parametrize(
    ("library", "named", "at", "note"),
    [
        ("a.mtl", "../maps/oak.png", "oak.png", "refers to '../maps/oak.png': oak.png beside it is read"),
        ("mats/a.mtl", "oak.png", "mats/oak.png", ""),
        ("mats/a.mtl", "oak.png", "oak.png", ""),
        ("mats/a.mtl", "../maps/oak.png", "maps/oak.png", ""),
        ("a.mtl", "my%20oak.png", "my oak.png", ""),
    ],
)
def test_pictures_are_found_beside_their_library_or_the_model(
    library: str, named: str, at: str, note: str, tmp_path: Path
) -> None:
    """A file of that name outside of the model's folder is not read."""
    from PIL import Image

    folder = tmp_path / "model"
    for place in (tmp_path / "maps" / "oak.png", folder / at, folder / library):
        place.parent.mkdir(parents=True, exist_ok=True)
    Image.new("RGB", (2, 2), (200, 0, 0)).save(tmp_path / "maps" / "oak.png")
    Image.new("RGB", (2, 2), (10, 20, 30)).save(folder / at)
    (folder / library).write_text(f"newmtl oak\nmap_Kd {named}\n")
    model = read(folder, "a.obj", f"mtllib {library}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl oak\nf 1 2 3\n")
    texture = model.skins[0].texture
    assert texture is not None
    assert texture[0, 0].tolist() == [10, 20, 30]
    assert model.notes == ((note,) if note else ())


def test_masks_in_a_picture_of_their_own_are_holes(tmp_path: Path) -> None:
    from PIL import Image

    Image.new("RGB", (2, 2), (9, 9, 9)).save(tmp_path / "leaf.png")
    Image.fromarray(np.array([[255, 0], [255, 0]], np.uint8)).save(tmp_path / "holes.png")
    (tmp_path / "a.mtl").write_text("newmtl leaf\nmap_Kd leaf.png\nmap_d holes.png\n")
    faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl leaf\nf 1/1 2/2 3/3\n"
    model = read(tmp_path, "a.obj", f"mtllib a.mtl\n{faces}")
    mask = model.skins[0].mask
    assert mask is not None
    assert mask.tolist() == [[255, 0], [255, 0]]
    assert model.notes == ()


@settings(max_examples=25, deadline=None)
@given(easting=st.floats(1e5, 9e5), northing=st.floats(1e6, 9e6))
def test_positions_that_single_precision_has_rounded_are_told(
    tmp_path_factory: pytest.TempPathFactory, easting: float, northing: float
) -> None:
    away = np.array([easting, northing, 0]) + POINTS
    rounded, folder = away.astype(np.float32), tmp_path_factory.mktemp("far")
    faces = "".join(f"f {' '.join(str(i + 1) for i in f)}\n" for f in FACES)

    def notes(points: np.ndarray) -> tuple[str, ...]:
        lines = "".join("v " + " ".join(f"{value:.4f}" for value in each) + "\n" for each in points.tolist())
        return read(folder, "far.obj", lines + faces).notes

    assert "single precision" in " ".join(notes(rounded)) or not (rounded[:, 1] % 1).any()
    assert notes(np.round(away) + 0.03) == ()
