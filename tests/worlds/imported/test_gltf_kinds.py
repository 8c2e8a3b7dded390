"""What exporters and packers of glTF do to one square: it stays where it is meant to be."""

from __future__ import annotations

import io
import json
import struct
import sys
import time
from base64 import b64decode, b64encode
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from scipy.spatial.transform import Rotation

from tacos_framework.errors import UserError
from tacos_worlds.imported.reader import read_world
from tacos_worlds.kit.mesh_files import read_model
from tacos_worlds.kit.models.model import Model

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "<f4")
numbers = st.floats(-4, 4, width=32)


class Tree:
    """A glTF file that grows by arrays."""

    def __init__(self) -> None:
        self.tree: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "accessors": [],
            "bufferViews": [],
            "nodes": [{"mesh": 0}],
            "scenes": [{"nodes": [0]}],
        }
        self._data = b""
        self.more_buffers: list[dict[str, Any]] = []
        indices = self.array(np.array([0, 1, 2, 0, 2, 3], "<u2"), "SCALAR")
        self.primitive: dict[str, Any] = {
            "attributes": {"POSITION": self.array(SQUARE, "VEC3")},
            "indices": indices,
        }
        self.tree["meshes"] = [{"primitives": [self.primitive]}]

    def view(self, content: bytes) -> int:
        self.tree["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self._data), "byteLength": len(content)}
        )
        self._data += content + bytes(-len(content) % 4)
        return len(self.tree["bufferViews"]) - 1

    def array(self, values: np.ndarray, kind: str, **more: Any) -> int:
        code = {"f": 5126, "B": 5121, "b": 5120, "H": 5123, "h": 5122, "I": 5125}[values.dtype.char]
        entry = {"bufferView": self.view(values.tobytes()), "componentType": code, "count": len(values)}
        self.tree["accessors"].append(entry | {"type": kind} | more)
        return len(self.tree["accessors"]) - 1

    def read(self, folder: Path, name: str = "Square.GLTF") -> Model:
        uri = f"data:application/octet-stream;base64,{b64encode(self._data).decode()}"
        own = {"uri": uri, "byteLength": len(self._data), **self.tree.pop("of_buffer", {})}
        self.tree["buffers"] = [own, *self.more_buffers]
        (folder / name).write_text("\ufeff" + json.dumps(self.tree))
        return read_model(folder / name, most_px=64)


@given(
    turn=st.tuples(numbers, numbers, numbers),
    scale=st.tuples(*[st.sampled_from([-2.0, -1.0, 0.5, 3.0])] * 3),
    place=st.tuples(*[st.floats(-1e7, 1e7)] * 3),
)
def test_a_node_far_off_keeps_its_mesh_and_mirrors_it(
    tmp_path_factory: pytest.TempPathFactory,
    turn: tuple[float, float, float],
    scale: tuple[float, float, float],
    place: tuple[float, float, float],
) -> None:
    """Positions are those of double precision, and fronts stay fronts where axes are mirrored."""
    made, rotation = Tree(), Rotation.from_rotvec(turn)
    made.tree["nodes"][0] |= {"rotation": rotation.as_quat().tolist(), "scale": scale, "translation": place}
    made.primitive["attributes"]["NORMAL"] = made.array(np.tile(np.float32([0, 0, 1]), (4, 1)), "VEC3")
    (surface,) = made.read(tmp_path_factory.mktemp("g")).surfaces
    np.testing.assert_allclose(surface.vertices, rotation.apply(SQUARE * scale) + place, atol=1e-6)
    a, b, c = surface.vertices[surface.triangles[0]] - place
    assert surface.normals is not None
    assert np.cross(b - a, c - a) @ surface.normals[0] > 0


