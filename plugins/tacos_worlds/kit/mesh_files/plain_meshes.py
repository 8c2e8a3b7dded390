"""OBJ and PLY, as scanners and mesh programs write them, read by trimesh."""

from __future__ import annotations

import warnings
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from tacos_framework.camera import LINEAR_OF_SRGB_BYTE
from tacos_worlds.kit.mesh_files.damage import refuse_triangles
from tacos_worlds.kit.mesh_files.mtl import MtlMaterial
from tacos_worlds.kit.mesh_files.pictures import picture
from tacos_worlds.kit.mesh_files.plain import check_obj, check_ply, in_utf_8
from tacos_worlds.kit.mesh_files.references import References
from tacos_worlds.kit.models.model import Model, Skin, Surface


def read_plain_mesh(
    content: bytes, references: References, most_px: int, most_triangles: int | None
) -> Model:
    """Surfaces and skins of an OBJ (with its MTL) or a PLY file.

    Parameters
    ----------
    most_px
        Longest edge of textures [px].
    most_triangles
        As many at most; by default the limit ``mesh_triangles``.

    Raises
    ------
    UserError
        Where it cannot be read, or names files that are not there.
    """
    kind = Path(references.file_name).suffix.lower().removeprefix(".")
    check = check_obj if kind == "obj" else check_ply
    content = in_utf_8(content, references) if kind == "obj" else content
    count = check(content, references)
    references.refuse_faults()
    refuse_triangles(references.where, count, most_triangles)
    options: dict[str, Any] = {"split_objects": True, "group_material": True} if kind == "obj" else {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        warnings.simplefilter("error", DeprecationWarning)
        scene = trimesh.load_scene(
            BytesIO(content), file_type=kind, resolver=references, process=False, **options
        )
    surfaces: list[Surface] = []
    skins: list[Skin] = []
    for name, mesh in scene.geometry.items():
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            more = references.materials.get(_material_name(mesh), MtlMaterial())
            surface = _surface(str(mesh.metadata.get("name", name)), mesh, len(skins))
            if surface.uv is not None:
                surface = replace(surface, uv=surface.uv * more.scale + more.offset)
            surfaces.append(surface)
            skins.append(_skin(mesh, most_px, more))
    refuse_triangles(references.where, sum(len(each.triangles) for each in surfaces), most_triangles)
    return Model(tuple(surfaces), tuple(skins), notes=tuple(references.notes))


def _material_name(mesh: trimesh.Trimesh) -> str:
    return str(getattr(getattr(mesh.visual, "material", None), "name", ""))


def _surface(name: str, mesh: trimesh.Trimesh, skin: int) -> Surface:
    uv = getattr(mesh.visual, "uv", None)
    colours = None
    if isinstance(coloured := mesh.visual, trimesh.visual.ColorVisuals):
        if coloured.kind == "vertex":
            colours = LINEAR_OF_SRGB_BYTE[np.asarray(coloured.vertex_colors)[:, :3]]
        elif coloured.kind == "face":
            colours = _of_faces(mesh, np.asarray(coloured.face_colors)[:, :3])
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


def _of_faces(mesh: trimesh.Trimesh, colours: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Mean colour of the faces around each vertex."""
    total, count = np.zeros((len(mesh.vertices), 3)), np.zeros((len(mesh.vertices), 1))
    for corner in range(3):
        np.add.at(total, mesh.faces[:, corner], LINEAR_OF_SRGB_BYTE[colours])
        np.add.at(count, mesh.faces[:, corner], 1)
    return np.asarray(total / np.maximum(count, 1))


def _skin(mesh: trimesh.Trimesh, most_px: int, more: MtlMaterial) -> Skin:
    material = getattr(mesh.visual, "material", None)
    if isinstance(material, trimesh.visual.material.SimpleMaterial):
        material = material.to_pbr()
    if not isinstance(material, trimesh.visual.material.PBRMaterial):
        return Skin(
            "colours", np.ones(3) if mesh.visual is not None and mesh.visual.defined else np.full(3, 0.5)
        )
    factor = np.ones(4) if material.baseColorFactor is None else np.asarray(material.baseColorFactor) / 255
    image = mask = None
    if material.baseColorTexture is not None:
        pixels = picture(material.baseColorTexture, most_px)
        image = pixels[..., :3]
        mask = pixels[..., 3] if more.masked else None
    emission = np.zeros(3) if material.emissiveFactor is None else np.asarray(material.emissiveFactor, float)
    emission = np.maximum(emission, more.emission)
    roughness = 0.8 if material.roughnessFactor is None else float(material.roughnessFactor)
    roughness = roughness if more.roughness is None else more.roughness
    return Skin(
        name=str(material.name or ""),
        base_colour=np.clip(np.ones(3) if image is not None else factor[:3], 0, 1),
        opacity=min(float(factor[3]), more.opacity),
        mask=mask,
        clamped=(more.clamped, more.clamped),
        texture=image,
        roughness=float(np.clip(roughness, 0, 1)),
        metallic=more.metallic,
        emission=emission,
    )
