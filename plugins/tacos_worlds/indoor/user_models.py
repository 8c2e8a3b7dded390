"""Furniture from a folder of the user's own models, in place of the procedural furniture."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
import trimesh
from numpy.typing import NDArray

from tacos_framework.errors import Fault, UserError, did_you_mean
from tacos_worlds.indoor.finishes import Finish
from tacos_worlds.indoor.furnishing.catalogue import FURNITURE_CLASSES
from tacos_worlds.indoor.mesh import Mesh
from tacos_worlds.indoor.piece import Piece, piece

MAX_TRIANGLES = 6000
"""Triangles of one model, at most: a world holds dozens of pieces and at most 100 000 triangles."""
MAX_BYTES = 64 * 2**20
"""Size of one file, at most."""
_TEXTURE_PX = 256
_SUFFIXES = (".glb", ".obj")
_GLB_MAGIC, _GLB_JSON = 0x46546C67, 0x4E4F534A
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
            found = list(_reference_faults(file, root))
            if not found:
                loaded = _load(file, path.name, models.images)
                if isinstance(loaded, Fault):
                    found.append(loaded)
                else:
                    models.pieces.setdefault(path.name, []).append(loaded)
            faults += found
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


def _reference_faults(file: Path, root: Path) -> Iterator[Fault]:
    """What is wrong with where a file lies and what other files it names."""
    if not file.resolve().is_relative_to(root):
        yield Fault(
            str(file), "is a link that leads out of the furniture folder", remedy="Copy the file into it."
        )
        return
    if file.stat().st_size > MAX_BYTES:
        yield Fault(str(file), f"is {file.stat().st_size} bytes long", f"at most {MAX_BYTES}")
        return
    try:
        names = _glb_references(file) if file.suffix.lower() == ".glb" else _obj_references(file, root)
    except (ValueError, struct.error, UnicodeDecodeError) as error:
        yield Fault(str(file), f"cannot be read: {error}", remedy="Export the model again.")
        return
    for name in names:
        target = (file.parent / name).resolve()
        if not target.is_relative_to(root):
            yield Fault(
                str(file),
                f"refers to {name!r}, outside of the furniture folder",
                remedy="Copy that file beside the model.",
            )
        elif not target.is_file():
            yield Fault(
                str(file),
                f"refers to {name!r}, which does not exist",
                remedy="Copy that file beside the model.",
            )


def _glb_references(file: Path) -> list[str]:
    """Names of files that a binary glTF refers to."""
    data = file.read_bytes()
    magic, _, _ = struct.unpack_from("<III", data)
    length, kind = struct.unpack_from("<II", data, 12)
    if magic != _GLB_MAGIC or kind != _GLB_JSON:
        raise ValueError("it is not a binary glTF file")
    tree = json.loads(data[20 : 20 + length])
    if not isinstance(tree, dict):
        raise ValueError("its JSON is not an object")
    entries = [*tree.get("buffers", []), *tree.get("images", [])]
    uris = (str(entry.get("uri", "data:")) for entry in entries)
    return [uri for uri in uris if not uri.startswith("data:")]


def _obj_references(file: Path, root: Path) -> list[str]:
    """Names of material files an OBJ refers to, and of the textures these refer to."""
    libraries = [line.split(maxsplit=1)[1].strip() for line in _lines(file, ("mtllib",))]
    names = list(libraries)
    for library in libraries:
        target = (file.parent / library).resolve()
        if target.is_relative_to(root) and target.is_file():
            names += [line.split()[-1] for line in _lines(target, ("map_", "bump", "disp", "decal", "refl"))]
    return names


def _lines(file: Path, starts: tuple[str, ...]) -> list[str]:
    lines = (line.strip() for line in file.read_text(encoding="utf-8").splitlines())
    return [line for line in lines if line.lower().startswith(starts) and len(line.split()) > 1]


def _load(file: Path, class_name: str, images: dict[int, NDArray[np.uint8]]) -> Piece | Fault:
    try:
        scene = trimesh.load_scene(file)
        meshes = [g for g in scene.dump() if isinstance(g, trimesh.Trimesh) and len(g.faces)]
    except (ValueError, KeyError, IndexError, TypeError, AttributeError, OSError, struct.error) as error:
        return Fault(str(file), f"cannot be read: {error}", remedy="Export the model again.")
    count = sum(len(mesh.faces) for mesh in meshes)
    if not count:
        return Fault(str(file), "holds no triangles")
    if count > MAX_TRIANGLES:
        return Fault(str(file), f"has {count} triangles", f"at most {MAX_TRIANGLES}", "Simplify the model.")
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    if not np.isfinite(vertices).all() or not np.ptp(vertices, axis=0).max() > 0:
        return Fault(str(file), "has vertices that are not finite or all in one place")
    return piece(class_name, [(_mesh(mesh), _finish(mesh, images)) for mesh in meshes])


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