@given(places=st.lists(st.tuples(numbers, numbers, numbers), min_size=1, max_size=5))
def test_instances_are_copies(
    tmp_path_factory: pytest.TempPathFactory, places: list[tuple[float, float, float]]
) -> None:
    made = Tree()
    attributes = {"TRANSLATION": made.array(np.array(places, "<f4"), "VEC3")}
    made.tree["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    made.tree["extensionsRequired"] = ["EXT_mesh_gpu_instancing"]
    model = made.read(tmp_path_factory.mktemp("g"))
    assert len(model.surfaces) == len(places)
    for surface, place in zip(model.surfaces, places, strict=True):
        np.testing.assert_allclose(surface.vertices, SQUARE + np.float32(place), atol=1e-5)


@given(weight=st.floats(0, 1, width=32), of_node=st.booleans())
def test_morph_targets_move_vertices_by_their_weights(
    tmp_path_factory: pytest.TempPathFactory, weight: float, of_node: bool
) -> None:
    made = Tree()
    made.primitive["targets"] = [{"POSITION": made.array(np.tile(np.float32([0, 0, 2]), (4, 1)), "VEC3")}]
    holder = made.tree["nodes"][0] if of_node else made.tree["meshes"][0]
    holder["weights"] = [weight]
    (surface,) = made.read(tmp_path_factory.mktemp("g")).surfaces
    np.testing.assert_allclose(surface.vertices, SQUARE + np.array([0, 0, 2 * weight]), atol=1e-6)


def test_figures_stand_where_their_bones_are(tmp_path: Path) -> None:
    """Bound in centimetres, under an armature that scales to metres, with one bone bent up."""
    made = Tree()
    made.tree["nodes"] = [
        {"name": "figure", "mesh": 0, "skin": 0, "translation": [50, 0, 0]},
        {"name": "armature", "scale": [0.01] * 3, "children": [2]},
        {"name": "hip", "children": [3]},
        {"name": "arm", "translation": [0, 0, 300]},
    ]
    made.tree["scenes"] = [{"nodes": [0, 1]}]
    centimetres = np.tile(np.diag(np.float32([100, 100, 100, 1])).reshape(1, 16), (2, 1))
    made.tree["skins"] = [{"joints": [2, 3], "inverseBindMatrices": made.array(centimetres, "MAT4")}]
    bones, weights = np.zeros((4, 4), "u1"), np.zeros((4, 4), "<f4")
    bones[2:, 0], weights[:, 0] = 1, 1
    made.primitive["attributes"] |= {
        "JOINTS_0": made.array(bones, "VEC4"),
        "WEIGHTS_0": made.array(weights, "VEC4"),
    }
    (surface,) = made.read(tmp_path).surfaces
    np.testing.assert_allclose(
        surface.vertices, SQUARE + np.array([[0, 0, 0]] * 2 + [[0, 0, 3]] * 2), atol=1e-6
    )


def test_hidden_nodes_are_not_there(tmp_path: Path) -> None:
    made = Tree()
    made.tree["nodes"] = [
        {"mesh": 0},
        {"extensions": {"KHR_node_visibility": {"visible": False}}, "children": [2]},
        {"mesh": 0, "name": "hidden"},
    ]
    made.tree["scenes"] = [{"nodes": [0, 1]}]
    assert len(made.read(tmp_path).surfaces) == 1


def test_meshes_packed_by_draco_are_read(tmp_path: Path) -> None:
    draco = pytest.importorskip("DracoPy")
    uv = SQUARE[:, :2].astype(np.float64)
    packed = draco.encode(
        SQUARE,
        np.array([[0, 1, 2], [0, 2, 3]], "u4"),
        tex_coord=uv,
        quantization_bits=20,
        compression_level=0,
    )
    by_kind = {each["attribute_type"]: each for each in draco.decode(packed).attributes}
    made = Tree()
    names = {"POSITION": 0, "TEXCOORD_0": 3}
    for name, kind in names.items():
        count, width = len(by_kind[kind]["data"]), by_kind[kind]["num_components"]
        made.tree["accessors"].append({"componentType": 5126, "count": count, "type": f"VEC{width}"})
        made.primitive["attributes"][name] = len(made.tree["accessors"]) - 1
    ids = {name: by_kind[kind]["unique_id"] for name, kind in names.items()}
    extension = "KHR_draco_mesh_compression"
    made.primitive["extensions"] = {extension: {"bufferView": made.view(packed), "attributes": ids}}
    made.tree |= {"extensionsRequired": [extension], "extensionsUsed": [extension]}
    model = made.read(tmp_path)
    (surface,) = model.surfaces
    corners = surface.vertices[surface.triangles]
    assert np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    ).sum() == (pytest.approx(2, abs=1e-4))
    assert surface.uv is not None
    np.testing.assert_allclose(
        surface.uv, np.column_stack([surface.vertices[:, 0], 1 - surface.vertices[:, 1]]), atol=1e-4
    )
    assert model.notes == ()


