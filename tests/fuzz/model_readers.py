"""Furniture and worlds of others: triangles, finishes, recorded poses, tables of what things are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

from tacos_framework.errors import Fault, UserError
from tests.fuzz.image_readers import encoded, samples
from tests.fuzz.reader import Reader
from tests.worlds.imported.two_rooms import two_rooms, y_up

_MTL = b"newmtl m\nKd 0.5 0.5 0.5\nNs 20\nd 1\nmap_Kd picture.png\n"
_OBJ = b"""mtllib material.mtl
o thing
v 0 0 0
v 4 0 0
v 0 4 0
v 0 0 4
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
_POSES = {
    "tum": b"# time tx ty tz qx qy qz qw\n0 1 1 1.6 0 0 0 1\n1 2 1 1.6 0 0 0 1\n2.5 2 2 1.6 0 0 0.7 0.7\n",
    "euroc": b"#t,px,py,pz,qw,qx,qy,qz,v\n0,1,1,1.6,1,0,0,0,9\n500000000,2,1,1.6,1,0,0,0,9\n",
    "kitti": b"1 0 0 1 0 1 0 1 0 0 1 1.6\n1 0 0 2 0 1 0 1 0 0 1 1.6\n",
}
_LABELS = b'pattern,class\n"Sofa*",sofa\n*/thing 7,crate\n'


def _box() -> trimesh.Trimesh:
    box = trimesh.creation.box((1, 2, 3))
    material = trimesh.visual.material.PBRMaterial(
        baseColorTexture=Image.fromarray(samples()), roughnessFactor=0.3
    )
    uv = np.random.default_rng(0).uniform(size=(8, 2))
    box.visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    return box


@cache
def _glb() -> bytes:
    scene = trimesh.Scene()
    scene.add_geometry(_box(), node_name="a")
    scene.add_geometry(trimesh.creation.box((1, 1, 1)), node_name="b", parent_node_name="a")
    return scene.export(file_type="glb")


@cache
def _house() -> bytes:
    return y_up(two_rooms()).export(file_type="glb")


def _ply() -> bytes:
    return trimesh.creation.box((2, 3, 4)).export(file_type="ply")


@cache
def _text_ply() -> bytes:
    return trimesh.creation.box((2, 3, 4)).export(file_type="ply", encoding="ascii")


def _beside_its_files(path: Path, folder: Path) -> Path:
    """A model, OBJ with its MTL and a picture; where the MTL is damaged, a whole OBJ that names it."""
    folder.mkdir(parents=True, exist_ok=True)
    is_mtl = path.suffix == ".mtl"
    target = folder / ("model.obj" if is_mtl else f"model{path.suffix}")
    target.write_bytes(_OBJ if is_mtl else path.read_bytes())
    (folder / "material.mtl").write_bytes(path.read_bytes() if is_mtl else _MTL)
    (folder / "picture.png").write_bytes(encoded(".png")())
    return target


def _furniture(path: Path) -> object:
    """A model as furniture: parsed, its finishes made."""
    from tacos_worlds.indoor.user_models import load_user_models

    return load_user_models(str(_beside_its_files(path, path.parent / "models" / "sofa").parents[1]))


def _mesh(path: Path) -> object:
    from tacos_worlds.kit.mesh_files import read_model

    return read_model(path, most_px=64)


def _world(path: Path) -> object:
    """A model as a world of `scene.imported`: surfaces in metres, labelled, without what is nothing."""
    from tacos_worlds.imported.labels import class_names, label_of
    from tacos_worlds.imported.reader import read_world
    from tacos_worlds.kit.models.patch import sound

    file = _beside_its_files(path, path.parent / "world")
    read = read_world(file, up="auto", metres_per_unit=1.0, leave_out=(), most_px=64)
    labels = [label_of(surface, ()) for surface in read.model.surfaces]
    return class_names(labels), [sound(surface, read.turn, 0) for surface in read.model.surfaces]


def _walkable(path: Path) -> object:
    """A model as a world to walk in: its floor found, its lamps placed, an episode made."""
    from tacos_worlds.imported.scene import ImportedScene

    scene = ImportedScene(ImportedScene.Config(file=str(path), frames=2))
    return scene.episode(rng=np.random.default_rng(0), illumination_lux=300.0)


def _poses(path: Path) -> object:
    """Recorded poses, and places between them."""
    from tacos_worlds.imported.formats.file_bytes import Unreadable
    from tacos_worlds.imported.recorded import read_recorded

    try:
        trajectory, _ = read_recorded(path, np.eye(3), np.zeros(3), of_camera=True)
    except Unreadable as error:  # the scene says so, beside what else is wrong with its settings
        raise UserError(Fault(path.name, str(error))) from error
    return trajectory.at(np.linspace(0, trajectory.time_s[-1], 5))


def _labels(path: Path) -> object:
    from tacos_worlds.imported.labels import read_table

    rules, faults = read_table(path)
    if faults:
        raise UserError(faults)
    return [rule.matches(("house", "Sofa.001")) for rule in rules]


def _bytes(content: bytes) -> Callable[[], bytes]:
    return partial(bytes, content)


MODELS: Mapping[str, Reader] = {
    "glb": Reader(".glb", _furniture, _glb, "glb", whole_or_fault=True),
    "obj": Reader(".obj", _furniture, _bytes(_OBJ)),
    "mtl": Reader(".mtl", _furniture, _bytes(_MTL)),
    "ply": Reader(".ply", _mesh, _ply, whole_or_fault=True),
    "world-glb": Reader(".glb", _world, _house, "glb", whole_or_fault=True),
    "world-obj": Reader(".obj", _world, _bytes(_OBJ)),
    "world-mtl": Reader(".mtl", _world, _bytes(_MTL)),
    "world-ply": Reader(".ply", _world, _text_ply),
    "world-walked": Reader(".glb", _walkable, _house, "glb", whole_or_fault=True, share=0.1),
    **{f"poses-{form}": Reader(".txt", _poses, _bytes(example)) for form, example in _POSES.items()},
    "labels": Reader(".csv", _labels, _bytes(_LABELS)),
}
