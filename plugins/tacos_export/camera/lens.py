"""A lens in the models of OpenCV, which the programs that read our files know."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tacos_framework import Camera, Lens

LensModel = Literal["brown", "fisheye"]
"""OpenCV's: Brown and Conrady with (k1, k2, p1, p2, k3), Kannala and Brandt with (k1, k2, k3, k4)."""


@dataclass(frozen=True)
class LensDescription:
    """A lens as files describe it: coefficients in OpenCV's order, and in sentences what they leave out."""

    model: LensModel
    coefficients: tuple[float, ...]
    limitations: tuple[str, ...] = ()


def described_lens(camera: Camera) -> LensDescription:
    """The lens of a camera in OpenCV's models; those of other projections are fitted over its image."""
    lens = camera.lens
    said = [_circle(camera)] if lens.half_field_deg is not None else []
    if lens.is_rectilinear:
        return LensDescription("brown", _padded(lens, 5), tuple(said))
    if lens.projection in ("equidistant", "kannala-brandt"):
        return LensDescription("fisheye", _padded(lens, 4), tuple(said))
    coefficients, off = fitted_powers(lens, _widest_rad(camera))
    said.append(
        f"files have powers of the angle for the {lens.projection} lens, within "
        f"{off * camera.focal_length_px:.2g} px of it"
    )
    return LensDescription("fisheye", coefficients, tuple(said))


def fitted_powers(lens: Lens, widest_rad: float) -> tuple[tuple[float, ...], float]:
    """k1 .. k4 of Kannala and Brandt's model that follow a lens, and the largest distance [focal lengths].

    >>> k, off = fitted_powers(Lens("equisolid"), math.radians(95))
    >>> round(k[0], 4), off < 1e-6  # - 1 / 24, as the sine's series has it
    (-0.0417, True)
    """
    angle = np.linspace(0.0, widest_rad, 400)[1:]
    powers = angle[:, None] ** (3 + 2 * np.arange(4))
    beyond = lens.radius(angle) - angle
    found = np.linalg.lstsq(powers, beyond, rcond=None)[0]
    return tuple(float(each) for each in found), float(np.abs(powers @ found - beyond).max())


def _padded(lens: Lens, count: int) -> tuple[float, ...]:
    return (*lens.coefficients, *(0.0,) * count)[:count]


def _widest_rad(camera: Camera) -> float:
    diagonal = math.hypot(camera.width_px, camera.height_px) / camera.focal_length_px
    return math.radians(camera.lens.field_of_view_deg(diagonal)) / 2


def _circle(camera: Camera) -> str:
    radius_px = camera.lens.image_circle * camera.focal_length_px
    return f"beyond {radius_px:.4g} px from the principal point images are dark, which these files cannot say"
