"""Lens distortion, as OpenCV writes it, and its inverse.

Coordinates are the tangents of the angles from the optical axis, (pixel - principal point) / focal length.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

_TABLE = 2048
_NEWTON_ROUNDS = 3
_WIDEST_RAD = math.radians(89)
"""A flat image ends before 90 degrees off the axis."""

Points = tuple[NDArray[np.float64], NDArray[np.float64]]


class BrownConrady(NamedTuple):
    """Coefficients of Brown and Conrady's model over powers of the tangent [1].

    References
    ----------
    Brown 1971, "Close-range camera calibration", Photogrammetric Engineering 37(8); OpenCV, calib3d.
    """

    k1: float = 0.0
    k2: float = 0.0
    k3: float = 0.0
    p1: float = 0.0
    p2: float = 0.0

    def distorted(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> Points:
        """Where the lens images points of the undistorted image.

        Examples
        --------
        >>> x, y = BrownConrady(k1=-0.1).distorted(np.array(0.5), np.array(0.0))
        >>> round(x.item(), 4)
        0.4875
        """
        r2 = x**2 + y**2
        radial = 1 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3))
        return (
            x * radial + 2 * self.p1 * x * y + self.p2 * (r2 + 2 * x**2),
            y * radial + self.p1 * (r2 + 2 * y**2) + 2 * self.p2 * x * y,
        )

    def undistorted(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> Points:
        """Which point of the undistorted image the lens images at (x, y).

        Strong barrel distortion folds the image over: nothing is imaged beyond some radius. For places out
        there, the nearest point that is imaged.

        Examples
        --------
        >>> lens = BrownConrady(k1=-0.1, k2=0.02, p1=0.001)
        >>> x, y = lens.undistorted(*lens.distorted(np.array([0.5]), np.array([0.3])))
        >>> x.round(9).tolist(), y.round(9).tolist()
        ([0.5], [0.3])
        """
        x, y = np.broadcast_arrays(x, y)
        radius = np.hypot(x, y)
        table, imaged = self._table(float(radius.max()))
        seen = np.minimum(radius, imaged[-1])
        scale = seen / np.maximum(radius, 1e-12)
        target_x, target_y = x * scale, y * scale
        start = np.interp(seen, imaged, table) / np.maximum(radius, 1e-12)
        u, v = x * start, y * start
        for _ in range(_NEWTON_ROUNDS if self.p1 or self.p2 else 1):  # the table knows radial terms
            u, v = self._newton(u, v, target_x, target_y)
        return u, v

    def reaches(self, radius: float) -> bool:
        """Whether anything is imaged as far out as that, before the image folds over.

        Examples
        --------
        >>> BrownConrady(k1=-0.3).reaches(0.5), BrownConrady(k1=-0.3).reaches(0.8)
        (True, False)
        """
        return bool(self._table(radius)[1][-1] >= radius)

    def _table(self, needed: float) -> Points:
        """Undistorted radii, rising from 0, and where they are imaged: to `needed`, or to the fold."""
        radial = self._replace(p1=0.0, p2=0.0)
        reach = needed
        while True:
            table = np.linspace(0.0, reach, _TABLE)
            imaged, _ = radial.distorted(table, np.zeros(_TABLE))
            falls = np.flatnonzero(np.diff(imaged) <= 0)
            if falls.size:
                last = int(falls[0]) + 1
                return table[:last], imaged[:last]
            if imaged[-1] >= needed:
                return table, imaged
            reach *= 1.5

    def _newton(
        self,
        u: NDArray[np.float64],
        v: NDArray[np.float64],
        x: NDArray[np.float64],
        y: NDArray[np.float64],
    ) -> Points:
        r2 = u**2 + v**2
        radial = 1 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3))
        slope = 2 * (self.k1 + r2 * (2 * self.k2 + 3 * r2 * self.k3))
        x_u = radial + slope * u**2 + 2 * self.p1 * v + 6 * self.p2 * u
        x_v = slope * u * v + 2 * self.p1 * u + 2 * self.p2 * v
        y_v = radial + slope * v**2 + 6 * self.p1 * v + 2 * self.p2 * u
        there_x, there_y = self.distorted(u, v)
        left_x, left_y = x - there_x, y - there_y
        area = x_u * y_v - x_v**2
        area = np.where(area < 1e-3, np.inf, area)  # at a fold there is no way on
        return u + (y_v * left_x - x_v * left_y) / area, v + (x_u * left_y - x_v * left_x) / area


class Fisheye(NamedTuple):
    """Coefficients of OpenCV's fisheye model, over powers of the angle; all 0 is an equidistant lens [1].

    References
    ----------
    Kannala and Brandt 2006, "A generic camera model and calibration method", IEEE Trans. PAMI 28(8);
    OpenCV, namespace fisheye (with k4 = 0).
    """

    k1: float = 0.0
    k2: float = 0.0
    k3: float = 0.0

    def _imaged(self, angle: NDArray[np.float64]) -> NDArray[np.float64]:
        square = angle**2
        return angle * (1 + square * (self.k1 + square * (self.k2 + square * self.k3)))

    def distorted(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> Points:
        """Where the lens images points of the undistorted image.

        Examples
        --------
        >>> x, y = Fisheye().distorted(np.array(1.0), np.array(0.0))
        >>> round(x.item(), 4)  # 45 degrees
        0.7854
        """
        radius = np.hypot(x, y)
        scale = np.where(radius > 1e-12, self._imaged(np.arctan(radius)) / np.maximum(radius, 1e-12), 1.0)
        return x * scale, y * scale

    def undistorted(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> Points:
        """Which point of the undistorted image the lens images at (x, y); at most 89 degrees off the axis."""
        radius = np.hypot(x, y)
        angles = np.linspace(0.0, _WIDEST_RAD, _TABLE)
        imaged = np.maximum.accumulate(self._imaged(angles))
        angle = np.interp(radius, imaged, angles)
        for _ in range(_NEWTON_ROUNDS):
            slope = 1 + angle**2 * (3 * self.k1 + angle**2 * (5 * self.k2 + angle**2 * 7 * self.k3))
            step = (radius - self._imaged(angle)) / np.maximum(slope, 1e-3)
            angle = np.clip(angle + step, 0.0, _WIDEST_RAD)
        scale = np.where(radius > 1e-12, np.tan(angle) / np.maximum(radius, 1e-12), 1.0)
        return x * scale, y * scale
