"""Edges that are overdrawn."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Captures, Estimate, ImageContext, ImageGeometry, Settings, ShownBy, Stage, setting
from tacos_plugins.effects import closed_forms
from tacos_plugins.effects.blur import gaussian_transfer, kernel_of
from tacos_plugins.effects.correlation import correlate
from tacos_plugins.effects.samples import Moments, Samples
from tacos_plugins.effects.shown_by import EDGES

_REACH_SIGMAS = 4.0


class Sharpening:
    """Unsharp mask: adds `amount` times the difference between the image and its Gaussian blur.

    Overshoot stands at edges, and the power of noise rises at high frequencies. The radius counts photosites:
    edges of a binned image are overdrawn as much as by sharpening ahead of the binning, while noise that is
    finer than a binned pixel is not there to be raised.

    Source: Gonzalez & Woods, "Digital Image Processing": unsharp masking.
    """

    class Config(Settings):
        amount: float = setting(
            0.0, help="Factor on what the blur takes away; 0.5 to 2 is usual.", ge=0, le=100
        )
        radius_px: float = setting(1.0, help="Standard deviation of the blur.", unit="px", gt=0, le=20)

    stage: ClassVar[Stage] = "isp"
    rank: ClassVar[int] = 70
    neutral: ClassVar[Mapping[str, Any]] = {"amount": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = (
        {"amount": 0.5, "radius_px": 1.0},
        {"amount": 0.5, "radius_px": 2.0},
    )
    shown_by: ClassVar[Sequence[ShownBy]] = (EDGES,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @cached_property
    def _kernel(self) -> NDArray[np.float64]:
        """(K, K) weights that sum to 1."""
        radius_px = self.config.radius_px
        bell = kernel_of(gaussian_transfer(radius_px), reach_px=_REACH_SIGMAS * radius_px)
        kernel = -self.config.amount * bell
        kernel[len(bell) // 2, len(bell) // 2] += 1 + self.config.amount
        return kernel

    @classmethod
    def estimate_from(cls, captures: Captures) -> Iterator[Estimate]:
        """None, where the noise of neighbours in walls is independent; else it tells not how much."""
        if closed_forms.is_white(captures):
            yield Estimate("amount", 0.0, 0.0, negligible=0.01)

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        return correlate(signal, self._kernel) if self.config.amount else signal

    def moments(
        self, mean_dn: Samples, variance_dn2: Samples, *, geometry: ImageGeometry, context: ImageContext
    ) -> Moments:
        """Moments of noise that was independent; next to the edges the variance is a little larger."""
        if self.config.amount == 0:
            return mean_dn, variance_dn2
        return correlate(mean_dn, self._kernel), correlate(variance_dn2, self._kernel**2)
