"""Furniture from a user's folder, and what can be wrong with it."""

from __future__ import annotations

import json
import struct
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

from tacos_framework.errors import UserError
from tacos_worlds.indoor.scene import IndoorScene
from tacos_worlds.indoor.user_models import MAX_TRIANGLES, UserModels, load_user_models


def save(folder: Path, name: str, mesh: trimesh.Trimesh) -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    mesh.export(path)
    return path


def textured_box(extents: tuple[float, float, float]) -> trimesh.Trimesh:
    box = trimesh.creation.box(extents)
    image = Image.fromarray(np.full((30, 50, 3), (200, 40, 40), np.uint8))
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=image, roughnessFactor=0.3)
    box.visual = trimesh.visual.TextureVisuals(
        uv=np.random.default_rng(0).uniform(size=(8, 2)), material=material
    )
    return box


def faults_of(folder: Path) -> str:
    with pytest.raises(UserError) as error:
        load_user_models(str(folder))
    return str(error.value)


def test_models_replace_the_furniture_of_their_class(tmp_path: Path) -> None:
    save(tmp_path, "sofa/red.glb", textured_box((2.0, 0.8, 0.9)))  # y is up
    save(tmp_path, "toy/brick.obj", trimesh.creation.box((30, 20, 20)))
    config = IndoorScene.Config(size_m=(10, 5), frames=2, furniture_folder=str(tmp_path), clutter=1.0)
    world = IndoorScene(config).episode(rng=np.random.default_rng(2), illumination_lux=20.0).world
    sofas = [n for n, thing in enumerate(world.objects) if thing.class_name == "sofa"]
    assert sofas
    for number in sofas:
        (part,) = (p for p in world.parts if p.object_id == number)
        assert len(part.triangles) == 12
        assert np.ptp(part.vertices_m[:, 2]) == pytest.approx(
            np.ptp(part.vertices_m, axis=0).max() * 0.4, rel=0.01
        )
        texture = world.materials[part.material].texture
        assert texture is not None
        assert texture.shape == (256, 256, 3)
        assert texture[0, 0].tolist() == [200, 40, 40]
    for number, thing in enumerate(world.objects):
        if thing.class_name == "toy":
            size = np.ptp(
                np.concatenate([p.vertices_m for p in world.parts if p.object_id == number]), axis=0
            )
            assert 0.1 < size.max() < 0.6  # 30 m of the file, scaled to a toy


def test_the_front_of_a_model_faces_the_room(tmp_path: Path) -> None:
    wedge = trimesh.creation.box((1.8, 0.4, 0.8))
    back = trimesh.creation.box((1.8, 0.9, 0.1), trimesh.transformations.translation_matrix([0, 0.2, -0.35]))
    save(tmp_path, "sofa/plain.glb", trimesh.util.concatenate([wedge, back]))
    (model,) = load_user_models(str(tmp_path)).pieces["sofa"]
    points = np.concatenate([mesh.vertices_m for mesh, _ in model.parts])
    assert points[points[:, 2] > 0.6, 1].max() < 0  # the high back stands at -y


def one_of(folder: Path, name: str, change: Callable[[dict[str, Any]], None]) -> UserModels:
    """A box of furniture whose header was changed after export."""
    box = textured_box((1.0, 1.0, 1.0))
    gltf = trimesh.exchange.gltf.export_glb(trimesh.Scene(box), tree_postprocessor=change)
    (folder / "table").mkdir(parents=True)
    (folder / "table" / name).write_bytes(gltf)
    return load_user_models(str(folder))


def test_masks_cut_furniture_and_what_is_left_out_is_said(tmp_path: Path) -> None:
    box = textured_box((1.0, 1.0, 1.0))
    bars = np.zeros((16, 16, 4), np.uint8)
    bars[:, ::2] = 255
    uv = np.tile(np.array([[0, 0], [0, 1], [1, 0], [1, 1]], float), (2, 1))
    material = trimesh.visual.material.PBRMaterial(
        baseColorTexture=Image.fromarray(bars),
        normalTexture=Image.fromarray(np.full((4, 4, 3), 128, np.uint8)),
        alphaMode="MASK",
        alphaCutoff=0.5,
    )
    box.visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    save(tmp_path, "table/grille.glb", box)
    models = load_user_models(str(tmp_path))
    (grille,) = models.pieces["table"]
    (mesh, _) = grille.parts[0]
    a, b, c = (mesh.vertices_m[mesh.triangles[:, corner]] for corner in range(3))
    assert 0 < np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 < 0.6 * 6
    assert models.notes == ["table/grille.glb: normal maps of furniture are not drawn: surfaces are smooth"]


def test_colours_of_vertices_multiply_the_material(tmp_path: Path) -> None:
    box = trimesh.creation.box((1.0, 1.0, 1.0))
    box.visual = trimesh.visual.ColorVisuals(box, vertex_colors=np.tile([255, 0, 0, 255], (8, 1)))
    save(tmp_path, "toy/red.glb", box)
    (toy,) = load_user_models(str(tmp_path)).pieces["toy"]
    assert toy.parts[0][1].tint == pytest.approx((1.0, 0.0, 0.0), abs=0.01)


