"""Pixels that share their signal with their neighbours."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Captures, Estimate, ImageContext, ImageGeometry, Settings, ShownBy, Stage, setting
from tacos_plugins.effects import closed_forms
from tacos_plugins.effects.correlation import correlate
from tacos_plugins.effects.samples import Moments, Samples
from tacos_plugins.effects.shown_by import REPEATED_FLAT

_MOST = 1 / 9
"""Share of a neighbour at which a photosite keeps no more than it gives to each."""

_ITERATIONS = 50


class Crosstalk:
    """Each photosite gives a `share` of its signal to each neighbour beside it, above and below, and of that
    the part `corners` to each of the four at its corners.

    The electrons are counted before they are shared (capacitive coupling between pixels), so the effect
    follows the noise and correlates it, at a distance of one pixel by about twice the share. Blur
    before the noise leaves it white. Light and charge that stray before they are counted are blur of that
    kind, so not this effect.

    Source: Moore, Ninkov & Forrest 2006, "Quantum efficiency overestimation and deterministic cross talk
    resulting from interpixel capacitance", Optical Engineering 45(7).
    """

    class Config(Settings):
        share: float = setting(
            0.0, help="Share of a photosite's signal that goes to each neighbour.", ge=0, le=_MOST
        )
        corners: float = setting(
            1.0,
            help="Share of a neighbour at a corner, over that of one at a side; 0 for four neighbours alone.",
            ge=0,
            le=1,
        )

    stage: ClassVar[Stage] = "pixel"
    after_noise: ClassVar[bool] = True
    rank: ClassVar[int] = 60
    neutral: ClassVar[Mapping[str, Any]] = {"share": 0.0, "corners": 1.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"share": 0.02},)
    shown_by: ClassVar[Sequence[ShownBy]] = (REPEATED_FLAT,)

    def __init__(self, config: Config) -> None:
        self.config = config

    def _kernel(self, binning: float) -> NDArray[np.float64]:
        """(3, 3) shares between blocks of b x b photosites, of which only those at the rim give any away."""
        share, corners = self.config.share, self.config.corners
        side = (binning + 2 * (binning - 1) * corners) / binning**2 * share
        corner = corners * share / binning**2
        kernel = np.array([[corner, side, corner], [side, 0.0, side], [corner, side, corner]])
        kernel[1, 1] = 1 - kernel.sum()
        return kernel

    @classmethod
    def estimate_from(cls, captures: Captures) -> Iterator[Estimate]:
        """From the correlations of neighbours' noise in walls: of those beside each other, and at corners."""
        beside = closed_forms.neighbour_correlation(captures)
        at_corners = closed_forms.neighbour_correlation(captures, diagonal=True)
        if beside is None or at_corners is None:
            return
        share, corner = _shares(beside.value, at_corners.value)
        yield (found := Estimate("share", share, beside.standard_error / 2, negligible=0.002))
        if share > 0 and found.is_seen(0.0):
            ratio = corner / share
            error = float(np.hypot(at_corners.standard_error, ratio * beside.standard_error)) / 2 / share
            yield Estimate("corners", float(np.clip(ratio, 0, 1)), error, negligible=0.2)

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        """The samples, each mixed with its neighbours."""
        return correlate(signal, self._kernel(geometry.binning)) if self.config.share else signal

    def moments(
        self, mean_dn: Samples, variance_dn2: Samples, *, geometry: ImageGeometry, context: ImageContext
    ) -> Moments:
        """Moments of noise that was independent; next to the edges the variance is a little larger."""
        if self.config.share == 0:
            return mean_dn, variance_dn2
        kernel = self._kernel(geometry.binning)
        return correlate(mean_dn, kernel), correlate(variance_dn2, kernel**2)


def _shares(beside: float, at_corners: float) -> tuple[float, float]:
    """Shares of a side and of a corner whose kernel gives white noise these correlations, by iteration."""
    side = corner = 0.0
    for _ in range(_ITERATIONS):
        centre = 1 - 4 * side - 4 * corner
        variance = centre**2 + 4 * side**2 + 4 * corner**2
        new_side = (beside * variance - 4 * side * corner) / (2 * centre)
        new_corner = (at_corners * variance - 2 * side**2) / (2 * centre)
        side, corner = (float(np.clip(each, -_MOST, _MOST)) for each in (new_side, new_corner))
    return side, corner
