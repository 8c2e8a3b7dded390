"""A lens that bends straight lines."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from tacos_framework import (
    BrownConrady,
    Captures,
    Estimate,
    ImageContext,
    ImageGeometry,
    LookAlike,
    ObservedCapture,
    Settings,
    ShownBy,
    Stage,
    setting,
)
from tacos_framework.camera import Places
from tacos_plugins.effects import observations
from tacos_plugins.effects.board_calibration import Calibration, calibrated
from tacos_plugins.effects.powers_of_angle import radius_without
from tacos_plugins.effects.shown_by import BOARDS

Powers = tuple[float, float, float, float]
"""k1 to k4 of a fisheye."""

_RADIAL = ("k1", "k2", "k3", "k4")

_MIXED = 5.0
"""Standard error of a coefficient over that it has alone: the others, and poses, move much as it does."""

_CLEARLY = 0.9
"""Misfit of one model of a lens over that of another below which it surely is the better: noise makes 1 %."""


class LensDistortion:
    """Distorts the image as OpenCV's `projectPoints` does, over the focal length and principal point.

    On a camera that is a fisheye, the coefficients of the model ``fisheye`` are added to its own curve; those
    of ``brown`` act on its image.

    Of a barrel the edges show more than was rendered; there the edge of the image is drawn out. Depth and ids
    are moved along. Tasks that take the camera for a pinhole feel the distortion, as an uncalibrated camera
    makes them.

    Sources: Brown 1971, "Close-range camera calibration", Photogrammetric Engineering 37(8); for ``fisheye``
    Kannala and Brandt 2006, IEEE Trans. PAMI 28(8).
    """

    class Config(Settings):
        model: Literal["brown", "fisheye"] = setting(
            "brown", help="OpenCV's model: powers of the tangent, or of the angle."
        )
        k1: float = setting(0.0, help="Radial coefficient of third order.", ge=-100, le=100)
        k2: float = setting(0.0, help="Radial coefficient of fifth order.", ge=-1e4, le=1e4)
        k3: float = setting(0.0, help="Radial coefficient of seventh order.", ge=-1e6, le=1e6)
        k4: float = setting(
            0.0, help="Radial coefficient of ninth order, of the fisheye model.", ge=-1e6, le=1e6
        )
        p1: float = setting(0.0, help="First tangential coefficient.", ge=-1, le=1)
        p2: float = setting(0.0, help="Second tangential coefficient.", ge=-1, le=1)

        @model_validator(mode="after")
        def _each_model_has_its_terms(self) -> LensDistortion.Config:
            if self.model == "fisheye" and (self.p1 or self.p2):
                raise ValueError("the fisheye model has no tangential coefficients p1, p2: leave them 0")
            if self.model == "brown" and self.k4:
                raise ValueError("the brown model has no coefficient k4 here: leave it 0")
            return self

    stage: ClassVar[Stage] = "optics"
    rank: ClassVar[int] = 10
    neutral: ClassVar[Mapping[str, Any]] = {
        "model": "brown",
        "k1": 0.0,
        "k2": 0.0,
        "k3": 0.0,
        "k4": 0.0,
        "p1": 0.0,
        "p2": 0.0,
    }
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = (
        {"k1": -0.1},
        {"k2": -0.05},
        {"k3": -0.05},
        {"p1": 0.002},
        {"p2": 0.002},
    )
    series: ClassVar[Sequence[Sequence[str]]] = (_RADIAL,)
    look_alikes: ClassVar[Sequence[LookAlike]] = (
        LookAlike(
            "pose-error",
            observations.one_view,
            "board",
            "further tilted views tell the lens from a bent board",
        ),
    )
    shown_by: ClassVar[Sequence[ShownBy]] = (BOARDS,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def estimate_from(cls, captures: Captures) -> Iterator[Estimate]:
        """Brown and Conrady's lens that OpenCV calibrates from boards, over the believed focal length.

        Its error is that of as many corners with the misfit that is left; what moves the farthest of them by
        an eighth of a pixel is negligible. Where a fisheye suits clearly better, its terms tell nothing.
        """
        found, fisheye = calibrated(captures, terms=2), calibrated(captures, terms=3, fisheye=True)
        if found and fisheye and fisheye.rms_px < _CLEARLY * found.rms_px:
            return
        seen = [each for each in captures if each.corners is not None]
        if not found or not all(_images_all(BrownConrady(*found.radial), each) for each in seen):
            return
        offsets = [
            np.hypot(*(each.corners[1] - each.geometry.centre_px).T) / each.geometry.focal_length_px
            for each in seen
            if each.corners is not None
        ]
        radius = np.concatenate(offsets)
        focal_px = seen[0].geometry.focal_length_px
        for name, value, power in zip(("k1", "k2"), found.radial, (3, 5), strict=False):
            lever_px = focal_px * radius**power
            error = _MIXED * found.rms_px / float(np.sqrt(np.sum(lever_px**2)))
            yield Estimate(name, value, error, negligible=0.125 / float(lever_px.max()))

    @classmethod
    def guesses_from(cls, captures: Captures) -> Iterator[Mapping[str, Any]]:
        """The lenses of either model that OpenCV calibrates from boards, over the believed focal length."""
        for terms in (1, 2, 3):
            found = calibrated(captures, terms=terms)
            if found and all(_images_all(BrownConrady(*found.radial), capture) for capture in captures):
                yield dict(zip(("k1", "k2", "k3")[:terms], found.radial, strict=False))
        three, four = (calibrated(captures, terms=terms, fisheye=True) for terms in (3, 4))
        of_pinhole = all(each.geometry.lens.is_pinhole for each in captures)
        if three and of_pinhole:
            yield _fisheye(three, 3)
        if four and not (three and of_pinhole and four.rms_px > _CLEARLY * three.rms_px):
            yield _fisheye(four, 4)

    @property
    def _off(self) -> bool:
        return not any(self._distortion)

    @property
    def _distortion(self) -> BrownConrady | Powers:
        c = self.config
        if c.model == "fisheye":
            return c.k1, c.k2, c.k3, c.k4
        return BrownConrady(c.k1, c.k2, c.k3, c.p1, c.p2)

    def source(self, *, geometry: ImageGeometry, context: ImageContext, frames: int) -> Places | None:
        """Places in the pinhole's image at which pixels look, (H, W); None where off [px]."""
        return None if self._off else _source(self._distortion, geometry)

    def source_at(
        self, x_px: NDArray[np.float64], y_px: NDArray[np.float64], *, geometry: ImageGeometry
    ) -> Places:
        """Places in the pinhole's image at which points of the image look [px]."""
        return (x_px, y_px) if self._off else _source_at(self._distortion, x_px, y_px, geometry)


