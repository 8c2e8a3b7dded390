"""Where a lens images what a pinhole would image elsewhere."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from tacos_framework import ImageContext, ImageGeometry, Settings, Stage, setting

from tacos_lens_prescription.field import field_of
from tacos_lens_prescription.prescription import Floats


class PrescriptionDistortion:
    """Distorts as the chief rays of a prescription do, scaled to the focal length of the camera.

    Beyond the field of the lens the distortion of its edge goes on; no light gets there
    (`effect.prescription-image`). The stop decides which rays are chief rays, its opening does not.

    References
    ----------
    Welford 1986, "Aberrations of Optical Systems", Ch. 4 (ray tracing) and 6.
    """

    class Config(Settings):
        """Settings of the effect."""

        prescription: str = setting("", help="Table of the lens; empty: the triplet.", is_path=True)
        share: float = setting(0.0, help="Share of the lens's distortion; 1 is the lens.", ge=0, le=1)

    stage: ClassVar[Stage] = "optics"
    rank: ClassVar[int] = 10  # ahead of what is measured in the image
    neutral: ClassVar[Mapping[str, Any]] = {"share": 0.0}

    def __init__(self, config: Config) -> None:
        self.config = config

    def source(
        self, *, geometry: ImageGeometry, context: ImageContext, frames: int
    ) -> tuple[Floats, Floats] | None:
        """Where in the pinhole's image each pixel looks, (H, W) columns and rows; None where off [px]."""
        if self.config.share == 0:
            return None
        field = field_of(self.config.prescription, NARROW)
        radius = np.hypot(geometry.x_px, geometry.y_px) / geometry.focal_length_px
        outwards = np.interp(radius, field.height[1:], field.tangent[1:] / field.height[1:])
        scale = 1 + self.config.share * (outwards - 1)
        (column, row) = geometry.centre_px
        return column + geometry.x_px * scale, row + geometry.y_px * scale


NARROW = 16.0
"""An f-number at which the stop, and no rim of a lens, limits the beam."""
