"""Colours mixed from one another."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import field_validator

from tacos_framework import (
    Captures,
    ContextMissing,
    ImageContext,
    ImageGeometry,
    Settings,
    ShownBy,
    Stage,
    lit,
    setting,
)
from tacos_plugins.effects.samples import Moments, Samples
from tacos_plugins.effects.shown_by import COLOURS

Row = tuple[float, float, float]
Matrix = tuple[Row, Row, Row]
IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_ROUNDED = 1e-3  # how far a row's sum may be from 1, so that published matrices of three digits pass


class ColourMatrix:
    """Gives each colour ``matrix @ colour``, above the pedestal; rows that sum to 1 leave greys as they are.

    It acts on noisy samples and so correlates the noise of the channels: S becomes M S M^T.

    Source: Ramanath et al. 2005, "Color image processing pipeline", IEEE Signal Processing Magazine 22(1).
    """

    class Config(Settings):
        matrix: Matrix = setting(
            IDENTITY, help="Rows give red, green and blue of the output; each sums to 1."
        )

        @field_validator("matrix")
        @classmethod
        def _greys_stay(cls, matrix: Matrix) -> Matrix:
            sums = [sum(row) for row in matrix]
            if any(abs(total - 1) > _ROUNDED for total in sums):
                raise ValueError(f"rows that sum to 1, not to {', '.join(f'{total:g}' for total in sums)}")
            return matrix

    stage: ClassVar[Stage] = "isp"
    rank: ClassVar[int] = 50
    of_colours: ClassVar[bool] = True
    neutral: ClassVar[Mapping[str, Any]] = {"matrix": IDENTITY}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = (
        {"matrix": ((1.2, -0.1, -0.1), (-0.1, 1.2, -0.1), (-0.1, -0.1, 1.2))},
    )
    shown_by: ClassVar[Sequence[ShownBy]] = (COLOURS,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def guesses_from(cls, captures: Captures) -> Iterator[Mapping[str, Any]]:
        """The least-squares matrix of the capture with the widest range of colours, rows made to sum to 1."""
        widest: tuple[float, NDArray[np.float64] | None] = (0.0, None)
        for capture in lit(captures):
            if capture.expected_dn is None or capture.expected_dn.shape[-1] != 3:
                continue
            black, white = capture.context.black_level_dn, capture.context.white_level_dn
            expected = capture.expected_dn.mean(axis=0)
            used = capture.valid & (expected.max(axis=-1) < 0.9 * white)
            a = (expected[used] - black)[::11]
            b = (capture.real_dn.mean(axis=0)[used] - black)[::11]
            if len(a) < 100:
                continue
            spread = float(np.linalg.svd(a - a.mean(axis=0), compute_uv=False)[-1]) / np.sqrt(len(a)) / white
            if spread > max(widest[0], 0.005):
                matrix = np.linalg.lstsq(a, b, rcond=None)[0].T
                widest = (spread, matrix / matrix.sum(axis=1, keepdims=True))
        if widest[1] is not None:
            yield {"matrix": widest[1].tolist()}

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        if self.config.matrix == IDENTITY:
            return signal
        _need_colour(signal.shape[-1])
        mixed = (signal - context.black_level_dn) @ np.array(self.config.matrix, signal.dtype).T
        mixed += context.black_level_dn
        return mixed

    def moments(
        self, mean_dn: Samples, variance_dn2: Samples, *, geometry: ImageGeometry, context: ImageContext
    ) -> Moments:
        """Moments of mixed channels, whose noises were independent."""
        if self.config.matrix == IDENTITY:
            return mean_dn, variance_dn2
        _need_colour(mean_dn.shape[-1])
        matrix = np.array(self.config.matrix)
        mean = (mean_dn - context.black_level_dn) @ matrix.T + context.black_level_dn
        return mean, variance_dn2 @ (matrix**2).T


def _need_colour(channels: int) -> None:
    if channels != 3:
        raise ContextMissing("effect.colour-matrix needs images in colour")
