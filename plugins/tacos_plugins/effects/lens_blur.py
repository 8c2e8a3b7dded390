"""A lens that is not sharp, or as sharp as diffraction allows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from tacos_framework import (
    Captures,
    Estimate,
    ImageContext,
    ImageGeometry,
    Settings,
    ShownBy,
    Stage,
    physical,
    setting,
    structured,
)
from tacos_plugins.effects import closed_forms
from tacos_plugins.effects.blur import airy_transfer, blur, gaussian_kernel, kernel_of
from tacos_plugins.effects.edge_spread import edge_variances_px2
from tacos_plugins.effects.field_blur import blur_over_field
from tacos_plugins.effects.samples import Samples
from tacos_plugins.effects.shown_by import EDGES

_REACH_RINGS = 8.0


class LensBlur:
    """Blurs the light by a Gaussian that grows over the field, by diffraction, or by both.

    The standard deviation is ``sigma_px (1 + growth r^2)``, with r over half the sensor's diagonal, and so is
    1 + growth times as large at r = 1. Given a wavelength, the light also passes a round aperture of the
    exposure's f-number: an Airy pattern, alike all over the field.

    Source: Goodman 2005, "Introduction to Fourier Optics", Sec. 6.3: the transfer of a round aperture.
    """

    class Config(Settings):
        sigma_px: float = setting(0.0, help="Standard deviation on the axis.", unit="px", ge=0, le=50)
        sigma_um: float | None = physical(
            "sigma_px",
            help="Standard deviation on the axis and on the sensor, in place of sigma_px.",
            unit="um",
            ge=0,
            le=500,
        )
        growth: float = setting(
            0.0, help="Growth of the standard deviation from the axis to the corner.", ge=-1, le=20
        )
        wavelength_nm: float | None = setting(
            None, help="Wavelength of diffraction; none if not given.", unit="nm", ge=100, le=20000
        )

    stage: ClassVar[Stage] = "optics"
    rank: ClassVar[int] = 40
    neutral: ClassVar[Mapping[str, Any]] = {"sigma_px": 0.0, "growth": 0.0, "wavelength_nm": None}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = (
        {"sigma_px": 0.8, "growth": 0.0},
        {"sigma_px": 0.5, "growth": 1.5},
        {"sigma_px": 2.0, "growth": 0.0},
    )
    shown_by: ClassVar[Sequence[ShownBy]] = (EDGES,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def estimate_from(cls, captures: Captures) -> Iterator[Estimate]:
        """The root of the variance that straight edges are spread by."""
        variances = [value for each in structured(captures) for value in edge_variances_px2(each)]
        if spread := closed_forms.mean_of(variances):
            yield Estimate("sigma_px", *closed_forms.root(spread), negligible=0.2)

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        """Light blurred; diffraction needs the context's f-number."""
        c = self.config
        if c.wavelength_nm is not None:
            # A wavelength in nm over a pitch in um: the smallest detail that passes, in pixels.
            detail_px = (
                c.wavelength_nm * 1e-3 * context.known_f_number("effect.lens-blur") / geometry.pixel_um
            )
            kernel = kernel_of(airy_transfer(1 / detail_px), reach_px=_REACH_RINGS * detail_px)
            signal = blur(signal, kernel)
        if c.sigma_px == 0.0:
            return signal
        if c.growth == 0.0:
            return blur(signal, gaussian_kernel(c.sigma_px))
        return blur_over_field(signal, c.sigma_px * (1 + c.growth * geometry.radius**2), gaussian_kernel)
