"""Seen sides of surfaces, and surfaces turned so that these are their fronts.

Files are full of walls that face away from the room they belong to: boxes modelled from outside, mirrored
copies, exporters with another convention. A rasterizer leaves such walls out, and light computed for the
wrong side is wrong. So sides are found by looking: rays from where the agent's eye may be, in all directions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.coincident_faces import other_sides
from tacos_plugins.lighting.occlusion import Occlusion
from tacos_worlds.kit.models.patch import Patch

_EYES, _RAYS_PER_EYE = 256, 1024
_ONE_SIDED = 0.02
"""A side that gets fewer of the looks at a patch is not counted as seen [1]."""
_FEWEST_LOOKS = 4


def facing_the_eye(
    patches: Sequence[Patch], occlusion: Occlusion, eyes_m: NDArray[np.float64]
) -> list[Patch]:
    """Patches whose seen side is their front; those seen from both sides get a back.

    `patches`: in the order in which `occlusion` holds their triangles. `eyes_m`: (N, 3) where eyes may be
    [m].
    """
    front, back = _looks(patches, occlusion, eyes_m)
    faced = []
    for patch, ahead, behind in zip(patches, front, back, strict=True):
        looks = ahead + behind
        if looks < _FEWEST_LOOKS or behind <= _ONE_SIDED * looks:
            faced.append(patch)
        elif ahead <= _ONE_SIDED * looks:
            faced.append(flipped(patch))
        else:
            faced.append(with_back(patch))
    return faced


def _looks(
    patches: Sequence[Patch], occlusion: Occlusion, eyes_m: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    chosen = eyes_m[np.linspace(0, len(eyes_m) - 1, min(_EYES, len(eyes_m))).astype(int)]
    directions = np.tile(_sphere(_RAYS_PER_EYE), (len(chosen), 1)).astype(np.float32)
    hits = occlusion.first_hits(np.repeat(chosen, _RAYS_PER_EYE, axis=0).astype(np.float32), directions)
    met = hits.triangle >= 0
    corners = occlusion.vertices_m[occlusion.triangles[hits.triangle[met]]].astype(np.float64)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    from_front = np.einsum("ij,ij->i", normal, directions[met]) < 0
    # Of two that share a place, whichever the ray reports, the one that faces the eye is seen.
    other = other_sides(occlusion.vertices_m[occlusion.triangles])[hits.triangle[met]]
    seen = np.where(from_front | (other < 0), hits.triangle[met], other)
    from_front |= other >= 0
    owner = np.repeat(np.arange(len(patches)), [len(patch.triangles) for patch in patches])[seen]
    count = len(patches)
    return np.bincount(owner[from_front], minlength=count), np.bincount(owner[~from_front], minlength=count)


def _sphere(count: int) -> NDArray[np.float64]:
    """(count, 3) unit vectors spread evenly: a Fibonacci spiral."""
    height = 1 - (2 * np.arange(count) + 1) / count
    angle = np.arange(count) * np.pi * (3 - np.sqrt(5))
    ring = np.sqrt(1 - height**2)
    return np.column_stack([ring * np.cos(angle), ring * np.sin(angle), height])


def flipped(patch: Patch) -> Patch:
    """The other side as front; normals, where there are any, are kept to that side."""
    return _agreeing(replace(patch, triangles=patch.triangles[:, ::-1]))


def with_back(patch: Patch) -> Patch:
    """The patch with a second face behind each triangle, in vertices of its own, so that both sides are
    lit."""
    front = _agreeing(patch)
    behind = flipped(patch)

    def both(name: str) -> NDArray[np.float64] | None:
        one, other = getattr(front, name), getattr(behind, name)
        return None if one is None else np.concatenate([one, other])

    vertices = both("vertices_m")
    assert vertices is not None
    return Patch(
        vertices,
        np.concatenate([front.triangles, behind.triangles + len(front.vertices_m)]),
        patch.skin,
        patch.object_id,
        both("normals"),
        both("uv"),
        both("colours"),
    )


def _agreeing(patch: Patch) -> Patch:
    if patch.normals is None:
        return patch
    total = np.zeros_like(patch.vertices_m)
    for corner in range(3):
        np.add.at(total, patch.triangles[:, corner], patch.crosses)
    wrong = np.einsum("ij,ij->i", total, patch.normals) < 0
    return replace(patch, normals=np.where(wrong[:, None], -patch.normals, patch.normals))
