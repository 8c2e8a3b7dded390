"""glTF 2.0 (.glb, .gltf): surfaces of the default scene, with names, extras, materials and lights."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tacos_framework import Fault, UserError
from tacos_worlds.kit.mesh_files.damage import Damaged, points_alone, refuse_triangles
from tacos_worlds.kit.mesh_files.gltf_buffers import Buffers, Json
from tacos_worlds.kit.mesh_files.gltf_notes import UNDERSTOOD, notes_on
from tacos_worlds.kit.mesh_files.gltf_primitives import Primitive
from tacos_worlds.kit.mesh_files.gltf_skins import Skins
from tacos_worlds.kit.mesh_files.precision import rounding_note
from tacos_worlds.kit.mesh_files.references import References
from tacos_worlds.kit.models.model import Model, PunctualLight, Surface

_DEEPEST = 200
"""Levels of nodes; no program nests them so deep."""
_POINTS, _TRIANGLES, _STRIP, _FAN = 0, 4, 5, 6


def read_gltf(content: bytes, references: References, most_px: int, most_triangles: int | None) -> Model:
    """The default scene of a file.

    - `most_px`: longest edge of textures [px].
    - `most_triangles`: as many at most; by default the limit ``mesh_triangles``.

    Raises Damaged where it is not what the format says. Raises UserError where a file cannot be read, or
    there are too many triangles.
    """
    buffers = Buffers(content, references)
    required = set(map(str, buffers.header.get("extensionsRequired", [])))
    if unknown := sorted(required - UNDERSTOOD):
        remedy = "Export it without that extension."
        raise UserError(
            Fault(references.where, f"needs {name}, which is not known", "glTF without it", remedy)
            for name in unknown
        )
    reader = _Reader(buffers, most_px, most_triangles)
    model = reader.model()
    if not model.surfaces and reader.point_count:
        raise points_alone(references.where, reader.point_count)
    notes = dict.fromkeys((*references.notes, *reader.rounded, *notes_on(buffers)))
    return replace(model, notes=tuple(notes))


class _Reader:
    def __init__(self, buffers: Buffers, most_px: int, most_triangles: int | None) -> None:
        self._buffers, self._most_triangles = buffers, most_triangles
        self._skins = Skins(buffers, most_px)
        self._lights: list[PunctualLight] = []
        self.rounded: list[str] = []
        self._placed: set[object] = set()
        self._triangle_count = self.point_count = 0
        self._default_skin = len(buffers.listed("materials"))
        self._quantised = "KHR_mesh_quantization" in buffers.header.get("extensionsRequired", [])

    def model(self) -> Model:
        scenes = self._buffers.listed("scenes")
        if scenes:
            roots = self._buffers.entry("scenes", self._buffers.header.get("scene", 0)).get("nodes", [])
        else:
            children = {child for node in self._buffers.listed("nodes") for child in node.get("children", [])}
            roots = [index for index in range(len(self._buffers.listed("nodes"))) if index not in children]
        surfaces = [found for root in roots for found in self._walk(root, np.eye(4), (), {})]
        return Model(tuple(surfaces), self._skins.all(), tuple(self._lights), up="y")

    def _walk(
        self, index: object, above: NDArray[np.float64], path: tuple[str, ...], extras: Mapping[str, Any]
    ) -> Iterator[Surface]:
        if len(path) > _DEEPEST:
            raise Damaged(f"its nodes lie more than {_DEEPEST} deep in one another")
        node = self._buffers.entry("nodes", index)
        if index in self._placed:  # a small file of such nodes would be a world without end
            raise Damaged(f"node {index} stands in the scene more than once")
        self._placed.add(index)
        own = node.get("extras")
        extras = {**extras, **own} if isinstance(own, dict) else extras
        path = (*path, str(node.get("name", f"node {index}")))
        world, more = above @ _local(node), node.get("extensions", {})
        if not np.isfinite(world).all():
            raise Damaged(f"node {'/'.join(path)} has a transform that is not finite")
        if more.get("KHR_node_visibility", {}).get("visible", True) is False:
            return
        if (light := more.get("KHR_lights_punctual")) is not None:
            self._lights.append(self._light(light, world))
        if "mesh" in node:
            mesh = self._buffers.entry("meshes", node["mesh"])
            named = mesh.get("name")
            bones = self._bones(node["skin"]) if "skin" in node else None
            weights: Sequence[float] = node.get("weights") or mesh.get("weights") or ()
            for place in self._copies(more.get("EXT_mesh_gpu_instancing"), world):
                for primitive in mesh.get("primitives", []):
                    surface = self._surface(
                        primitive, place, (*path, str(named)) if named else path, extras, weights, bones
                    )
                    if surface is not None:
                        yield surface
        for child in node.get("children", []):
            yield from self._walk(child, world, path, extras)

    def _copies(self, instancing: Json | None, world: NDArray[np.float64]) -> Iterator[NDArray[np.float64]]:
        """Where a mesh stands: once, or as often as EXT_mesh_gpu_instancing says."""
        if instancing is None:
            yield world
            return
        read = {
            kind: self._buffers.accessor(accessor).astype(np.float64)
            for kind, accessor in instancing.get("attributes", {}).items()
            if kind in ("TRANSLATION", "ROTATION", "SCALE")
        }
        for number in range(max(map(len, read.values()), default=0)):
            yield world @ _local({kind.lower(): rows[number] for kind, rows in read.items()})

    def _bones(self, skin: object) -> NDArray[np.float64]:
        """(J, 4, 4) from the place where each bone was bound to where it is, in the world of the file."""
        entry = self._buffers.entry("skins", skin)
        joints = list(entry.get("joints", []))
        bound = np.tile(np.eye(4), (len(joints), 1, 1))
        if "inverseBindMatrices" in entry:
            matrices = self._buffers.accessor(entry["inverseBindMatrices"])
            bound = matrices.reshape(-1, 4, 4).transpose(0, 2, 1).astype(np.float64)
        if len(bound) < len(joints):
            raise Damaged(f"skin {skin} has {len(bound)} matrices for {len(joints)} bones")
        return np.array([self._placed_at(joint) @ at for joint, at in zip(joints, bound, strict=False)])

    def _placed_at(self, node: object) -> NDArray[np.float64]:
        """(4, 4) from a node to the world of the file."""
        matrix = np.eye(4)
        for _ in range(_DEEPEST):
            matrix = _local(self._buffers.entry("nodes", node)) @ matrix
            if node not in self._parents:
                return matrix
            node = self._parents[node]
        raise Damaged(f"its nodes lie more than {_DEEPEST} deep in one another")

    @cached_property
    def _parents(self) -> Mapping[object, object]:
        nodes = enumerate(self._buffers.listed("nodes"))
        return {child: number for number, node in nodes for child in node.get("children", [])}

    def _surface(
        self,
        primitive: Json,
        world: NDArray[np.float64],
        path: tuple[str, ...],
        extras: Mapping[str, Any],
        weights: Sequence[float],
        bones: NDArray[np.float64] | None,
    ) -> Surface | None:
        """A primitive in the world; None for points and lines."""
        mode, attributes = primitive.get("mode", _TRIANGLES), primitive.get("attributes", {})
        if mode == _POINTS and "POSITION" in attributes:
            self.point_count += self._buffers.count(attributes["POSITION"])
        if mode not in (_TRIANGLES, _STRIP, _FAN) or "POSITION" not in attributes:
            return None
        self._count(primitive.get("indices", attributes["POSITION"]), mode)
        corners = Primitive(self._buffers, primitive)
        positions = corners.read("POSITION")
        vertices = corners.morphed(_wide(positions, 3, path), weights)
        if not self.rounded and positions.dtype.kind == "f":
            self.rounded += rounding_note(vertices, single=True)
        triangles = _triangles(corners.indices(len(vertices)), mode)
        if len(triangles) and int(triangles.max()) >= len(vertices):
            raise Damaged(f"{'/'.join(path)} names vertex {int(triangles.max())} of {len(vertices)}")
        if bones is not None and "JOINTS_0" in attributes:
            blend = corners.blends(bones)  # where its own node stands has no effect then
            vertices = np.einsum("nij,nj->ni", blend[:, :3, :3], vertices) + blend[:, :3, 3]
            world = np.eye(4)
        if np.linalg.det(world[:3, :3]) < 0:
            triangles = triangles[:, ::-1]  # mirrored
        moved = bones is not None or any(weights)
        material = primitive.get("material")
        return _of_used_vertices(
            Surface(
                path=path,
                vertices=vertices @ world[:3, :3].T + world[:3, 3],
                triangles=triangles,
                skin=self._default_skin if material is None else int(material),
                normals=_turned(corners.read("NORMAL"), world)
                if "NORMAL" in attributes and not moved
                else None,
                uv=self._uv(corners, material, len(vertices)),
                colours=_wide(_unit(corners.read("COLOR_0")), 3, path) if "COLOR_0" in attributes else None,
                extras=extras,
            )
        )

    def _count(self, accessor: object, mode: int) -> None:
        """Add up triangles before they are decoded, those of a mesh as often as nodes place it."""
        corners = self._buffers.count(accessor)
        self._triangle_count += corners // 3 if mode == _TRIANGLES else max(corners - 2, 0)
        refuse_triangles(self._buffers.references.where, self._triangle_count, self._most_triangles)

    def _uv(self, corners: Primitive, material: object, count: int) -> NDArray[np.float64] | None:
        which, moved = self._skins.uv_set(material)
        if (name := f"TEXCOORD_{which}") not in corners.attributes:
            return None
        read = corners.read(name)
        # Whole numbers of a quantised mesh are what they are: the transform of the texture scales them.
        uv = (read.astype(np.float64) if self._quantised else _unit(read))[:, :2]
        if len(uv) != count:
            raise Damaged(f"{name} has {len(uv)} entries for {count} vertices")
        uv = uv @ moved[:2, :2].T + moved[:2, 2]
        return np.column_stack([uv[:, 0], 1 - uv[:, 1]])  # glTF counts v downwards

    def _light(self, named: Json, world: NDArray[np.float64]) -> PunctualLight:
        lights = self._buffers.header.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
        index = named.get("light")
        if not isinstance(index, int) or not 0 <= index < len(lights):
            raise Damaged(f"light {index!r} does not exist")
        light = lights[index]
        kind = light.get("type")
        if kind not in ("point", "spot", "directional"):
            raise Damaged(f"light {index} is of the unknown type {kind!r}")
        direction = -world[:3, 2]  # lights shine along -z
        return PunctualLight(
            kind=kind,
            position=world[:3, 3],
            direction=direction / max(float(np.linalg.norm(direction)), 1e-12),
            colour=np.asarray(light.get("color", (1, 1, 1)), np.float64),
            intensity=float(light.get("intensity", 1.0)),
            outer_rad=float(light.get("spot", {}).get("outerConeAngle", math.pi / 4)),
        )


def _local(node: Json) -> NDArray[np.float64]:
    """(4, 4) transform of a node into its parent."""
    try:
        if "matrix" in node:
            return np.asarray(node["matrix"], np.float64).reshape(4, 4).T
        matrix = np.eye(4)
        if "rotation" in node:
            matrix[:3, :3] = Rotation.from_quat(np.asarray(node["rotation"], np.float64)).as_matrix()
        matrix[:3, :3] *= np.asarray(node.get("scale", (1, 1, 1)), np.float64)
        matrix[:3, 3] = np.asarray(node.get("translation", (0, 0, 0)), np.float64)
    except (ValueError, TypeError) as error:
        raise Damaged(f"node {node.get('name')!r} has a transform that cannot be read: {error}") from error
    return matrix


def _triangles(indices: NDArray[np.int64], mode: int) -> NDArray[np.int64]:
    """(T, 3) triangles of a list, a strip or a fan."""
    if mode == _TRIANGLES:
        return indices[: len(indices) // 3 * 3].reshape(-1, 3)
    if len(indices) < 3:
        return np.zeros((0, 3), np.int64)
    if mode == _FAN:
        return np.column_stack([np.full(len(indices) - 2, indices[0]), indices[1:-1], indices[2:]])
    triangles = np.column_stack([indices[:-2], indices[1:-1], indices[2:]])
    triangles[1::2] = triangles[1::2, ::-1]  # every other one runs the other way
    return triangles


def _of_used_vertices(surface: Surface) -> Surface:
    """A surface without vertices of others: many parts of a mesh may share one list of them."""
    if len(surface.vertices) <= surface.triangles.size:
        return surface
    used, place = np.unique(surface.triangles, return_inverse=True)
    rows = {
        name: values[used]
        for name in ("vertices", "normals", "uv", "colours")
        if (values := getattr(surface, name)) is not None and len(values) == len(surface.vertices)
    }
    return replace(surface, triangles=place.reshape(-1, 3), **rows)


def _turned(normals: NDArray[Any], world: NDArray[np.float64]) -> NDArray[np.float64]:
    """Normals in the world: turned by the inverse transpose, so that they stay upright on scaled surfaces."""
    turned = normals.astype(np.float64) @ np.linalg.pinv(world[:3, :3])
    return np.asarray(turned / np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-12))


def _unit(values: NDArray[Any]) -> NDArray[np.float64]:
    """Integers that stand for 0..1, whether or not they are said to; floats as they are."""
    return (
        values / float(np.iinfo(values.dtype).max) if values.dtype.kind in "iu" else values.astype(np.float64)
    )


def _wide(values: NDArray[Any], width: int, path: tuple[str, ...]) -> NDArray[np.float64]:
    if values.shape[1] < width:
        raise Damaged(f"{'/'.join(path)} has vertices of {values.shape[1]} numbers, not {width}")
    return values[:, :width].astype(np.float64)
