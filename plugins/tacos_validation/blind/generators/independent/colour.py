"""Colours by colour-science: lamps and cameras with measured spectra."""

from __future__ import annotations

import warnings
from functools import lru_cache
from typing import Any

import numpy as np

from tacos_validation.blind.generators.camera import IdealShot, Image
from tacos_validation.blind.generators.independent.amplitude import SingleAmplitudeEffect

BALANCED_K = 5500.0
"""Colour temperature for which the camera is balanced [K]."""

MIRED = 400.0
"""Shift of the reciprocal colour temperature at amplitude 1 [1e-6/K]."""


class WarmerLamp(SingleAmplitudeEffect, name="white-balance", place=20):
    """A camera balanced for daylight under a warmer black body, which a Nikon D5100 sees."""

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        black = shot.camera.black_dn
        return black + (codes - black) * np.array(self._gains())

    def _gains(self) -> tuple[float, float, float]:
        kelvin = 1e6 / (1e6 / BALANCED_K + MIRED * self.amplitude)
        red, green, blue = np.array(blackbody_response(kelvin)) / blackbody_response(BALANCED_K)
        return float(red / green), 1.0, float(blue / green)

    @property
    def parameters(self) -> dict[str, Any]:
        red, _, blue = self._gains()
        return {"red": red, "blue": blue}


class OtherCamera(SingleAmplitudeEffect, name="colour-matrix", place=50):
    """Colours through other filters: from a Nikon D5100 to a Sigma SD Merrill, part of the way."""

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        black = shot.camera.black_dn
        matrix = np.eye(3) + self.amplitude * (np.array(between_cameras()) - np.eye(3))
        return np.asarray(black + (codes - black) @ matrix.T)


@lru_cache(maxsize=64)
def blackbody_response(kelvin: float) -> tuple[float, float, float]:
    """Camera's red, green and blue of a black body, up to a factor."""
    colour, filters = _colour(), _sensitivities("Nikon 5100 (NPL)")
    spectrum = colour.sd_blackbody(kelvin, filters.shape).values
    red, green, blue = (filters.values * spectrum[:, None]).sum(axis=0).tolist()
    return red, green, blue


@lru_cache(maxsize=1)
def between_cameras() -> tuple[tuple[float, ...], ...]:
    """The matrix that takes one camera's colours of the ColorChecker nearest to the other's, greys kept."""
    colour = _colour()
    shape = _sensitivities("Nikon 5100 (NPL)").shape
    lamp = colour.SDS_ILLUMINANTS["D65"].copy().align(shape).values
    patches = colour.SDS_COLOURCHECKERS["ColorChecker N Ohta"].values()
    reflectances = np.stack([patch.copy().align(shape).values for patch in patches])
    one, other = (
        _white_is_one(reflectances * lamp, lamp, _sensitivities(name).copy().align(shape).values)
        for name in ("Nikon 5100 (NPL)", "Sigma SDMerill (NPL)")
    )
    fitted = np.linalg.lstsq(one, other, rcond=None)[0].T
    fitted /= fitted.sum(axis=1, keepdims=True)
    return tuple(tuple(row) for row in fitted.tolist())


def _white_is_one(spectra: Image, lamp: Image, filters: Image) -> Image:
    return np.asarray((spectra @ filters) / (lamp @ filters))


def _sensitivities(camera: str) -> Any:
    return _colour().MSDS_CAMERA_SENSITIVITIES[camera]


def _colour() -> Any:
    with warnings.catch_warnings():  # it warns of optional packages that are not there
        warnings.simplefilter("ignore")
        import colour

    return colour