def test_transforms_of_textures_move_those_of_furniture(tmp_path: Path) -> None:
    def halved(tree: dict[str, Any]) -> None:
        info = tree["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]
        info["extensions"] = {"KHR_texture_transform": {"scale": [0.5, 0.5]}}

    plain, moved = (
        one_of(tmp_path / name, "a.glb", change).pieces["table"][0].parts[0][0].uv_m
        for name, change in (("plain", lambda tree: None), ("moved", halved))
    )
    np.testing.assert_allclose(moved[:, 0], plain[:, 0] / 2, atol=1e-6)


def test_packed_furniture_names_the_setting_of_the_export(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def packed(tree: dict[str, Any]) -> None:
        view = tree["bufferViews"][0]
        how = {"byteLength": view["byteLength"], "byteStride": 4, "count": 1, "mode": "ATTRIBUTES"}
        view["extensions"] = {"EXT_meshopt_compression": {"buffer": 0, **how}}
        tree["buffers"][0]["extensions"] = {"EXT_meshopt_compression": {"fallback": True}}
        tree["extensionsRequired"] = ["EXT_meshopt_compression"]

    monkeypatch.setitem(sys.modules, "meshopt", None)
    with pytest.raises(UserError, match="gltfpack without -c"):
        one_of(tmp_path, "a.glb", packed)


def test_a_model_that_is_inside_out_is_turned(tmp_path: Path) -> None:
    box = trimesh.creation.box((1.0, 1.0, 1.0))
    box.invert()
    save(tmp_path, "toy/a.obj", box)
    (mesh, _) = load_user_models(str(tmp_path)).pieces["toy"][0].parts[0]
    a, b, c = (mesh.vertices_m[mesh.triangles[:, corner]] - [0, 0, 0.5] for corner in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(1)
    assert (np.einsum("ij,ij->i", mesh.normals, mesh.vertices_m - [0, 0, 0.5]) > 0).all()


def test_all_faults_are_told_at_once(tmp_path: Path) -> None:
    (tmp_path / "couch").mkdir()
    (tmp_path / "sofa").mkdir()
    (tmp_path / "sofa" / "broken.glb").write_bytes(b"not a model at all, sorry")
    (tmp_path / "sofa" / "short.glb").write_bytes(b"glTF")
    (tmp_path / "sofa" / "empty.obj").write_text("# nothing\n")
    save(tmp_path, "toy/huge.glb", trimesh.creation.icosphere(5))
    message = faults_of(tmp_path)
    assert "couch" in message
    assert "Known names" in message or "Did you mean" in message
    for name in ("broken.glb", "short.glb", "empty.obj"):
        assert name in message
    assert f"20480 triangles\n  expected: at most {MAX_TRIANGLES}" in message


def test_no_file_outside_the_folder_is_read(tmp_path: Path) -> None:
    folder = tmp_path / "models"
    secret = tmp_path / "secret.mtl"
    secret.write_text("newmtl m\n")
    secret.with_suffix(".png").write_bytes(b"")
    (folder / "sofa").mkdir(parents=True)
    obj = "mtllib ../../secret.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    (folder / "sofa" / "escape.obj").write_text(obj)
    (folder / "sofa" / "texture.obj").write_text(obj.replace("../../secret.mtl", "inside.mtl"))
    (folder / "sofa" / "inside.mtl").write_text("newmtl m\nmap_Kd /etc/hostname\n")
    (folder / "sofa" / "link.obj").symlink_to(secret)
    named = {"images": [{"uri": "../../secret.png"}], "textures": [{"source": 0}]}
    look = {"materials": [{"normalTexture": {"index": 0}}]}
    tree = json.dumps({"asset": {"version": "2.0"}, **named, **look}).encode()
    tree += b" " * (-len(tree) % 4)
    header = struct.pack("<III", 0x46546C67, 2, 20 + len(tree)) + struct.pack("<II", len(tree), 0x4E4F534A)
    (folder / "sofa" / "outside.glb").write_bytes(header + tree)
    message = faults_of(folder)
    assert message.count(f"outside of {folder}") == 3
    assert f"link.obj: link.obj leads out of {folder}" in message


def test_a_missing_buffer_is_named(tmp_path: Path) -> None:
    (tmp_path / "bed").mkdir()
    view = {"buffer": 0, "byteLength": 36}
    points = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}
    tree = {
        "asset": {"version": "2.0"}, "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "accessors": [points],
        "bufferViews": [view], "buffers": [{"uri": "gone.bin", "byteLength": 36}],
    }  # fmt: skip
    content = json.dumps(tree).encode()
    content += b" " * (-len(content) % 4)
    head = struct.pack("<IIIII", 0x46546C67, 2, 20 + len(content), len(content), 0x4E4F534A)
    (tmp_path / "bed" / "a.glb").write_bytes(head + content)
    assert "'gone.bin', which does not exist" in faults_of(tmp_path)


def test_vertices_that_are_not_finite_are_refused(tmp_path: Path) -> None:
    (tmp_path / "bed").mkdir()
    (tmp_path / "bed" / "nan.obj").write_text("v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert "nan.obj" in faults_of(tmp_path)


def test_an_empty_or_absent_folder_is_a_fault(tmp_path: Path) -> None:
    assert "holds no models" in faults_of(tmp_path)
    assert "is not a folder" in faults_of(tmp_path / "nowhere")
    with pytest.raises(UserError):
        IndoorScene(IndoorScene.Config(furniture_folder=str(tmp_path / "nowhere")))
