"""How dark and how blurred the image of a lens becomes towards its edge."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter
from tacos_framework import ImageContext, ImageGeometry, Settings, Stage, setting

from tacos_lens_prescription.field import field_of
from tacos_lens_prescription.prescription import Floats

LEVELS = 8


class PrescriptionImage:
    """Dims and blurs as a prescription does, scaled to the camera's focal length, at the exposure's f-number.

    The spot of each field angle is replaced by a round Gaussian of the same variance. One wavelength, no
    diffraction (`effect.lens-blur` has it), and focus at infinity. Where no ray gets through it is black.

    References
    ----------
    Rimmer 1986, "Relative illumination calculations", Proc. SPIE 655.
    """

    class Config(Settings):
        """Settings of the effect."""

        prescription: str = setting("", help="Table of the lens; empty: the triplet.", is_path=True)
        share: float = setting(0.0, help="Share of the lens's fall-off and blur; 1 is the lens.", ge=0, le=1)

    stage: ClassVar[Stage] = "optics"
    rank: ClassVar[int] = 50
    neutral: ClassVar[Mapping[str, Any]] = {"share": 0.0}

    def __init__(self, config: Config) -> None:
        self.config = config

    def on_array(
        self,
        light: NDArray[Any],
        *,
        geometry: ImageGeometry,
        context: ImageContext,
        rng: np.random.Generator,
    ) -> NDArray[Any]:
        """(N, H, W, C) light behind the lens, of the same shape and type; needs the f-number."""
        share = self.config.share
        if share == 0:
            return light
        field = field_of(self.config.prescription, context.known_f_number("effect.prescription-image"))
        radius = np.hypot(geometry.x_px, geometry.y_px) / geometry.focal_length_px
        kept = 1 + share * (np.interp(radius, field.height, field.light, right=0.0) - 1)
        sigma_px = share * geometry.focal_length_px * np.interp(radius, field.height, field.blur)
        return blurred((light * kept[..., None]).astype(light.dtype), sigma_px)


def blurred(light: NDArray[Any], sigma_px: Floats) -> NDArray[Any]:
    """Light blurred by a Gaussian of another width at each pixel: a mixture of `LEVELS` has its variance.

    Parameters
    ----------
    light
        (N, H, W, C).
    sigma_px
        (H, W) standard deviation [px].
    """
    levels = np.linspace(0.0, sigma_px.max(), LEVELS)
    mixed = np.zeros_like(light)
    for level, chosen in zip(levels, np.eye(LEVELS), strict=True):
        share = np.interp(sigma_px**2, levels**2, chosen)[..., None].astype(light.dtype)
        mixed += share * gaussian_filter(light, (0, level, level, 0), mode="nearest")
    return mixed