@pytest.mark.parametrize("library", [None, "spoilt"])
def test_draco_without_its_library_or_whole_data_is_a_fault(
    library: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, extension = Tree(), "KHR_draco_mesh_compression"
    made.tree["accessors"].append({"componentType": 5126, "count": 4, "type": "VEC3"})
    made.primitive["attributes"]["POSITION"] = len(made.tree["accessors"]) - 1
    packed = {"bufferView": made.view(b"DRACO and no more"), "attributes": {"POSITION": 0}}
    made.primitive["extensions"] = {extension: packed}
    if library is None:
        monkeypatch.setitem(sys.modules, "DracoPy", None)
    else:
        pytest.importorskip("DracoPy")
    with pytest.raises(UserError, match=r"tacos-framework\[draco\]" if library is None else "cannot be read"):
        made.read(tmp_path)


@pytest.mark.parametrize("stands_in", [False, True])
def test_meshes_packed_by_meshopt_are_read_where_plain_ones_stand_beside_them(
    stands_in: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "meshopt", None)
    made, extension = Tree(), "EXT_meshopt_compression"
    for view in made.tree["bufferViews"]:
        view["extensions"] = {extension: {"buffer": 0, "byteLength": 4, "byteStride": 12, "count": 1}}
    made.tree["extensionsUsed"] = [extension]
    if not stands_in:
        assert len(made.read(tmp_path).surfaces) == 1
        return
    made.tree["of_buffer"] = {"extensions": {extension: {"fallback": True}}}
    with pytest.raises(UserError, match=r"tacos-framework\[meshopt\].*gltfpack without -c"):
        made.read(tmp_path)


def packed_by_meshopt(meshopt: Any, indices: np.ndarray, mode: str) -> Tree:
    """A square whose positions are halves of single precision and whose indices are of a mode."""
    made, extension = Tree(), "EXT_meshopt_compression"
    made.tree |= {"extensionsRequired": [extension], "extensionsUsed": [extension]}
    for name, values, way in (("POSITION", 2 * SQUARE, "ATTRIBUTES"), ("indices", indices, mode)):
        data = made.view(meshopt.encode_gltf_buffer(values, way))
        view = made.tree["bufferViews"][data]
        stride = values.nbytes // len(values)
        packed = {**view, "byteStride": stride, "count": len(values), "mode": way}
        plain = {"buffer": 1, "byteLength": values.nbytes, "extensions": {extension: packed}}
        made.tree["bufferViews"].append(plain)
        kind, code = ("VEC3", 5126) if name == "POSITION" else ("SCALAR", 5123)
        entry = {"bufferView": data + 1, "componentType": code, "count": len(values), "type": kind}
        made.tree["accessors"].append(entry)
        holder = made.primitive["attributes"] if name == "POSITION" else made.primitive
        holder[name] = len(made.tree["accessors"]) - 1
    made.more_buffers = [{"byteLength": 60, "extensions": {extension: {"fallback": True}}}]
    return made


@pytest.mark.parametrize("mode", ["TRIANGLES", "INDICES"])
def test_meshes_packed_by_meshopt_are_read(mode: str, tmp_path: Path) -> None:
    meshopt = pytest.importorskip("meshopt")
    model = packed_by_meshopt(meshopt, np.array([0, 1, 2, 0, 2, 3], "<u2"), mode).read(tmp_path)
    (surface,) = model.surfaces
    doubled = np.sort((2 * SQUARE)[[0, 1, 2, 0, 2, 3]], axis=0)
    np.testing.assert_allclose(np.sort(surface.vertices[surface.triangles].reshape(-1, 3), axis=0), doubled)
    assert model.notes == ()


def test_spoilt_meshopt_is_a_fault(tmp_path: Path) -> None:
    pytest.importorskip("meshopt")
    made, extension = Tree(), "EXT_meshopt_compression"
    packed = {"buffer": 0, "byteLength": 8, "byteStride": 12, "count": 4, "mode": "ATTRIBUTES"}
    made.tree["bufferViews"][1]["extensions"] = {extension: packed}
    made.tree["of_buffer"] = {"extensions": {extension: {"fallback": True}}}
    with pytest.raises(UserError, match="cannot be unpacked"):
        made.read(tmp_path)


KTX2 = (
    "q0tUWCAyMLsNChoKAAAAAAEAAAAEAAAABAAAAAAAAAAAAAAAAQAAAAEAAAACAAAAaAAAACwAAACUAAAAJAAAAAAAAAAAAAAA"
    "AAAAAAAAAAC4AAAAAAAAABkAAAAAAAAAEAAAAAAAAAAsAAAAAAAAAAIAKACmAQIAAwMAABAAAAAAAAAAAAB/AAAAAAAAAAAA"
    "/////x8AAABLVFh3cml0ZXIAQmFzaXMgVW5pdmVyc2FsIDIuMTAAACi1L/0gEIEAABcZReu/peEAAAAAAAAAAAA="
)
"""4 x 4 pixels of (200, 40, 90)."""


@pytest.mark.parametrize("library", [True, False])
def test_textures_of_ktx2_are_their_colours(
    library: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, extension = Tree(), "KHR_texture_basisu"
    made.tree["images"] = [{"bufferView": made.view(b64decode(KTX2)), "mimeType": "image/ktx2"}]
    made.tree |= {"textures": [{"extensions": {extension: {"source": 0}}}], "extensionsRequired": [extension]}
    made.tree["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    made.primitive["material"] = 0
    if not library:
        monkeypatch.setitem(sys.modules, "opengl_basisu", None)
        with pytest.raises(UserError, match=r"tacos-framework\[ktx2\].*gltfpack without -tc"):
            made.read(tmp_path)
        return
    pytest.importorskip("opengl_basisu")
    texture = made.read(tmp_path).skins[0].texture
    assert texture is not None
    np.testing.assert_allclose(texture[2, 2], (200, 40, 90), atol=6)


@pytest.mark.parametrize("suffix", ["webp", "png", "jpg", "bmp", "tif", "tga", "dds", "gif"])
def test_textures_of_any_format_and_depth_are_their_colours(suffix: str, tmp_path: Path) -> None:
    made, content = Tree(), io.BytesIO()
    picture = Image.new("RGB", (8, 8), (200, 40, 90))
    picture.save(
        content,
        {"jpg": "jpeg", "tif": "tiff"}.get(suffix, suffix),
        **({"lossless": True} if suffix == "webp" else {}),
    )
    made.tree["images"] = [{"bufferView": made.view(content.getvalue()), "mimeType": f"image/{suffix}"}]
    source = {"extensions": {"EXT_texture_webp": {"source": 0}}} if suffix == "webp" else {"source": 0}
    made.tree |= {"textures": [source], "extensionsUsed": ["EXT_texture_webp"] if suffix == "webp" else []}
    made.tree["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    made.primitive["material"] = 0
    texture = made.read(tmp_path).skins[0].texture
    assert texture is not None
    np.testing.assert_allclose(texture[4, 4], (200, 40, 90), atol=4)


def test_greys_of_sixteen_bits_are_not_clipped(tmp_path: Path) -> None:
    made, content = Tree(), io.BytesIO()
    Image.fromarray(np.full((4, 4), 0x8000, np.uint16)).save(content, "png")
    made.tree["images"] = [{"bufferView": made.view(content.getvalue())}]
    made.tree |= {"textures": [{"source": 0}]}
    made.tree["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    made.primitive["material"] = 0
    texture = made.read(tmp_path).skins[0].texture
    assert texture is not None
    assert set(texture.ravel()) == {128}


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"cameras": [{}]}, "cameras of the file"),
        ({"scenes": [{"nodes": [0]}, {}]}, "default of 2 scenes"),
        (
            {"extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "range": 3}]}}},
            "spots shine as small squares",
        ),
        (
            {
                "materials": [
                    {
                        "name": "m",
                        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
                        "normalTexture": {"index": 0, "texCoord": 1},
                    }
                ]
            },
            "m: textures with coordinates of their own",
        ),
    ],
)
def test_what_has_no_effect_is_said(more: dict[str, Any], said: str, tmp_path: Path) -> None:
    made, content = Tree(), io.BytesIO()
    Image.new("RGB", (2, 2)).save(content, "png")
    made.tree["images"] = [{"bufferView": made.view(content.getvalue())}]
    made.tree |= {"textures": [{"source": 0}], **more}
    assert any(said in note for note in made.read(tmp_path).notes)


def test_points_without_faces_are_told_as_such(tmp_path: Path) -> None:
    made = Tree()
    made.primitive |= {"mode": 0}
    with pytest.raises(UserError, match="a cloud of 4 points, without faces"):
        made.read(tmp_path)


def test_polygons_of_triangles_are_read(tmp_path: Path) -> None:
    made = Tree()
    made.tree["extensionsRequired"] = ["FB_ngon_encoding"]
    assert made.read(tmp_path).triangle_count == 2


def test_vertices_far_from_the_origin_of_their_node_are_told_to_be_rounded(tmp_path: Path) -> None:
    made = Tree()
    made.primitive["attributes"]["POSITION"] = made.array(SQUARE + np.float32([5411932.6, 0, 0]), "VEC3")
    assert "look rounded to 0.5" in " ".join(made.read(tmp_path).notes)


def test_binary_files_of_the_first_version_are_named(tmp_path: Path) -> None:
    (tmp_path / "old.glb").write_bytes(b"glTF" + struct.pack("<IIII", 1, 24, 4, 0) + b"{}  ")
    with pytest.raises(UserError, match=r"glTF 1\.0, not glTF 2\.0"):
        read_model(tmp_path / "old.glb", most_px=64)


@settings(max_examples=20, deadline=None)
@given(away=st.tuples(*[st.floats(-1e7, 1e7)] * 3))
def test_a_far_node_is_recentred_before_single_precision(
    tmp_path_factory: pytest.TempPathFactory, away: tuple[float, float, float]
) -> None:
    made, folder = Tree(), tmp_path_factory.mktemp("g")
    made.tree["nodes"][0] |= {"translation": away, "scale": [4, 4, 4]}
    made.read(folder)
    read = read_world(folder / "Square.GLTF", up="auto", metres_per_unit=1.0, leave_out=(), most_px=64)
    single = (read.model.surfaces[0].vertices @ read.turn.T).astype(np.float32).astype(
        np.float64
    ) + read.origin_m
    np.testing.assert_allclose(single, (SQUARE * 4.0 + away) @ read.turn.T, atol=1e-3)


@pytest.mark.parametrize("uri", ["oak%20floor.png", "C:\\maps\\oak floor.png"])
def test_pictures_that_are_not_there_are_told_and_drawn_plain(uri: str, tmp_path: Path) -> None:
    made = Tree()
    made.primitive["material"] = 0
    info = {"index": 0}
    look = {"baseColorTexture": info, "baseColorFactor": [0.8, 1, 1, 1]}
    made.tree |= {"images": [{"uri": uri}], "textures": [{"source": 0}]}
    made.tree["materials"] = [{"pbrMetallicRoughness": look, "normalTexture": info}]
    model = made.read(tmp_path)
    assert model.skins[0].texture is model.skins[0].normal_map is None
    assert model.skins[0].base_colour.tolist() == [0.4, 0.5, 0.5]
    assert len(model.notes) == 1
    assert model.notes[0].endswith("floor.png', which is not there: what it is a picture of is drawn plain")


def test_time_of_reading_grows_with_the_number_of_things_not_its_square(tmp_path: Path) -> None:
    """A building from BIM is a node and a mesh for every door and pipe: 20,000 take two seconds here."""
    made, things = Tree(), 20_000
    made.tree["meshes"] *= things
    made.tree["nodes"] = [{"mesh": number} for number in range(things)]
    made.tree["scenes"] = [{"nodes": list(range(things))}]
    began_s = time.process_time()
    assert made.read(tmp_path).triangle_count == 2 * things
    assert time.process_time() - began_s < 10
