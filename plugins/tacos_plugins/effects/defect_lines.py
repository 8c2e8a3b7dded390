"""Rows and columns that are offset or dead."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import (
    Captures,
    ImageContext,
    ImageGeometry,
    LookAlike,
    Settings,
    ShownBy,
    Stage,
    generator,
    physical,
    setting,
)
from tacos_plugins.effects import observations
from tacos_plugins.effects.fixed_pattern import in_image
from tacos_plugins.effects.line_defects import bad_lines
from tacos_plugins.effects.samples import Moments, Samples
from tacos_plugins.effects.shown_by import EVEN_FIELD


class DefectLines:
    """A few rows and columns of photosites that stand `offset_dn` above the others, or are dead.

    A line is bad over its whole length and in every frame, with the cap on too; a dead one shows the pedestal
    whatever the light. Which lines are bad belongs to the sensor: with a larger share those of a smaller one
    stay bad. A binned pixel averages its good photosites with the bad ones.

    Source: EMVA 1288, release 4.0: defect pixels. ISO 22534 and camera makers' data sheets count line defects
    separately: a pattern that all lines share a little of is DSNU.
    """

    class Config(Settings):
        column_share: float = setting(
            0.0, help="Share of the columns that are bad; a thousandth is a poor sensor.", ge=0, le=1
        )
        row_share: float = setting(0.0, help="Share of the rows that are bad.", ge=0, le=1)
        offset_dn: float = setting(
            10.0, help="Level of bad lines above the others.", unit="DN", ge=-65535, le=65535
        )
        offset_e: float | None = physical(
            "offset_dn", help="The same in electrons.", unit="e-", ge=-1e6, le=1e6
        )
        dead: bool = setting(False, help="Bad lines show the pedestal alone, in place of an offset.")
        map_seed: int = setting(
            0, help="Names the individual sensor: the same seed has the same bad lines.", ge=0
        )

    stage: ClassVar[Stage] = "pixel"
    rank: ClassVar[int] = 45
    neutral: ClassVar[Mapping[str, Any]] = {"column_share": 0.0, "row_share": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ()
    look_alikes: ClassVar[Sequence[LookAlike]] = (
        LookAlike(
            "row-noise",
            observations.no_repeats,
            "dark",
            "two or more frames of one setting tell lines that are bad from lines that jump",
        ),
        LookAlike(
            "dsnu",
            observations.none_of_kind("dark"),
            "dark",
            "with the cap on a few lines stand out from a pattern that all of them share",
        ),
    )
    shown_by: ClassVar[Sequence[ShownBy]] = (EVEN_FIELD,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def guesses_from(cls, captures: Captures) -> Iterator[Mapping[str, Any]]:
        """The lines that stand out over the whole length of an even field.

        One that is bad over a part of its length is no line defect, but a pattern of its pixels (`dsnu`).
        """
        yield from bad_lines(captures)

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        bad = self._share_of_bad(geometry)
        if bad is None:
            return signal
        if self.config.dead:
            return signal + bad * (signal.dtype.type(context.black_level_dn) - signal)
        return signal + bad * signal.dtype.type(self.config.offset_dn)

    def moments(
        self, mean_dn: Samples, variance_dn2: Samples, *, geometry: ImageGeometry, context: ImageContext
    ) -> Moments:
        """Means with bad lines; the noise that is drawn for them follows the samples."""
        bad = self._share_of_bad(geometry)
        if bad is None:
            return mean_dn, variance_dn2
        offset = context.black_level_dn - mean_dn if self.config.dead else self.config.offset_dn
        return mean_dn + bad * offset, variance_dn2

    def _share_of_bad(self, geometry: ImageGeometry) -> NDArray[np.float32] | None:
        """(H, W, 1) share of each pixel's photosites that lie on bad lines; None where there are none."""
        c, g = self.config, geometry
        columns = _bad(c.map_seed, "columns", g.camera, g.full_width_px, g.binning, c.column_share)
        rows = _bad(c.map_seed, "rows", g.camera, g.full_height_px, g.binning, c.row_share)
        if not (columns.any() or rows.any()):
            return None
        both = 1 - (1 - rows[:, None, None]) * (1 - columns[None, :, None])
        return in_image(both, geometry)


@lru_cache(maxsize=8)
def _bad(seed: int, what: str, camera: str, lines: int, binning: float, share: float) -> NDArray[np.float32]:
    """(lines,) share of the photosites' lines in each line of an image that are bad.

    Of the lines in an order of their own the first are bad, as many as the share says. One that two lines of
    the image share, where the binning is no whole number, counts in each by its part.
    """
    photosites = round(lines * binning)
    order = generator(seed, "pattern", f"defect-{what}", camera).permutation(photosites)
    bad_before = np.zeros(photosites + 1)
    bad_before[1 + order[: round(share * photosites)]] = 1.0
    edges = np.arange(lines + 1) * binning  # of the image's lines, counted in photosites
    bad = np.diff(np.interp(edges, np.arange(photosites + 1), np.cumsum(bad_before))) / binning
    bad = bad.astype(np.float32)
    bad.flags.writeable = False
    return bad
