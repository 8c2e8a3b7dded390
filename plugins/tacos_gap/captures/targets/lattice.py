"""Four-sided areas of a picture that stand on one lattice, as patches of a chart do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

_WORKING_PX = 1000
_FEWEST_PATCHES = 10
_STEEP = (0.004, 0.008, 0.016, 0.032)
"""Gradients, over the range per pixel, that may bound a patch: faint borders at little noise, clear ones at
much."""


@dataclass(frozen=True, eq=False)
class Lattice:
    """Four-sided areas of a picture that stand on one lattice, as patches of a chart do."""

    image: NDArray[np.float32]
    scale: float  # its size over the picture's
    quads_px: NDArray[np.float64]  # (K, 4, 2) corners of the areas in it [px]
    places: NDArray[np.int64]  # (K, 2) column and row on the lattice, from 0


def find_lattice(rgb: NDArray[np.floating]) -> Lattice | None:
    """The largest lattice of even, four-sided areas; None with fewer than `_FEWEST_PATCHES`.

    `rgb`: (H, W, 3) values above the pedestal, of any response and white balance.
    """
    scale = min(1.0, _WORKING_PX / max(rgb.shape[:2]))
    whole = np.asarray(rgb, np.float32)
    small = np.asarray(cv2.resize(whole, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.float32)
    quads = _four_sided(small)
    if len(quads) < _FEWEST_PATCHES:
        return None
    found = _largest_lattice(quads.mean(axis=1), side_of(quads))
    if found is None:
        return None
    members, places = found
    return Lattice(small, scale, quads[members], places - places.min(axis=0))


def _four_sided(image: NDArray[np.float32]) -> NDArray[np.float64]:
    """(K, 4, 2) corners of areas that are even, convex and nearly square."""
    steepness = _steepness(image)
    least = (0.015 * max(image.shape[:2])) ** 2
    found: list[NDArray[np.float64]] = []
    for steep in _STEEP:
        even = cv2.erode((steepness < steep).astype(np.uint8), np.ones((3, 3), np.uint8))
        contours, _ = cv2.findContours(even, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
        holes, _ = cv2.findContours(even, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
        for contour in (*contours, *holes):
            if cv2.contourArea(contour) < least:
                continue
            hull = cv2.convexHull(contour)
            quad = cv2.approxPolyDP(hull, 0.08 * cv2.arcLength(hull, True), True).reshape(-1, 2)
            if len(quad) == 4 and _nearly_square(quad, cv2.contourArea(contour)):
                found.append(_in_order(quad.astype(np.float64)))
    return _without_doubles(found)


def _steepness(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """(H, W) largest gradient of any channel's square root, over its range: dark steps count like bright."""
    steepest = np.zeros(image.shape[:2], np.float32)
    for channel in range(3):
        root = np.sqrt(np.maximum(image[..., channel], 0))
        root = cv2.GaussianBlur(root / max(float(np.percentile(root, 99.5)), 1e-6), (0, 0), 1.0)
        dx, dy = (cv2.Scharr(root, cv2.CV_32F, *way) / 32 for way in ((1, 0), (0, 1)))
        steepest = np.maximum(steepest, np.hypot(dx, dy))
    return steepest


def _nearly_square(quad: NDArray[Any], area: float) -> bool:
    sides = np.linalg.norm(np.diff(quad, axis=0, append=quad[:1]).astype(float), axis=1)
    own = abs(cv2.contourArea(quad))
    return bool(
        sides.min() > 0.55 * sides.max() and 0.8 * own < area < 1.25 * own and own > 0.5 * sides.min() ** 2
    )


def _in_order(quad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Corners clockwise on the screen."""
    around = quad - quad.mean(axis=0)
    return quad[np.argsort(np.arctan2(around[:, 1], around[:, 0]))]


def side_of(quads: NDArray[np.float64]) -> NDArray[np.float64]:
    """(K,) mean side of each of (K, 4, 2) four-sided areas."""
    return np.asarray(np.linalg.norm(np.diff(quads, axis=1, append=quads[:, :1]), axis=2).mean(axis=1))


def _without_doubles(quads: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    """One quad for each place, of those of about the same size."""
    kept: list[NDArray[np.float64]] = []
    for quad in sorted(quads, key=lambda q: -abs(cv2.contourArea(q.astype(np.float32)))):
        side = float(side_of(quad[None])[0])
        if all(np.linalg.norm(quad.mean(axis=0) - other.mean(axis=0)) > 0.5 * side for other in kept):
            kept.append(quad)
    return np.array(kept).reshape(-1, 4, 2)


def _largest_lattice(
    centres: NDArray[np.float64], sides: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]] | None:
    """Centres that stand on one lattice, and their (column, row) on it.

    Grown from each centre along its two nearest neighbours; steps follow the neighbours already found, so
    that perspective bends the lattice as it likes.
    """
    best: dict[int, tuple[int, int]] = {}
    for seed in range(len(centres)):
        alike = np.flatnonzero(np.abs(np.log(sides / sides[seed])) < 0.35)
        steps = _two_steps(centres, seed, alike, sides[seed])
        if steps is None:
            continue
        grown = _grown(centres, seed, steps, set(alike.tolist()))
        if len(grown) > len(best):
            best = grown
    if len(best) < _FEWEST_PATCHES:
        return None
    members = np.array(sorted(best))
    return members, np.array([best[k] for k in members.tolist()])


def _two_steps(
    centres: NDArray[np.float64], seed: int, alike: NDArray[np.int64], side: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Steps to the nearest neighbour, and to the nearest about square to it, clockwise of the first."""
    away = centres[alike] - centres[seed]
    far = np.linalg.norm(away, axis=1)
    for k in np.argsort(far):
        if not 0.9 * side < far[k] < 1.8 * side:
            continue
        first = away[k]
        cosine = np.abs(away @ first) / np.maximum(far * far[k], 1e-9)
        square = np.flatnonzero((cosine < 0.4) & (far > 0.9 * side) & (far < 1.8 * side))
        if len(square):
            second = away[square[np.argmin(far[square])]]
            if first[0] * second[1] - first[1] * second[0] < 0:
                second = -second
            if abs(first[1]) > abs(first[0]):  # columns run along the picture's rows where they can
                first, second = -second, first
            return (first, second) if first[0] > 0 else (-first, -second)
    return None


def _grown(
    centres: NDArray[np.float64],
    seed: int,
    steps: tuple[NDArray[np.float64], NDArray[np.float64]],
    free: set[int],
) -> dict[int, tuple[int, int]]:
    placed = {seed: (0, 0)}
    queue = [(seed, steps)]
    free = free - {seed}
    taken = {(0, 0)}
    while queue:
        here, (right, down) = queue.pop(0)
        column, row = placed[here]
        for move, (dx, dy) in ((right, (1, 0)), (-right, (-1, 0)), (down, (0, 1)), (-down, (0, -1))):
            place = column + dx, row + dy
            if place in taken or not free:
                continue
            rest = np.array(sorted(free))
            miss = np.linalg.norm(centres[rest] - centres[here] - move, axis=1)
            if miss.min() < 0.25 * np.linalg.norm(move):
                there = int(rest[miss.argmin()])
                went = centres[there] - centres[here]
                own = (went * dx, down) if dx else (right, went * dy)
                placed[there] = place
                taken.add(place)
                free.discard(there)
                queue.append((there, own))
    return placed
