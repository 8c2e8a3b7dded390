"""Residual of a picture under a hypothesis, pixel by pixel, once pose, gain and offset are fitted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tacos_framework.formation import EpisodeDraws, PlacedEffect
from tacos_gap.answer.pictures.overlay import laid_over
from tacos_gap.captures import RealCapture
from tacos_gap.simulation.formation import lit_by
from tacos_gap.statistics.grid import TILE_COLUMNS, TILE_ROWS
from tacos_plugins.effects.mosaic_cells import cell_means

LARGEST_SIDE_PX = 768
"""Of larger pictures the middle is compared: it tells as much in a fraction of the time [px]."""

TILES = TILE_ROWS * TILE_COLUMNS


def tile_squares(
    capture: RealCapture, hypotheses: Sequence[Sequence[PlacedEffect]]
) -> NDArray[np.float64] | None:
    """Squares that each hypothesis leaves in the tiles of a structured capture, noise included.

    Effects on light act on the expectation; what acts on samples and files is left out. Each hypothesis is
    then laid over the mean frame, with the gain and offset that fit best.

    - `hypotheses`: j lists of effects.

    Returns: (J, TILES) over the same pixels [DN^2]; None where a hypothesis cannot be laid over the frames.
    """
    assert capture.expected_dn is not None
    black = np.float32(capture.context.black_level_dn)
    full = np.float32(capture.context.white_level_dn) - black
    one = len(capture.expected_dn) == 1
    real = (capture.real_dn.mean(axis=0) if one else capture.real_dn[0]).mean(axis=-1) - black
    light = capture.expected_dn[:1] - black
    valid = capture.valid
    if mosaic := capture.context.cfa is not None:
        real, valid = cell_means(real), cell_means(valid) == 1
    middle = _middle(valid.shape)
    overlays = []
    for effects in hypotheses:
        lit = np.clip(lit_by(capture, effects, light, EpisodeDraws(0, ("picture", capture.id))), 0, full)
        shown = lit[0].mean(axis=-1)
        shown = np.ascontiguousarray((cell_means(shown) if mosaic else shown)[middle], np.float32)
        overlay = laid_over(shown, real[middle])
        if overlay is None:
            return None
        overlays.append(overlay)
    inside = np.logical_and.reduce([valid[middle], *(each.inside for each in overlays)])
    if not inside.any():
        return None
    tile = _tiles(inside.shape)[inside]
    left = [_left(each.image[inside], real[middle][inside]) ** 2 for each in overlays]
    return np.stack([np.bincount(tile, each, TILES) for each in left])


def _left(image: NDArray[np.float32], real: NDArray[np.float32]) -> NDArray[np.float64]:
    """(P,) what the best gain and offset leave."""
    columns = np.stack([image, np.ones_like(image)], axis=1).astype(np.float64)
    fitted, *_ = np.linalg.lstsq(columns, real.astype(np.float64), rcond=None)
    return np.asarray(real - columns @ fitted)


def _middle(shape: tuple[int, ...]) -> tuple[slice, slice]:
    """The middle of an (H, W) picture."""
    rows, columns = (slice(max(n - LARGEST_SIDE_PX, 0) // 2, (n + LARGEST_SIDE_PX) // 2) for n in shape)
    return rows, columns


def _tiles(shape: tuple[int, int]) -> NDArray[np.int64]:
    """(H, W) the tile of each pixel."""
    rows = np.arange(shape[0])[:, None] * TILE_ROWS // shape[0]
    columns = np.arange(shape[1])[None, :] * TILE_COLUMNS // shape[1]
    return np.asarray(rows * TILE_COLUMNS + columns, np.int64)
