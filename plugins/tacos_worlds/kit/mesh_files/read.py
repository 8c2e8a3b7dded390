"""The door: a file of triangles to a scene of trimesh."""

from __future__ import annotations

import struct
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from tacos_framework import Fault, UserError
from tacos_framework.files import limits, read_bytes
from tacos_worlds.kit.mesh_files.gltf import check_gltf, glb_chunks, parse_tree
from tacos_worlds.kit.mesh_files.mtl import MtlMaterial
from tacos_worlds.kit.mesh_files.plain import check_obj, check_ply
from tacos_worlds.kit.mesh_files.references import References

SUFFIXES = (".glb", ".gltf", ".obj", ".ply")
"""What the names of files of triangles end in."""

UNREADABLE = (
    ValueError,
    LookupError,
    NameError,  # UnboundLocalError, of headers that trimesh did not expect
    TypeError,
    AttributeError,
    AssertionError,
    ArithmeticError,
    OSError,
    EOFError,
    NotImplementedError,
    RecursionError,
    MemoryError,
    struct.error,
    DeprecationWarning,  # np.fromstring, of text that is no numbers: it leaves out what follows
)
"""What trimesh's readers raise on files that are damaged, wherever the damage trips them."""


@dataclass(frozen=True)
class MeshFile:
    """A file of triangles, read.

    Parameters
    ----------
    scene
        As trimesh has it, with finite vertices and faces that name vertices that are there.
    tree
        The JSON of a glTF file, for what trimesh leaves out (lights, extras); empty for other files.
    materials, notes
        Of an OBJ file: what trimesh leaves out of its materials, by name, and what is not carried out.
    """

    scene: trimesh.Scene
    tree: Mapping[str, Any]
    materials: Mapping[str, MtlMaterial] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def read_mesh_file(
    path: Path,
    *,
    within: Path | None = None,
    where: str | None = None,
    most_triangles: float | None = None,
    **options: Any,
) -> MeshFile:
    """Read a file of triangles and all it refers to; sizes are checked before anything is decoded.

    Parameters
    ----------
    path
        A file that ends in one of `SUFFIXES`.
    within
        The folder that neither the file nor what it refers to may lie outside of; by default its own.
    where
        What names the file in messages; the path, when left out.
    most_triangles
        Triangles it may have at most, copies in the scene counted each; by default the limit
        ``mesh_triangles``.
    options
        Passed on to `trimesh.load_scene`, such as ``process=False``.

    Raises
    ------
    UserError
        With every fault of the file and of what it refers to.
    """
    where = str(path) if where is None else where
    folder = path.parent if within is None else within
    most = limits().mesh_triangles if most_triangles is None else most_triangles
    kind = path.suffix.lower()
    if kind not in SUFFIXES:
        raise UserError(Fault(where, f"{path.name} is no file of triangles", f"one of {', '.join(SUFFIXES)}"))
    content = read_bytes(path, "mesh_mb", where=where, within=folder)
    references = References(path, folder, where, len(content))
    tree: dict[str, Any] = {}
    if kind in (".glb", ".gltf"):
        text, binary = glb_chunks(content, where) if kind == ".glb" else (content, None)
        tree = parse_tree(text, where)
        count = check_gltf(tree, binary, references, where)
    elif kind == ".obj":
        count = check_obj(content, references, where)
    else:
        count = check_ply(content, where)
    references.refuse_faults()
    if count > most:
        least = "" if kind in (".glb", ".gltf") else "at least "
        remedy = "Simplify the model." if most_triangles else limits().remedy("mesh_triangles", count)
        raise UserError(Fault(where, f"has {least}{count} triangles", f"at most {most:.0f}", remedy))
    scene = _loaded(content, kind.removeprefix("."), references, where, options)
    return MeshFile(scene, tree, references.materials, tuple(references.notes))


def _loaded(
    content: bytes, kind: str, references: References, where: str, options: Mapping[str, Any]
) -> trimesh.Scene:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.simplefilter("error", DeprecationWarning)
            scene = trimesh.load_scene(BytesIO(content), file_type=kind, resolver=references, **options)
            faults = list(_shape_faults(scene, where))
    except UNREADABLE as error:
        references.refuse_faults()
        what = f"cannot be read: {error or type(error).__name__}"
        raise UserError(Fault(where, what, "a whole file", "Export the model again.")) from error
    references.refuse_faults()
    if faults:
        raise UserError(faults)
    return scene


def _shape_faults(scene: trimesh.Scene, where: str) -> list[Fault]:
    """What is wrong with the numbers of a scene, which trimesh believes."""
    for name, mesh in scene.geometry.items():
        faces = getattr(mesh, "faces", np.zeros((0, 3), np.int64))
        if mesh.vertices.shape[1:] != (3,) or faces.shape[1:] != (3,):
            return [Fault(where, f"{name} has vertices or triangles that are not of three numbers")]
        if not np.isfinite(mesh.vertices).all():
            return [Fault(where, f"{name} has vertices that are not finite")]
        if len(faces) and not 0 <= faces.min() <= faces.max() < len(mesh.vertices):
            return [Fault(where, f"{name} has triangles of vertices that are not there")]
        uv = getattr(mesh.visual, "uv", None)
        if uv is not None and (len(uv) != len(mesh.vertices) or not np.isfinite(uv).all()):
            return [Fault(where, f"{name} has texture coordinates that are no numbers, or not one a vertex")]
    for name in scene.graph.nodes_geometry:
        if not np.isfinite(scene.graph.get(name)[0]).all():
            return [Fault(where, f"{name} is placed by numbers that are not finite")]
    return []
