"""Readers of files, against what is known of them."""

from __future__ import annotations

import json
from base64 import b64encode
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tacos_framework.errors import UserError
from tacos_view.pictures import png_uri
from tacos_worlds.imported.formats.file_bytes import Unreadable
from tacos_worlds.imported.formats.poses import read_poses
from tacos_worlds.imported.lamps import SUN_DISTANCE_M, of_file
from tacos_worlds.imported.reader import read_world
from tacos_worlds.imported.recorded import read_recorded
from tacos_worlds.imported.sky import read_surroundings
from tacos_worlds.kit.mesh_files import read_model


def gltf(folder: Path, **more: object) -> Path:
    """A triangle below a turned and scaled node, with a lamp that shines down."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 0, -1]], "<f4")
    (folder / "corners.bin").write_bytes(corners.tobytes())
    tree = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "corners.bin", "byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "materials": [
            {
                "emissiveFactor": [1, 0.5, 0],
                "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 40}},
            }
        ],
        "meshes": [{"name": "slab", "primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "nodes": [
            {"name": "flat", "scale": [2, 2, 2], "children": [1, 2], "extras": {"storey": 1}},
            {"name": "kitchen", "mesh": 0, "translation": [0, 1, 0]},
            {
                "name": "lamp",
                "rotation": Rotation.from_euler("x", -90, degrees=True).as_quat().tolist(),
                "extensions": {"KHR_lights_punctual": {"light": 0}},
            },
        ],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 500.0}]}},
        "scenes": [{"nodes": [0]}],
        **more,
    }
    file = folder / "flat.gltf"
    file.write_text(json.dumps(tree), encoding="utf-8")
    return file


def test_gltf_names_places_extras_emission_and_lights(tmp_path: Path) -> None:
    model = read_model(gltf(tmp_path), most_px=1024)
    (surface,) = model.surfaces
    assert surface.path == ("flat", "kitchen", "slab")
    assert surface.extras == {"storey": 1}
    assert surface.vertices == pytest.approx(np.array([[0, 2, 0], [2, 2, 0], [0, 2, -2]]))
    assert model.skins[0].emission == pytest.approx([40, 20, 0])
    (light,) = model.lights
    assert light.direction == pytest.approx([0, -1, 0])
    y_up_to_z_up = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    (star,) = of_file(model.lights, y_up_to_z_up)
    assert star.position_m == pytest.approx([0, 0, SUN_DISTANCE_M], abs=1e-6)
    assert star.flux_lm / (4 * np.pi * SUN_DISTANCE_M**2) == pytest.approx(np.full(3, 500.0))  # lux


@pytest.mark.parametrize("normalised", [True, False])
def test_whole_numbers_of_a_quantised_mesh_are_scaled_by_the_transform_of_its_texture(
    normalised: bool, tmp_path: Path
) -> None:
    """As gltfpack writes them: 12 bits in 16, not said to stand for 0..1."""
    given = np.array([[0, 0], [4095, 0], [0, 2048]], "<u2")
    scale = 65535 / 4095 if normalised else 1 / 4095
    moved = {"KHR_texture_transform": {"scale": [2 * scale, scale]}}
    file = gltf(
        tmp_path,
        extensionsRequired=["KHR_mesh_quantization", "KHR_texture_transform"],
        buffers=[
            {"uri": "corners.bin", "byteLength": 36},
            {"uri": f"data:;base64,{b64encode(given.tobytes()).decode()}", "byteLength": 12},
        ],
        bufferViews=[{"buffer": 0, "byteLength": 36}, {"buffer": 1, "byteLength": 12}],
        accessors=[
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "VEC2", "normalized": normalised},
        ],
        meshes=[{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
        materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions": moved}}}],
        textures=[{"source": 0}],
        images=[{"uri": png_uri(np.zeros((2, 2, 3), np.uint8))}],
    )
    (surface,) = read_model(file, most_px=64).surfaces
    assert surface.uv is not None
    assert surface.uv == pytest.approx(np.array([[0, 1], [2, 1], [0, 1 - 2048 / 4095]]))


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"extensionsRequired": ["ACME_fur"]}, "needs ACME_fur"),
        (
            {"accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}]},
            "beyond",
        ),
        ({"buffers": [{"uri": "corners.bin", "byteLength": 99}]}, "cut short"),
        ({"nodes": [{"children": [0]}]}, "more than once"),
        (
            {"nodes": [{"children": [1, 1]}, {"children": [2, 2]}, {"mesh": 0}]},
            r"node 2 stands in .* more than",
        ),
        ({"nodes": [*({"children": [i + 1]} for i in range(300)), {"mesh": 0}]}, "more than 200 deep"),
        ({"asset": {"version": "1.0"}}, "not glTF 2.0"),
    ],
)
def test_gltf_that_claims_what_is_not_there(more: dict[str, object], said: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=said):
        read_model(gltf(tmp_path, **more), most_px=1024)


@pytest.mark.parametrize(
    "more", [{"nodes": [{"children": 5}]}, {"nodes": [{"extensions": 3}]}, {"meshes": [{"primitives": "x"}]}]
)
def test_a_tree_of_other_kinds_of_values_is_a_fault(more: dict[str, object], tmp_path: Path) -> None:
    file = gltf(tmp_path, **{"nodes": [{"mesh": 0}], **more})
    with pytest.raises(UserError, match="cannot be read"):
        read_world(file, up="auto", metres_per_unit=1.0, leave_out=(), most_px=64)


def test_triangles_are_counted_before_any_is_read_those_of_a_mesh_as_often_as_it_stands_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = gltf(tmp_path, nodes=[{"children": [*range(1, 21)]}, *({"mesh": 0} for _ in range(20))])
    assert len(read_model(file, most_px=64).surfaces) == 20
    monkeypatch.setenv("TACOS_LIMITS", "mesh_triangles=19")
    with pytest.raises(UserError, match=r"(?s)at least 20 triangles.*TACOS_LIMITS=mesh_triangles=21"):
        read_model(file, most_px=64)


def test_one_path_in_three_formats_is_one_path(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    time_s = np.arange(6) * 0.1
    turns, places = Rotation.random(6, rng=rng), rng.normal(size=(6, 3))
    x, y, z, w = turns.as_quat().T
    matrices = np.concatenate([turns.as_matrix(), places[:, :, None]], axis=2).reshape(6, 12)
    files = {
        "tum": np.column_stack([time_s, places, x, y, z, w]),
        "euroc": np.column_stack([time_s * 1e9, places, w, x, y, z, np.zeros((6, 9))]),
        "kitti": matrices,
    }
    for form, table in files.items():
        file = tmp_path / f"{form}.txt"
        np.savetxt(file, table, delimiter="," if form == "euroc" else " ", header="a comment", fmt="%.12f")
        found = read_poses(file)
        assert found.form == form
        assert found.time_s == pytest.approx(time_s)
        assert found.poses[:, :3, :3] == pytest.approx(turns.as_matrix(), abs=1e-9)
        assert found.poses[:, :3, 3] == pytest.approx(places, abs=1e-9)


@pytest.mark.parametrize(
    "rotation",
    ["1 0 0 {} 0 11 0 {} 0 0 1 {}", "1 0 0 {} 0 0 0 {} 0 0 1 {}", "-1 0 0 {} 0 1 0 {} 0 0 1 {}"],
    ids=["scaled", "flat", "mirrored"],
)
def test_a_matrix_that_is_no_rotation_is_named(tmp_path: Path, rotation: str) -> None:
    file = tmp_path / "poses.txt"
    file.write_text("1 0 0 0 0 1 0 0 0 0 1 0\n" + rotation.format(1, 2, 3), encoding="utf-8")
    with pytest.raises(Unreadable, match="pose 2 has a matrix that is no rotation"):
        read_poses(file)


def test_a_camera_that_looks_level_is_an_agent_that_looks_level(tmp_path: Path) -> None:
    # In glTF's axes: y up, the camera at 1.6 m looking along -z, its own y axis down.
    file = tmp_path / "poses.txt"
    file.write_text("0 0 1.6 0 1 0 0 0\n1 0 1.6 -1 1 0 0 0\n", encoding="utf-8")
    turn = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    path, doubts = read_recorded(file, turn, np.zeros(3), of_camera=True)
    pose = path.at(np.array([1.0]))[0]
    assert not doubts
    assert pose[:3, 3] == pytest.approx([0, 1, 1.6])
    assert pose[:3, 0] == pytest.approx([0, 1, 0], abs=1e-9)  # ahead is +y, the way it goes
    assert pose[:3, 2] == pytest.approx([0, 0, 1], abs=1e-9)


@pytest.mark.parametrize("azimuth_deg", [60, 180], ids=["amid", "behind"])
def test_the_sun_of_a_panorama_becomes_a_light_of_its_illuminance(tmp_path: Path, azimuth_deg: int) -> None:
    import cv2

    height, width = 256, 512
    zenith, azimuth = np.radians(40.0), np.radians(azimuth_deg)
    sky = np.full((height, width, 3), 1.0, np.float32)
    row, column = int(zenith / np.pi * height), int((np.pi - azimuth) / (2 * np.pi) * width)
    sky[row : row + 2, [column - 1, column]] = 5000.0  # behind, on either side of the seam
    file = tmp_path / "sky.hdr"
    cv2.imwrite(str(file), sky[..., ::-1])
    found = read_surroundings(file, 0.0)
    assert found.sun is not None
    towards = found.sun.position_m / np.linalg.norm(found.sun.position_m)
    true = np.array([np.sin(zenith) * np.cos(azimuth), np.sin(zenith) * np.sin(azimuth), np.cos(zenith)])
    assert np.degrees(np.arccos(towards @ true)) < 2.0
    solid = 4 * np.sin(zenith) * (np.pi / height) * (2 * np.pi / width)
    lux = found.sun.flux_lm / (4 * np.pi * SUN_DISTANCE_M**2)
    assert lux == pytest.approx(np.full(3, 4999 * solid), rel=0.03)
    assert found.panorama.max() == pytest.approx(1.0, rel=0.02)
    turned = read_surroundings(file, 90.0)
    assert turned.sun is not None
    assert turned.sun.position_m[:2] == pytest.approx(
        [-found.sun.position_m[1], found.sun.position_m[0]], rel=1e-4, abs=1e-4 * SUN_DISTANCE_M
    )
