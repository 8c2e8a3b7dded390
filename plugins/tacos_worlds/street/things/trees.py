"""Trees: a trunk with boughs, and a crown of lumps of leaves."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from tacos_worlds.kit.finishes import Finish
from tacos_worlds.kit.mesh import Floats, Indices, Mesh, merged, shaded
from tacos_worlds.kit.piece import Piece
from tacos_worlds.kit.shapes.lofts import tube
from tacos_worlds.street.finishes import BARK

_GREENS = ((0.78, 0.90, 0.72), (0.95, 1.0, 0.70), (0.60, 0.80, 0.62))


@lru_cache(maxsize=1)
def _icosahedron() -> tuple[Floats, Indices]:
    """A unit sphere of 20 triangles."""
    import trimesh

    sphere = trimesh.creation.icosphere(subdivisions=0)
    return np.asarray(sphere.vertices, np.float64), np.asarray(sphere.faces, np.int64)


def _lump(rng: np.random.Generator, centre_m: Floats, radius_m: float) -> Mesh:
    points, triangles = _icosahedron()
    bumps = 1 + rng.normal(0, 0.08, len(points))
    mesh = shaded(centre_m + points * bumps[:, None] * radius_m, triangles, crease_deg=170)
    return mesh.with_uv_offset(*rng.uniform(0, 2.5, 2).tolist())


def _sprays(rng: np.random.Generator, centre_m: Floats, radius_m: float, count: int) -> Mesh:
    """Sprays of leaves all over a lump, a triangle each: they make a crown's ragged outline."""
    outwards = rng.standard_normal((count, 3))
    outwards /= np.linalg.norm(outwards, axis=1, keepdims=True)
    at = centre_m + outwards * radius_m * rng.uniform(0.85, 1.12, (count, 1))
    across = np.cross(outwards, rng.standard_normal((count, 3)))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    along = np.cross(outwards, across) * 0.8 + outwards * 0.6
    size = radius_m * rng.uniform(1.4, 2.2, (count, 1)) / math.sqrt(max(count, 36))
    corners = np.stack([at - across * size, at + across * size, at + along * 1.6 * size], axis=1)
    uv = rng.uniform(0, 2.5, (count, 1, 2)) + np.array([[0, 0], [0.8, 0], [0.4, 0.8]]) * size[:, :, None]
    return Mesh(
        vertices_m=corners.reshape(-1, 3),
        normals=np.repeat(outwards, 3, axis=0),  # lit as the crown is, not as flakes
        uv_m=uv.reshape(-1, 2),
        triangles=np.arange(3 * count).reshape(-1, 3),
    )


def _foliage(rng: np.random.Generator, centre_m: Floats, radius_m: float, sprays: int) -> Mesh:
    return merged([_lump(rng, centre_m, 0.86 * radius_m), _sprays(rng, centre_m, radius_m, sprays)])


def draw_tree(rng: np.random.Generator, *, far: bool = False) -> Piece:
    """A random street tree, 6 to 10 m high, with fewer leaves where it is only seen from `far`."""
    sprays = (22, 10) if far else (66, 36)
    height = float(rng.uniform(6.0, 9.5))
    fork = 0.38 * height
    lean = rng.normal(0, 0.12, 2)
    top = np.array([lean[0], lean[1], 0.74 * height])
    bole = [(0, 0, 0), (0.4 * lean[0], 0.4 * lean[1], fork), tuple(top)]
    wood = [tube(bole, [0.19, 0.14, 0.05], sides=6)]
    crown = [_foliage(rng, top, 0.23 * height, sprays[0])]
    turn = rng.uniform(0, 2 * np.pi)
    for _ in range(2):
        turn += np.pi + rng.normal(0, 0.4)
        reach = 0.17 * height
        end = np.array([reach * np.cos(turn), reach * np.sin(turn), rng.uniform(0.54, 0.66) * height])
        wood.append(tube([(0, 0, fork), tuple(end)], [0.09, 0.03], sides=3))
        crown.append(_foliage(rng, end, float(rng.uniform(0.17, 0.2)) * height, sprays[1]))
    leaves = Finish("leaves", _GREENS[int(rng.integers(len(_GREENS)))], roughness=0.95)
    return Piece("tree", ((merged(wood), BARK), (merged(crown), leaves)))


def shrub(rng: np.random.Generator, width_m: float) -> Piece:
    radius = width_m / 2
    leaves = Finish("leaves", _GREENS[int(rng.integers(len(_GREENS)))], roughness=0.95)
    return Piece("vegetation", ((_foliage(rng, np.array([0, 0, 0.6 * radius]), radius, 30), leaves),))
