"""What reads files of images, arrays, triangles, weights and results; a small whole example of each."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import trimesh
from PIL import Image
from safetensors.numpy import save as save_tensors

from tacos_files.arrays import read_npy, read_npz
from tacos_files.images import read_samples
from tacos_framework.errors import UserError
from tacos_framework.files import read_json


@dataclass(frozen=True)
class BinaryReader:
    """A way to read one kind of file.

    Parameters
    ----------
    suffix
        How the file's name ends.
    read
        Reads it.
    example
        Makes a whole file.
    structure
        What `tests.fuzz.mutations.damaged` knows of its inside.
    whole_or_fault
        Whether every file that lacks its end must be refused.
    """

    suffix: str
    read: Callable[[Path], object]
    example: Callable[[], bytes]
    structure: str = ""
    whole_or_fault: bool = True


def _samples(dtype: type = np.uint8, channels: int = 3) -> np.ndarray:
    return np.random.default_rng(0).integers(0, 255, (12, 20, channels)).astype(dtype)


def _encoded(suffix: str, dtype: type = np.uint8, channels: int = 3) -> Callable[[], bytes]:
    return lambda: cv2.imencode(suffix, _samples(dtype, channels))[1].tobytes()


def _packed(kind: str, **options: object) -> Callable[[], bytes]:
    def made() -> bytes:
        stream = io.BytesIO()
        Image.fromarray(_samples()).save(stream, kind, **options)
        return stream.getvalue()

    return made


def _npy() -> bytes:
    stream = io.BytesIO()
    np.save(stream, _samples())
    return stream.getvalue()


def _npz() -> bytes:
    stream = io.BytesIO()
    np.savez_compressed(stream, a=_samples(), b=np.array(["x", "y"]))
    return stream.getvalue()


def _box() -> trimesh.Trimesh:
    box = trimesh.creation.box((1, 2, 3))
    material = trimesh.visual.material.PBRMaterial(
        baseColorTexture=Image.fromarray(_samples()), roughnessFactor=0.3
    )
    uv = np.random.default_rng(0).uniform(size=(8, 2))
    box.visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    return box


def _glb() -> bytes:
    scene = trimesh.Scene()
    scene.add_geometry(_box(), node_name="a")
    scene.add_geometry(trimesh.creation.box((1, 1, 1)), node_name="b", parent_node_name="a")
    return scene.export(file_type="glb")


def _model(path: Path) -> object:
    """A model as furniture: parsed, its finishes made; with the files an OBJ refers to beside it."""
    from tacos_worlds.indoor.user_models import load_user_models

    folder = path.parent / "models" / "sofa"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "material.mtl").write_text("newmtl m\nKd 0.5 0.5 0.5\nmap_Kd picture.png\n")
    (folder / "picture.png").write_bytes(_encoded(".png")())
    target = folder / f"model{path.suffix}"
    target.write_bytes(path.read_bytes())
    return load_user_models(str(folder.parent))


def _ply(path: Path) -> object:
    from tacos_worlds.mesh_files import read_mesh_file

    return read_mesh_file(path).scene.dump()


_OBJ = """mtllib material.mtl
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
vt 0 0
vt 1 0
vt 0 1
vn 0 0 1
usemtl m
f 1/1/1 2/2/1 3/3/1
f 1/1/1 3/3/1 4/2/1
f 1/1/1 4/2/1 2/3/1
f 2/1/1 4/2/1 3/3/1
"""


@cache
def _pt() -> bytes:
    import torch

    stream = io.BytesIO()
    torch.save({"state_dict": {"a.weight": torch.ones(3, 4), "a.bias": torch.zeros(3)}}, stream)
    return stream.getvalue()


def _checkpoint(path: Path) -> object:
    from tacos_plugins.tasks.learning.checkpoints import read_checkpoint

    return read_checkpoint(path, where="weights")


def _facts(path: Path) -> object:
    from tacos_gap.photographs.facts import read_facts

    return read_facts(path)


def _photograph() -> bytes:
    exif = Image.Exif()
    exif[0x010F], exif[0x0110], exif[0x0112] = "Maker", "Model", 1
    exif.get_ifd(0x8769).update({0x829A: 0.01, 0x8827: 100, 0x920A: 4.2, 0xA405: 28})
    return _packed("JPEG", exif=exif, quality=90)()


def _study(path: Path) -> object:
    """The report's and the tables' reading of a results folder that somebody sent."""
    from tacos_decision.tables import read_result
    from tacos_report.study_data import read_study

    folder = path.parent / "run"
    folder.mkdir(exist_ok=True)
    (folder / "result.json").write_bytes(path.read_bytes())
    read_study(folder)
    return read_result(folder)


_RESULT = {
    "cameras": {"designed": {"title": "x", "camera": {"focal_length_mm": 4.0}, "terms": {"a": 0.5}}},
    "best": {"camera": {"focal_length_mm": 4.0}, "fitness": 0.5},
    "test": {"designed": {"a": 0.5, "fitness": 0.5}},
    "samples": {"designed": ["samples/0.png"]},
}

BINARY_READERS: Mapping[str, BinaryReader] = {
    "png": BinaryReader(".png", read_samples, _encoded(".png")),
    "png16": BinaryReader(".png", read_samples, _encoded(".png", np.uint16, 1)),
    "jpeg": BinaryReader(".jpg", read_samples, _encoded(".jpg")),
    "progressive": BinaryReader(".jpg", read_samples, _packed("JPEG", progressive=True)),
    "tiff": BinaryReader(".tif", read_samples, _encoded(".tif")),
    "webp": BinaryReader(".webp", read_samples, _packed("WEBP")),
    "bmp": BinaryReader(".bmp", read_samples, _encoded(".bmp")),
    "ppm": BinaryReader(".ppm", read_samples, _encoded(".ppm")),
    "npy": BinaryReader(".npy", read_npy, _npy),
    "npz": BinaryReader(".npz", read_npz, _npz),
    "glb": BinaryReader(".glb", _model, cache(_glb), "glb"),
    "obj": BinaryReader(".obj", _model, _OBJ.encode, whole_or_fault=False),
    "ply": BinaryReader(".ply", _ply, lambda: trimesh.creation.box((1, 2, 3)).export(file_type="ply")),
    "safetensors": BinaryReader(
        ".safetensors", _checkpoint, lambda: save_tensors({"a": np.ones((3, 4), np.float32)})
    ),
    "torch": BinaryReader(".pt", _checkpoint, _pt),
    "exif": BinaryReader(".jpg", _facts, _photograph, whole_or_fault=False),
    "json": BinaryReader(".json", read_json, lambda: json.dumps(_RESULT).encode(), "json"),
    "result": BinaryReader(".json", _study, lambda: json.dumps(_RESULT).encode(), "json"),
}


def read_or_refuse(reader: BinaryReader, content: bytes, folder: Path) -> object | UserError:
    """What a file of this content gives; any exception but `UserError` is a defect and passes."""
    path = folder / f"file{reader.suffix}"
    path.write_bytes(content)
    try:
        return reader.read(path)
    except UserError as error:
        if not error.faults:
            raise ValueError("a UserError without any fault") from error
        return error
