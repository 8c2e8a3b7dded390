"""Furniture from a folder of the user's own models, in place of the procedural furniture."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
import trimesh
from numpy.typing import NDArray

from tacos_framework import Fault, UserError, did_you_mean
from tacos_worlds.kit.class_names import FURNITURE_CLASSES
from tacos_worlds.kit.finishes import Finish
from tacos_worlds.kit.mesh import Mesh
from tacos_worlds.kit.mesh_files import read_mesh_file
from tacos_worlds.kit.piece import Piece, piece

MAX_TRIANGLES = 6000
"""Triangles of one model, at most: a world holds dozens of pieces and at most 100 000 triangles."""
_TEXTURE_PX = 256
_SUFFIXES = (".glb", ".obj")
_Z_UP_FRONT_Y = np.array([[-1.0, 0, 0], [0, 0, 1], [0, 1, 0]])
"""From glTF's axes (y up, front +z) to those of a piece (z up, front +y)."""


@dataclass
class UserModels:
    """Models by class, and the images that their finishes name by index."""

    pieces: dict[str, list[Piece]] = field(default_factory=dict)
    images: dict[int, NDArray[np.uint8]] = field(default_factory=dict)


def load_user_models(folder: str) -> UserModels:
    """Load ``folder/CLASS/*.glb`` and ``*.obj``; y is up and the front faces +z, as in glTF.

    Files may refer to others (materials, textures) only inside the folder.

    Raises
    ------
    UserError
        With a fault for every file or subfolder that cannot be used.
    """
    root = Path(folder).expanduser().resolve()
    if not root.is_dir():
        raise UserError(
            Fault(
                f"furniture_folder {folder}",
                "is not a folder",
                remedy="Give a folder with CLASS/NAME.glb files.",
            )
        )
    models, faults = UserModels(), []
    for path in sorted(root.iterdir()):
        if not path.is_dir():
            continue
        if path.name not in FURNITURE_CLASSES:
            faults.append(
                Fault(
                    str(path),
                    "is not named after a class of furniture",
                    remedy=did_you_mean(path.name, FURNITURE_CLASSES),
                )
            )
            continue
        for file in sorted(path.iterdir()):
            if file.suffix.lower() not in _SUFFIXES:
                continue
            try:
                loaded = _load(file, root, path.name, models.images)
            except UserError as error:
                faults += error.faults
            else:
                models.pieces.setdefault(path.name, []).append(loaded)
    if not faults and not models.pieces:
        faults.append(
            Fault(
                str(root),
                "holds no models",
                "CLASS/NAME.glb or CLASS/NAME.obj",
                f"Classes: {', '.join(FURNITURE_CLASSES)}.",
            )
        )
    if faults:
        raise UserError(faults)
    return models


def _load(file: Path, root: Path, class_name: str, images: dict[int, NDArray[np.uint8]]) -> Piece:
    scene = read_mesh_file(file, within=root, most_triangles=MAX_TRIANGLES).scene
    meshes = [g for g in scene.dump() if isinstance(g, trimesh.Trimesh) and len(g.faces)]
    count = sum(len(mesh.faces) for mesh in meshes)
    if not count:
        raise UserError(Fault(str(file), "holds no triangles"))
    if count > MAX_TRIANGLES:
        what = f"has {count} triangles"
        raise UserError(Fault(str(file), what, f"at most {MAX_TRIANGLES}", "Simplify the model."))
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    if not np.isfinite(vertices).all() or not np.ptp(vertices, axis=0).max() > 0:
        raise UserError(Fault(str(file), "has vertices that are not finite or all in one place"))
    try:
        return piece(class_name, [(_mesh(mesh), _finish(mesh, images)) for mesh in meshes])
    except (TypeError, ValueError, AttributeError) as error:  # values of extensions, which no header tells
        what = f"has a material that cannot be read: {error}"
        raise UserError(Fault(str(file), what, "", "Export the model again.")) from error


def _mesh(loaded: trimesh.Trimesh) -> Mesh:
    if loaded.is_watertight and loaded.volume < 0:
        loaded.invert()
    uv = getattr(loaded.visual, "uv", None)
    normals = np.asarray(loaded.vertex_normals, dtype=np.float64)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.where(length > 1e-9, normals / np.maximum(length, 1e-9), [0.0, 1.0, 0.0])
    return Mesh(
        np.asarray(loaded.vertices, dtype=np.float64) @ _Z_UP_FRONT_Y.T,
        normals @ _Z_UP_FRONT_Y.T,
        np.zeros((len(normals), 2)) if uv is None else np.asarray(uv, dtype=np.float64),
        np.asarray(loaded.faces, dtype=np.int64),
    )


def _finish(loaded: trimesh.Trimesh, images: dict[int, NDArray[np.uint8]]) -> Finish:
    """The finish of a model's material: base colour and texture, metalness and roughness."""
    material = getattr(loaded.visual, "material", None)
    if isinstance(material, trimesh.visual.material.SimpleMaterial):
        material = material.to_pbr()
    if not isinstance(material, trimesh.visual.material.PBRMaterial):
        return Finish("moulded", (0.5, 0.5, 0.5))
    factor = np.ones(4) if material.baseColorFactor is None else np.asarray(material.baseColorFactor) / 255
    red, green, blue = (float(c) for c in np.clip(factor[:3], 0, 1))
    image = -1
    if material.baseColorTexture is not None and getattr(loaded.visual, "uv", None) is not None:
        image = len(images)
        rgb = np.asarray(material.baseColorTexture.convert("RGB"))[::-1]  # row 0 at v = 0
        scaled = cv2.resize(
            np.ascontiguousarray(rgb), (_TEXTURE_PX, _TEXTURE_PX), interpolation=cv2.INTER_AREA
        )
        images[image] = np.asarray(scaled, dtype=np.uint8)
    return Finish(
        "",
        (red, green, blue),
        roughness=float(0.8 if material.roughnessFactor is None else material.roughnessFactor),
        metallic=float(0.0 if material.metallicFactor is None else material.metallicFactor),
        image=image,
    )
