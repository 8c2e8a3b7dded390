"""Pixels that share their signal with their neighbours."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import (
    Captures,
    Estimate,
    ImageContext,
    ImageGeometry,
    Settings,
    ShownBy,
    Stage,
    setting,
)
from tacos_plugins.effects import closed_forms
from tacos_plugins.effects.correlation import correlate
from tacos_plugins.effects.pointwise import Moments
from tacos_plugins.effects.shown_by import REPEATED_FLAT


class Crosstalk:
    """Each photosite gives a `share` of its signal to each of its eight neighbours.

    The electrons are counted before they are shared (capacitive coupling between pixels), so the effect
    follows the noise and correlates it, at a distance of one pixel by about twice the share. Blur
    before the noise leaves it white. Light and charge that stray before they are counted are blur of that
    kind, so not this effect.

    References
    ----------
    Moore, Ninkov & Forrest 2006, "Quantum efficiency overestimation and deterministic cross talk resulting
    from interpixel capacitance", Optical Engineering 45(7).
    """

    class Config(Settings):
        """Settings of the effect."""

        share: float = setting(
            0.0, help="Share of a photosite's signal that goes to each neighbour.", ge=0, le=1 / 9
        )

    stage: ClassVar[Stage] = "pixel"
    after_noise: ClassVar[bool] = True
    rank: ClassVar[int] = 60
    neutral: ClassVar[Mapping[str, Any]] = {"share": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"share": 0.02},)
    shown_by: ClassVar[Sequence[ShownBy]] = (REPEATED_FLAT,)

    def __init__(self, config: Config) -> None:
        self.config = config

    def _kernel(self, binning: float) -> NDArray[np.float64]:
        """(3, 3) shares between blocks of b x b photosites, of which only those at the rim give any away."""
        side = (3 * binning - 2) / binning**2 * self.config.share
        corner = self.config.share / binning**2
        kernel = np.array([[corner, side, corner], [side, 0.0, side], [corner, side, corner]])
        kernel[1, 1] = 1 - kernel.sum()
        return kernel

    @classmethod
    def estimate_from(cls, captures: Captures) -> Iterator[Estimate]:
        """Half of the correlation of neighbours' noise in walls, which is about two shares."""
        if found := closed_forms.neighbour_correlation(captures):
            yield Estimate("share", found.value / 2, found.standard_error / 2, negligible=0.002)

    def on_array(
        self,
        signal: NDArray[np.floating],
        *,
        geometry: ImageGeometry,
        context: ImageContext,
        rng: np.random.Generator,
    ) -> NDArray[np.floating]:
        """The samples, each mixed with its neighbours."""
        return correlate(signal, self._kernel(geometry.binning)) if self.config.share else signal

    def moments(
        self,
        mean_dn: NDArray[np.floating],
        variance_dn2: NDArray[np.floating],
        *,
        geometry: ImageGeometry,
        context: ImageContext,
    ) -> Moments:
        """Moments of noise that was independent; next to the edges the variance is a little larger."""
        if self.config.share == 0:
            return mean_dn, variance_dn2
        kernel = self._kernel(geometry.binning)
        return correlate(mean_dn, kernel), correlate(variance_dn2, kernel**2)
