"""Blurs what a probe sees as rough mirrors do, once per world."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Material
from tacos_plugins.renderers.light.ambient_visibility import around
from tacos_plugins.renderers.light.probes import FACE_PX, Probe, face_camera, face_rotations

if TYPE_CHECKING:
    from scipy.sparse import csr_array

LAYER_PX = 96
"""Edge of an octahedral layer, border of one texel included [px]."""

PROBE_SCALE = 0.5 * (LAYER_PX - 2) / LAYER_PX
"""From octahedral coordinates -1..1 to texture coordinates around 0.5 [1]."""

BRIGHTEST = float(np.finfo(np.float16).max)
"""Largest value in textures of light; the skin of a lamp may be brighter, and would turn to infinity."""

_ROUGHNESS_STEP = 0.1
_SAMPLES = 64


def roughness_levels(materials: Sequence[Material]) -> tuple[list[float], NDArray[np.int32]]:
    """The distinct roughnesses to blur for, and (materials,) which of them each material uses.

    >>> grey = np.full(3, 0.5)
    >>> roughness_levels([Material("a", grey, roughness=0.32), Material("b", grey, roughness=0.1)])
    ([0.1, 0.3], array([1, 0], dtype=int32))
    """
    rounded = [round(max(round(m.roughness / _ROUGHNESS_STEP), 0.5) * _ROUGHNESS_STEP, 3) for m in materials]
    levels = sorted(set(rounded)) or [1.0]
    return levels, np.array([levels.index(value) for value in rounded], np.int32)


def prefiltered(probes: Sequence[Probe], levels: Sequence[float]) -> NDArray[np.float32]:
    """(probes * levels, LAYER_PX, LAYER_PX, 3) luminance mirrored by each roughness into each direction."""
    layers = np.empty((len(probes), len(levels), LAYER_PX * LAYER_PX, 3), np.float32)
    planes = np.stack([np.moveaxis(probe.faces_cd_m2, -1, 1) for probe in probes])
    edges = [_source_edge(roughness) for roughness in levels]
    columns = {edge: _columns(_pooled(planes, edge)) for edge in set(edges)}
    for number, (roughness, edge) in enumerate(zip(levels, edges, strict=True)):
        blurred = _lobes(roughness, edge) @ columns[edge]
        layers[:, number] = np.moveaxis(blurred.reshape(-1, len(probes), 3), 1, 0)
    return layers.reshape(-1, LAYER_PX, LAYER_PX, 3)


def _pooled(planes: NDArray[np.float32], edge: int) -> NDArray[np.float32]:
    """(..., edge, edge) means over the squares of (..., FACE_PX, FACE_PX) images.

    Added up pixel after pixel of all squares at once: `mean` over two axes takes many times as long.
    """
    shrink = FACE_PX // edge
    places = [(row, column) for row in range(shrink) for column in range(shrink)]
    total = np.ascontiguousarray(planes[..., ::shrink, ::shrink])
    for row, column in places[1:]:
        total += planes[..., row::shrink, column::shrink]
    return total / np.float32(shrink * shrink)


def _columns(pooled: NDArray[np.float32]) -> NDArray[np.float32]:
    """(6 edge^2, probes * 3) values of (probes, 6, 3, edge, edge) faces: a column a probe and channel."""
    probes, faces, channels, edge, _ = pooled.shape
    return pooled.transpose(1, 3, 4, 0, 2).reshape(faces * edge * edge, probes * channels)


def _source_edge(roughness: float) -> int:
    """Edge of the faces to sample: pixels of about a third of the lobe's width keep the blur smooth."""
    lobe_rad = np.arctan(max(roughness, 0.05) ** 2)
    wanted = (np.pi / 2) / (lobe_rad / 1.5)
    return int(np.clip(2 ** np.ceil(np.log2(wanted)), 8, FACE_PX))


@lru_cache(maxsize=16)
def _lobes(roughness: float, edge: int) -> csr_array:
    """(texels, 6 edge^2) matrix that blurs faces into an octahedral layer."""
    from scipy.sparse import csr_array  # late: checking a recipe draws nothing

    axis = octahedral_directions()
    lobe, weight = ggx_lobe(roughness, _SAMPLES)
    source = _face_pixels(around(axis, lobe).reshape(-1, 3), edge)
    rows = np.arange(len(axis) + 1) * len(lobe)
    return csr_array((np.tile(weight, len(axis)), source, rows), shape=(len(axis), 6 * edge * edge))


def ggx_lobe(roughness: float, count: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """(S, 3) directions mirrored around +z by GGX microfacets seen from +z, and their weights of sum 1.

    Drawn in proportion to the distribution of microfacets (Walter et al. 2007, eq. 35).
    """
    squared = max(roughness, 0.02) ** 4
    u = (np.arange(count) + 0.5) / count
    cosine2 = (1 - u) / (1 + (squared - 1) * u)
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(count)
    cosine, sine = np.sqrt(cosine2), np.sqrt(1 - cosine2)
    facet = np.column_stack([sine * np.cos(turn), sine * np.sin(turn), cosine])
    mirrored = 2 * cosine[:, None] * facet - [0.0, 0.0, 1.0]
    ahead = mirrored[:, 2] > 0
    weight = mirrored[ahead, 2] / mirrored[ahead, 2].sum()
    return mirrored[ahead].astype(np.float32), weight.astype(np.float32)


def octahedral_directions() -> NDArray[np.float32]:
    """(LAYER_PX^2, 3) unit directions of a layer's texel centres, its border wrapping around."""
    centre = (np.arange(LAYER_PX) + 0.5 - LAYER_PX / 2) / ((LAYER_PX - 2) / 2)
    y, x = (part.reshape(-1) for part in np.meshgrid(centre, centre, indexing="ij"))
    # Beyond an edge the map goes on mirrored along that edge.
    for _ in range(2):
        over = np.abs(x) > 1
        x, y = np.where(over, np.sign(x) * 2 - x, x), np.where(over, -y, y)
        x, y = y, x
    z = 1 - np.abs(x) - np.abs(y)
    folded_x = np.where(z < 0, (1 - np.abs(y)) * np.where(x >= 0, 1, -1), x)
    folded_y = np.where(z < 0, (1 - np.abs(x)) * np.where(y >= 0, 1, -1), y)
    direction = np.column_stack([folded_x, folded_y, z])
    return (direction / np.linalg.norm(direction, axis=1, keepdims=True)).astype(np.float32)


def _face_pixels(direction: NDArray[np.float32], edge: int) -> NDArray[np.int32]:
    """(N,) index of the face pixel that looks into each direction."""
    camera = face_camera(edge)
    ahead = direction @ face_rotations()[:, :, 2].T.astype(np.float32)
    face = ahead.argmax(axis=1)
    local = np.einsum("nji,nj->ni", face_rotations().astype(np.float32)[face], direction)
    pixel = local[:, :2] / local[:, 2:] * camera.focal_length_px + np.asarray(camera.centre_px)
    column, row = np.clip(np.rint(pixel), 0, edge - 1).astype(np.int32).T
    return (face * edge * edge + row * edge + column).astype(np.int32)