def _fisheye(found: Calibration, terms: int) -> Mapping[str, Any]:
    return {"model": "fisheye", **dict(zip(_RADIAL[:terms], found.radial, strict=False))}


def _images_all(lens: BrownConrady, capture: ObservedCapture) -> bool:
    """True if a lens reaches the points of a capture's board: powers may turn back before."""
    if capture.corners is None:
        return True
    offsets = (capture.corners[1] - capture.geometry.centre_px) / capture.geometry.focal_length_px
    return lens.reaches(float(np.hypot(*offsets.T).max()))


@lru_cache(maxsize=2)  # of a design's frames all look alike
def _source(distortion: BrownConrady | Powers, geometry: ImageGeometry) -> Places:
    cx, cy = geometry.centre_px
    return _source_at(distortion, geometry.x_px + cx, geometry.y_px + cy, geometry)


def _source_at(
    distortion: BrownConrady | Powers,
    x_px: NDArray[np.float64],
    y_px: NDArray[np.float64],
    geometry: ImageGeometry,
) -> Places:
    f = geometry.focal_length_px
    cx, cy = geometry.centre_px
    x, y = (x_px - cx) / f, (y_px - cy) / f
    if isinstance(distortion, BrownConrady):
        x, y = distortion.undistorted(x, y)
    else:
        radius = np.hypot(x, y)
        seen = radius_without(radius, distortion, geometry.lens)
        scale = np.where(radius > 1e-12, seen / np.maximum(radius, 1e-12), 1.0)
        x, y = x * scale, y * scale
    return x * f + cx, y * f + cy
