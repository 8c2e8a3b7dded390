"""Projection of a lens: its reach, and its distortion."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tacos_framework.values.brown_conrady import BrownConrady

Projection = Literal["rectilinear", "equidistant", "equisolid", "stereographic", "kannala-brandt"]

_REACH_DEG: Final = {"rectilinear": 90.0}
"""Angle at which a projection ends; the others image the whole sphere."""

_COEFFICIENTS: Final = {"rectilinear": 5, "kannala-brandt": 4}
_TABLE = 1024
_NEWTON_ROUNDS = 5
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Lens:
    """The projection of a lens; the default is that of a pinhole.

    With the angle t off the axis, a point is imaged at r focal lengths from the principal point:

    ==================  ==========================================================================
    ``rectilinear``     r = tan t: straight lines stay straight; below 180 degrees
    ``equidistant``     r = t
    ``equisolid``       r = 2 sin(t / 2): equal solid angles have equal areas
    ``stereographic``   r = 2 tan(t / 2): small circles stay circles
    ``kannala-brandt``  r = t + k1 t^3 + k2 t^5 + k3 t^7 + k4 t^9, as OpenCV's ``fisheye`` has it
    ==================  ==========================================================================

    All begin as r = t, so a focal length means the same to each: pixels per radian on the axis.

    Sources: Kannala and Brandt 2006, "A generic camera model and calibration method", IEEE Trans. PAMI 28(8);
    Ray 2002, "Applied photographic optics", on the other projections of fisheyes.

    >>> fisheyes = ("equidistant", "equisolid", "stereographic")
    >>> [round(float(Lens(name).radius(math.pi / 2)), 3) for name in fisheyes]
    [1.571, 1.414, 2.0]
    """

    projection: Projection = "rectilinear"
    coefficients: tuple[float, ...] = ()
    """In OpenCV's order: k1 .. k4 of Kannala and Brandt; of a rectilinear lens k1, k2, p1, p2, k3 of Brown
    and Conrady. Those left out are 0 [1].
    """
    half_field_deg: float | None = None
    """The angle off the axis at which the image circle ends, and all is dark beyond; None where it ends with
    the projection [deg].
    """

    def __post_init__(self) -> None:
        if self.projection not in get_args(Projection):
            known = ", ".join(get_args(Projection))
            raise ValueError(f"no projection {self.projection!r}: expected {known}")
        object.__setattr__(self, "coefficients", tuple(float(each) for each in self.coefficients))
        most, given = _COEFFICIENTS.get(self.projection, 0), len(self.coefficients)
        if given > most:
            raise ValueError(f"a lens of projection {self.projection} has {most} coefficients, not {given}")
        if not all(math.isfinite(each) for each in self.coefficients):
            raise ValueError(f"coefficients of a lens must be finite, not {self.coefficients}")
        if self.half_field_deg is not None:
            reach_deg = math.degrees(self.reach_rad)
            if not (0 < self.half_field_deg <= reach_deg * (1 + _ROUNDING)):
                raise ValueError(
                    f"this {self.projection} lens images up to {reach_deg:.4g} deg off its axis, not "
                    f"{self.half_field_deg:.4g}: its field of view ends below {2 * reach_deg:.4g} deg"
                )

    @property
    def is_pinhole(self) -> bool:
        """True if straight lines stay straight all over the image, with no dark corner."""
        return self.is_rectilinear and self.half_field_deg is None and not any(self.coefficients)

    @property
    def is_rectilinear(self) -> bool:
        """True if its image is flat, but for distortion: depth then is measured along the optical axis."""
        return self.projection == "rectilinear"

    @property
    def distortion(self) -> BrownConrady:
        """That of a rectilinear lens; none of others."""
        k1, k2, p1, p2, k3 = (*self.coefficients, *(0.0,) * 5)[:5] if self.is_rectilinear else (0.0,) * 5
        return BrownConrady(k1, k2, k3, p1, p2)

    @cached_property
    def reach_rad(self) -> float:
        """End of the projection: beyond it nothing is imaged, or where something else is [rad]."""
        if self.is_rectilinear:
            return math.atan(self.distortion.fold)
        if self.projection != "kannala-brandt":
            return math.pi
        slopes = [(2 * i + 1) * k for i, k in enumerate((1.0, *self.coefficients))]
        squares = np.roots(slopes[::-1])
        turns = squares.real[(np.abs(squares.imag) < _ROUNDING) & (squares.real > 0)]
        return min(math.pi, math.sqrt(turns.min())) if turns.size else math.pi

    @property
    def widest_rad(self) -> float:
        """The largest angle off the axis that is imaged [rad]."""
        circle_rad = math.inf if self.half_field_deg is None else math.radians(self.half_field_deg)
        return min(self.reach_rad, circle_rad)

    @property
    def image_circle(self) -> float:
        """Radius of what it images [focal lengths]."""
        return (
            math.inf
            if self.widest_rad >= math.pi / 2 and self.is_rectilinear
            else float(self.radius(self.widest_rad))
        )

    def radius(self, angle_rad: ArrayLike) -> NDArray[np.float64]:
        """Distance from the principal point at which an angle off the axis is imaged [focal lengths].

        Tangential distortion, which depends on the direction, is not in it.
        """
        angle = np.asarray(angle_rad, np.float64)
        match self.projection:
            case "equidistant":
                return angle
            case "equisolid":
                return 2 * np.sin(angle / 2)
            case "stereographic":
                return 2 * np.tan(angle / 2)
            case "kannala-brandt":
                square = angle**2
                return angle * np.polynomial.polynomial.polyval(square, (1.0, *self.coefficients))
        flat = np.tan(angle)
        return self.distortion.radial(flat)

    def angle(self, radius: ArrayLike) -> NDArray[np.float64]:
        """The angle off the axis that is imaged at a radius in focal lengths; NaN beyond the circle [rad]."""
        wanted = np.asarray(radius, np.float64)
        with np.errstate(invalid="ignore"):
            found = self._angle(wanted)
            outside = ~(wanted <= self.image_circle * (1 + _ROUNDING))
        return np.where(outside, np.nan, found)

    def field_of_view_deg(self, size: float) -> float:
        """The angle across a length of the image about its principal point [focal lengths to deg].

        >>> Lens().field_of_view_deg(2.0), round(Lens("equidistant").field_of_view_deg(math.pi), 9)
        (90.0, 180.0)
        """
        if self.is_pinhole:
            return math.degrees(2 * math.atan(size / 2))
        return math.degrees(2 * float(np.nan_to_num(self.angle(size / 2), nan=self.widest_rad)))

    def size_of_field(self, field_deg: float) -> float:
        """The length of the image that shows an angle; undoes `field_of_view_deg` [deg to focal lengths].

        Raises `ValueError` where the lens has no such field of view.
        """
        half_rad = math.radians(field_deg) / 2
        if half_rad > self.widest_rad * (1 + _ROUNDING) or (self.is_rectilinear and field_deg >= 180):
            below = f"below {2 * math.degrees(self.widest_rad):.4g} deg"
            raise ValueError(
                f"a field of view of {field_deg:g} deg, where a {self.projection} lens has one {below}"
            )
        return 2 * (math.tan(half_rad) if self.is_pinhole else float(self.radius(half_rad)))

    def _angle(self, radius: NDArray[np.float64]) -> NDArray[np.float64]:
        match self.projection:
            case "equidistant":
                return radius
            case "equisolid":
                return 2 * np.arcsin(np.minimum(radius / 2, 1.0))
            case "stereographic":
                return 2 * np.arctan(radius / 2)
            case "kannala-brandt":
                return self._of_powers(radius)
        return np.arctan(
            self.distortion._replace(p1=0.0, p2=0.0).undistorted(radius, np.zeros_like(radius))[0]
        )

    def _of_powers(self, radius: NDArray[np.float64]) -> NDArray[np.float64]:
        """Newton's method from a table; radius rises with the angle up to `reach_rad`."""
        table = np.linspace(0.0, self.reach_rad, _TABLE)
        angle = np.interp(radius, self.radius(table), table)
        slopes = [(2 * i + 1) * k for i, k in enumerate((1.0, *self.coefficients))]
        for _ in range(_NEWTON_ROUNDS):
            slope = np.polynomial.polynomial.polyval(angle**2, slopes)
            step = (radius - self.radius(angle)) / np.maximum(slope, 1e-3)
            angle = np.clip(angle + step, 0.0, self.reach_rad)
        return angle


PINHOLE: Final = Lens()
"""Lens of a camera unless it is known."""
