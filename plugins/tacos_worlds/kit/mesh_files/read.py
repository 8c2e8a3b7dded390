"""The door: a file of triangles to a model."""

from __future__ import annotations

from pathlib import Path

from tacos_files.image_headers import named_format
from tacos_framework import Fault, UserError
from tacos_framework.files import read_bytes
from tacos_worlds.kit.mesh_files.damage import UNREADABLE, Damaged
from tacos_worlds.kit.mesh_files.gltf import read_gltf
from tacos_worlds.kit.mesh_files.obj import read_obj
from tacos_worlds.kit.mesh_files.ply import read_ply
from tacos_worlds.kit.mesh_files.references import References
from tacos_worlds.kit.mesh_files.stl import read_stl
from tacos_worlds.kit.models.model import Model

_READERS = {".glb": read_gltf, ".gltf": read_gltf, ".obj": read_obj, ".ply": read_ply, ".stl": read_stl}
SUFFIXES = tuple(_READERS)
"""What the names of files of triangles end in."""

_REMEDY = f"Export it again, or as another of {', '.join(SUFFIXES)}."


def read_model(
    path: Path, *, most_px: int, within: Path | None = None, most_triangles: int | None = None
) -> Model:
    """Read a file of triangles and all it refers to; sizes are checked before anything is decoded.

    - `path`: a file that ends in one of `SUFFIXES`.
    - `most_px`: longest edge of textures [px].
    - `within`: the folder that neither the file nor what it refers to may lie outside of; by default its own.
    - `most_triangles`: triangles it may have at most, copies in the scene counted each; by default the limit
      ``mesh_triangles``.

    Raises UserError with the faults of the file and of what it refers to.
    """
    where, kind = str(path), path.suffix.lower()
    folder = path.parent if within is None else within
    if kind not in SUFFIXES:
        raise UserError(Fault(where, f"{path.name} is no file of triangles", f"one of {', '.join(SUFFIXES)}"))
    content = read_bytes(path, "mesh_mb", where=where, within=folder)
    if packed := named_format(content):
        remedy = "Unpack it, or export the model as one of these."
        raise UserError(Fault(where, f"is {packed}", f"the content of {path.suffix}", remedy))
    references = References(path, folder, where, len(content))
    try:
        model = _READERS[kind](content, references, most_px, most_triangles)
    except UNREADABLE as error:  # whatever trips over what no exporter writes
        references.refuse_faults()
        said = f"{error or type(error).__name__}"
        if not isinstance(error, Damaged):
            said = f"something in it is not what its format allows ({said})"
        what = f"cannot be read: {said}"
        raise UserError(Fault(where, what, "a file that keeps to its format", _REMEDY)) from error
    references.refuse_faults()
    return model
