"""Patterns fixed to a sensor: the same in every frame, for every candidate, in every process."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tacos_files.arrays import read_npy
from tacos_framework import Fault, ImageGeometry, Settings, UserError, generator, setting

_KEPT = 8  # patterns kept for the next batch; a candidate with another sensor draws anew


class PatternSettings(Settings):
    map_seed: int = setting(
        0, help="Names the individual sensor: the same seed has the same pattern, frame after frame.", ge=0
    )
    map: str | None = setting(
        None,
        help=(
            "A measured pattern in place of a drawn one: .npy of the sensor's (height, width[, channels]). "
            "Its mean is taken out and its spread set to sigma."
        ),
        is_path=True,
    )


def pixel_pattern(
    name: str, config: PatternSettings, geometry: ImageGeometry, channels: int
) -> NDArray[np.float32]:
    """(H, W, C) numbers of mean 0 and variance 1, one for each photosite of an image.

    - `name`: what the pattern is for; patterns of different names are independent.
    - `config`: the seed, or a measured map.
    - `geometry`: where the image lies on the sensor: a crop shows its part of the pattern.
    - `channels`: number of channels C; each has photosites of its own.
    """
    if config.map is not None:
        full = _measured(config.map, geometry.full_height_px, geometry.full_width_px, channels)
    else:
        full = _drawn(
            config.map_seed, name, geometry.camera, geometry.full_height_px, geometry.full_width_px, channels
        )
    return in_image(full, geometry)


def column_pattern(name: str, map_seed: int, geometry: ImageGeometry) -> NDArray[np.float32]:
    """(1, W, 1) numbers of mean 0 and variance 1, one for each column: its amplifier serves every channel."""
    return in_image(_drawn(map_seed, name, geometry.camera, 1, geometry.full_width_px, 1), geometry)


def in_image(full: NDArray[np.float32], geometry: ImageGeometry) -> NDArray[np.float32]:
    """The part of a sensor's pattern that an image shows; a pattern of one row holds for all rows."""
    x, y = geometry.offset_px
    rows = slice(None) if len(full) == 1 else slice(y, y + geometry.height_px)
    return full[rows, x : x + geometry.width_px]


@lru_cache(maxsize=_KEPT)
def _drawn(seed: int, name: str, camera: str, height: int, width: int, channels: int) -> NDArray[np.float32]:
    drawn = generator(seed, "pattern", name, camera).standard_normal((height, width, channels), np.float32)
    drawn.flags.writeable = False
    return drawn


@lru_cache(maxsize=_KEPT)
def _measured(path: str, height: int, width: int, channels: int) -> NDArray[np.float32]:
    wanted = f"an .npy array of ({height}, {width}) or ({height}, {width}, {channels}) numbers"
    found = read_npy(Path(path))
    if found.shape not in ((height, width), (height, width, channels)):
        raise UserError(
            Fault(
                path,
                f"the map has the shape {found.shape}, which is not that of the sensor of this camera",
                wanted,
                "A map belongs to one specimen of a sensor and says nothing of others: leave it out for "
                "another camera, and a pattern of the same spread is drawn.",
            )
        )
    pattern = found.reshape(height, width, -1).astype(np.float32)
    spread = pattern.std()
    if not np.isfinite(spread) or spread == 0:
        raise UserError(
            Fault(path, "the map is flat or holds values that are no numbers", wanted, "Measure it again.")
        )
    pattern = (pattern - pattern.mean()) / spread
    pattern.flags.writeable = False
    return pattern
