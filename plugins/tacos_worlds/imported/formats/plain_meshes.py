"""OBJ and PLY, as scanners and mesh programs write them, read by trimesh."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from tacos_worlds.imported.formats.file_bytes import file_bytes, neighbour
from tacos_worlds.imported.formats.gltf_buffers import Damaged
from tacos_worlds.imported.formats.pictures import picture
from tacos_worlds.imported.model import Model, Skin, Surface

_STEPS = np.arange(256) / 255
_LINEAR = np.where(_STEPS <= 0.04045, _STEPS / 12.92, ((_STEPS + 0.055) / 1.055) ** 2.4)
_LEAST_BYTES_PER_VERTEX = 3
"""A header that claims more vertices than its bytes could hold is a lie."""


def read_plain_mesh(file: Path, most_px: int) -> Model:
    """Surfaces and skins of an OBJ (with its MTL) or a PLY file.

    Parameters
    ----------
    most_px
        Longest edge of textures [px].

    Raises
    ------
    Damaged, Unreadable
        Where it cannot be read, or names files that are not there.
    """
    size = len(file_bytes(file))  # whether it may be read at all
    kind = file.suffix.lower()[1:]
    if kind == "obj":
        _check_references(file, most_px)
    else:
        _check_ply_header(file, size)
    options = {"split_objects": True, "group_material": True} if kind == "obj" else {}
    try:
        scene = trimesh.load_scene(file, process=False, **options)
    except (ValueError, KeyError, IndexError, TypeError, AttributeError, OSError, struct.error) as error:
        raise Damaged(f"trimesh cannot read it: {error}") from error
    surfaces: list[Surface] = []
    skins: list[Skin] = []
    for name, mesh in scene.geometry.items():
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            surfaces.append(_surface(str(mesh.metadata.get("name", name)), mesh, len(skins)))
            skins.append(_skin(mesh, most_px))
    return Model(tuple(surfaces), tuple(skins))


def _check_ply_header(file: Path, size: int) -> None:
    with file.open("rb") as stream:
        head = stream.read(65536).split(b"end_header", 1)[0]
    for line in head.splitlines():
        words = line.split()
        if len(words) == 3 and words[0] == b"element":
            if not words[2].isdigit() or int(words[2]) * _LEAST_BYTES_PER_VERTEX > size:
                raise Damaged(f"its header claims {words[2].decode('latin-1')} items, in {size} bytes")


def _check_references(file: Path, most_px: int) -> None:
    """Material libraries and textures lie inside the folder, and can be read."""
    for library in _named(file, ("mtllib",)):
        path = neighbour(file, library)
        for name in _named(path, ("map_kd", "map_ka", "map_bump", "bump")):
            picture(file_bytes(neighbour(path, name)), name, most_px)


def _named(file: Path, keys: tuple[str, ...]) -> list[str]:
    lines = (line.strip() for line in file_bytes(file).decode("utf-8", "replace").splitlines())
    words = (line.split(maxsplit=1) for line in lines)
    found = (pair[1].strip() for pair in words if len(pair) == 2 and pair[0].lower() in keys)
    return [name.split()[-1] if name.startswith("-") else name for name in found]


def _surface(name: str, mesh: trimesh.Trimesh, skin: int) -> Surface:
    uv = getattr(mesh.visual, "uv", None)
    colours = None
    if mesh.visual.kind == "vertex":
        colours = _LINEAR[np.asarray(mesh.visual.vertex_colors)[:, :3]]
    elif mesh.visual.kind == "face":
        colours = _of_faces(mesh)
    has_normals = "vertex_normals" in mesh._cache  # given in the file, not worked out
    normals = np.asarray(mesh.vertex_normals, np.float64) if has_normals else None
    return Surface(
        path=(name,),
        vertices=np.asarray(mesh.vertices, np.float64),
        triangles=np.asarray(mesh.faces, np.int64),
        skin=skin,
        normals=normals,
        uv=None if uv is None or len(uv) != len(mesh.vertices) else np.asarray(uv, np.float64)[:, :2],
        colours=colours,
    )


def _of_faces(mesh: trimesh.Trimesh) -> NDArray[np.float64]:
    """Mean colour of the faces around each vertex."""
    total, count = np.zeros((len(mesh.vertices), 3)), np.zeros((len(mesh.vertices), 1))
    for corner in range(3):
        np.add.at(total, mesh.faces[:, corner], _LINEAR[np.asarray(mesh.visual.face_colors)[:, :3]])
        np.add.at(count, mesh.faces[:, corner], 1)
    return np.asarray(total / np.maximum(count, 1))


def _skin(mesh: trimesh.Trimesh, most_px: int) -> Skin:
    material = getattr(mesh.visual, "material", None)
    if isinstance(material, trimesh.visual.material.SimpleMaterial):
        material = material.to_pbr()
    if not isinstance(material, trimesh.visual.material.PBRMaterial):
        return Skin("colours", np.ones(3) if mesh.visual.defined else np.full(3, 0.5))
    factor = np.ones(4) if material.baseColorFactor is None else np.asarray(material.baseColorFactor) / 255
    image = None
    if material.baseColorTexture is not None:
        loaded = material.baseColorTexture.convert("RGB")
        loaded.thumbnail((most_px, most_px))
        image = np.ascontiguousarray(np.asarray(loaded)[::-1])
    emission = np.zeros(3) if material.emissiveFactor is None else np.asarray(material.emissiveFactor, float)
    roughness = 0.8 if material.roughnessFactor is None else float(material.roughnessFactor)
    return Skin(
        name=str(material.name or ""),
        base_colour=np.clip(np.ones(3) if image is not None else factor[:3], 0, 1),
        opacity=float(factor[3]),
        texture=image,
        roughness=float(np.clip(roughness, 0, 1)),
        emission=emission,
    )
