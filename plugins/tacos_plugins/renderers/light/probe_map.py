"""Reflection probes that each place mirrors: a map from above, with smooth passages between rooms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.renderers.light.rays import RayTracer

CELL_M = 0.1
"""Edge of a cell [m]: finer than walls are thick. Larger worlds get coarser maps."""

_MOST_CELLS = 400  # along an edge of the map
_NEAREST = 4  # probes that a place may mirror
_SPREAD_M = 0.4  # about each probe: how much of this square is seen fades it in and out at doors
_SOFT_M2 = 0.5  # keeps the share of a probe finite at its own place
_SECOND_FROM = 0.35  # a second probe is mirrored too from this share of the first one's weight


@dataclass(frozen=True, eq=False)
class ProbeMap:
    """The two probes that places mirror."""

    first: NDArray[np.int32]
    second: NDArray[np.int32]
    """(rows along y, columns along x) int32 probes."""
    share: NDArray[np.float32]
    """(rows, columns) float32 share of the second one, 0..0.5 [1]."""
    origin_m: NDArray[np.float64]
    """(2,) x and y of the corner of the first cell [m]."""
    cell_m: float
    """Edge of a cell [m]."""

    def packed(self) -> NDArray[np.float32]:
        """(rows, columns) whole numbers as `reflection.glsl` takes them apart, exact in float32."""
        share = np.rint(self.share * 1023).astype(np.int32)
        return (self.first | self.second << 5 | share << 10).astype(np.float32)


def map_probes(
    place_m: NDArray[np.float64],
    lower_m: NDArray[np.float64],
    upper_m: NDArray[np.float64],
    tracer: RayTracer,
) -> ProbeMap:
    """Map a world between corners onto probes at (P, 3) places, by what is in sight at the height of each.

    The weight of a probe is the share of it in sight over its squared distance. Cells that see none, inside
    walls and cupboards, mirror what the nearest cell that sees one does.
    """
    from scipy.ndimage import distance_transform_edt  # late: checking a recipe draws nothing

    extent = np.maximum(upper_m[:2] - lower_m[:2], CELL_M)
    cell_m = max(CELL_M, float(extent.max()) / _MOST_CELLS)
    columns, rows = np.ceil(extent / cell_m).astype(int)
    x = lower_m[0] + (np.arange(columns) + 0.5) * cell_m
    y = lower_m[1] + (np.arange(rows) + 0.5) * cell_m
    centre = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    weight = _weights(place_m, centre, tracer)
    sees = weight.max(axis=1) > 0
    if sees.any():
        _, (row, column) = distance_transform_edt(~sees.reshape(rows, columns), return_indices=True)
        weight = weight[(row * columns + column).reshape(-1)]
    first, second, share = two_heaviest(weight)
    shape = (rows, columns)
    return ProbeMap(
        first.reshape(shape), second.reshape(shape), share.reshape(shape), lower_m[:2].astype(float), cell_m
    )


def two_heaviest(
    weight: NDArray[np.float64],
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.float32]]:
    """The two probes of the greatest of (N, P) weights, and the share of the second one.

    The share is continuous in the weights: a half where both weigh the same, nothing where a third one takes
    the second's place.

    >>> first, second, share = two_heaviest(np.array([[4.0, 0.0, 1.0], [2.0, 2.0, 0.0], [2.0, 1.0, 1.0]]))
    >>> first.tolist(), second.tolist(), share.tolist()
    ([0, 0, 0], [2, 1, 1], [0.0, 0.5, 0.0])
    """
    padded = np.pad(weight, ((0, 0), (0, max(3 - weight.shape[1], 0))))
    order = np.argsort(-padded, axis=1, kind="stable")[:, :3]
    heaviest, next_, third = np.take_along_axis(padded, order, axis=1).T
    ratio = (next_ - third) / np.maximum(heaviest - third, 1e-12)
    share = 0.5 * np.clip((ratio - _SECOND_FROM) / (1 - _SECOND_FROM), 0, 1)
    most = weight.shape[1] - 1
    first, second = (np.minimum(order[:, index], most).astype(np.int32) for index in (0, 1))
    return first, second, share.astype(np.float32)


def _weights(
    place_m: NDArray[np.float64], centre_m: NDArray[np.float64], tracer: RayTracer
) -> NDArray[np.float64]:
    """(N, P) weights of the probes nearest to each of (N, 2) cells, 0 for the others."""
    squared = ((centre_m[:, None] - place_m[:, :2]) ** 2).sum(axis=2)
    weight = np.zeros_like(squared)
    nearest = np.argsort(squared, axis=1, kind="stable")[:, :_NEAREST]
    around = _SPREAD_M * np.array([(-1, -1), (-1, 1), (1, -1), (1, 1)]) / 2
    for number, place in enumerate(place_m):
        who = np.flatnonzero((nearest == number).any(axis=1))
        origin = np.column_stack([centre_m[who], np.full(len(who), place[2])]).astype(np.float32)
        seen = np.zeros(len(who))
        for offset in around:
            target = (place + np.append(offset, 0.0)).astype(np.float32)
            seen += ~tracer.blocked(origin, target - origin)
        weight[who, number] = seen / len(around) / (squared[who, number] + _SOFT_M2)
    return weight
