"""Furniture from a folder of the user's own models, in place of the procedural furniture."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Fault, UserError, did_you_mean
from tacos_worlds.kit.class_names import FURNITURE_CLASSES
from tacos_worlds.kit.finishes import Finish
from tacos_worlds.kit.mesh import Mesh
from tacos_worlds.kit.mesh_files import content_faults, read_model
from tacos_worlds.kit.models.cutouts import cut_out, without_clear
from tacos_worlds.kit.models.hulls import without_hulls
from tacos_worlds.kit.models.model import Model, Skin
from tacos_worlds.kit.models.normals import with_normals
from tacos_worlds.kit.models.patch import Patch, sound, welded
from tacos_worlds.kit.models.tints import tinted
from tacos_worlds.kit.piece import Piece, piece

MAX_TRIANGLES = 6000
"""Triangles of one model, at most: a world holds dozens of pieces and at most 100 000 triangles."""
_TEXTURE_PX = 256
_SUFFIXES = (".glb", ".obj")
_Z_UP_FRONT_Y = np.array([[-1.0, 0, 0], [0, 0, 1], [0, 1, 0]])
"""From glTF's axes (y up, front +z) to those of a piece (z up, front +y)."""


@dataclass
class UserModels:
    """Models by class, the images that their finishes name by index, and what of their files is left out."""

    pieces: dict[str, list[Piece]] = field(default_factory=dict)
    images: dict[int, NDArray[np.uint8]] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


def load_user_models(folder: str) -> UserModels:
    """Load ``folder/CLASS/*.glb`` and ``*.obj``; y is up and the front faces +z, as in glTF.

    Files may refer to others (materials, textures) only inside the folder.

    Raises UserError with a fault for every file or subfolder that cannot be used.
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
                model = _opened(file, root)
                parts = _parts(model, str(file), models.images)
            except UserError as error:
                faults += error.faults
            else:
                models.pieces.setdefault(path.name, []).append(piece(path.name, parts))
                notes = (*model.notes, *_unused(model))
                models.notes += [f"{path.name}/{file.name}: {note}" for note in notes]
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


def _opened(file: Path, root: Path) -> Model:
    read = read_model(file, most_px=_TEXTURE_PX, within=root, most_triangles=MAX_TRIANGLES)
    if faults := [*content_faults(model := without_clear(without_hulls(read)), str(file))]:
        raise UserError(faults)
    return cut_out(model, MAX_TRIANGLES)


def _parts(model: Model, where: str, images: dict[int, NDArray[np.uint8]]) -> list[tuple[Mesh, Finish]]:
    sides = [_outwards(sound(surface, _Z_UP_FRONT_Y, 0)) for surface in model.surfaces]
    if not any(len(each.triangles) for each in sides):
        raise UserError(Fault(where, "has no triangles with an extent", "a mesh of surfaces that are opaque"))
    patches, skins, atlases = tinted([each for each in sides if len(each.triangles)], model.skins)
    number: dict[int, int] = {}
    parts = []
    for patch in map(with_normals, patches):
        skin = skins[patch.skin]
        image = atlases.get(patch.skin, skin.texture if patch.uv is not None else None)
        if image is not None and id(image) not in number:
            number[id(image)] = len(images)
            images[len(images)] = _square(image)
        parts.append((_mesh(patch), _finish(skin, -1 if image is None else number[id(image)])))
    return parts


def _unused(model: Model) -> Iterator[str]:
    skins = [model.skins[surface.skin] for surface in model.surfaces]
    if any(skin.normal_map is not None for skin in skins):
        yield "normal maps of furniture are not drawn: surfaces are smooth"
    if model.lights or any(skin.emission.any() for skin in skins):
        yield "lamps and glowing surfaces of furniture give no light"


def _outwards(patch: Patch) -> Patch:
    """A closed patch with its outside out: some programs write all triangles the other way round."""
    corners = welded(patch.vertices_m)[patch.triangles]
    edges = corners[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2) @ [len(patch.vertices_m), 1]
    back = corners[:, [[1, 0], [2, 1], [0, 2]]].reshape(-1, 2) @ [len(patch.vertices_m), 1]
    volume = float((patch.vertices_m[patch.triangles[:, 0]] * patch.crosses).sum())
    if volume >= 0 or not np.array_equal(np.sort(edges), np.sort(back)):
        return patch
    normals = None if patch.normals is None else -patch.normals
    return replace(patch, triangles=patch.triangles[:, ::-1], normals=normals)


def _mesh(patch: Patch) -> Mesh:
    assert patch.normals is not None
    uv = np.zeros((len(patch.vertices_m), 2)) if patch.uv is None else patch.uv
    return Mesh(patch.vertices_m, patch.normals, uv, patch.triangles)


def _finish(skin: Skin, image: int) -> Finish:
    red, green, blue = map(float, skin.base_colour)
    return Finish("", (red, green, blue), roughness=skin.roughness, metallic=skin.metallic, image=image)


def _square(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    edge = (_TEXTURE_PX, _TEXTURE_PX)
    return np.asarray(cv2.resize(np.ascontiguousarray(image), edge, interpolation=cv2.INTER_AREA), np.uint8)
