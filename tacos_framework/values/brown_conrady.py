"""Distortion of flat images, as OpenCV writes it, and its inverse.

Coordinates are the tangents of the angles from the optical axis, (pixel - principal point) / focal length.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

_TABLE = 2048
_NEWTON_ROUNDS = 3
Points = tuple[NDArray[np.float64], NDArray[np.float64]]


class BrownConrady(NamedTuple):
    """Coefficients of Brown and Conrady's model over powers of the tangent [1].

    Source: Brown 1971, "Close-range camera calibration", Photogrammetric Engineering 37(8); OpenCV, calib3d.
    """

    k1: float = 0.0
    k2: float = 0.0
    k3: float = 0.0
    p1: float = 0.0
    p2: float = 0.0

    def distorted(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> Points:
        """Images of points of the undistorted image.

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

    def radial(self, radius: NDArray[np.float64]) -> NDArray[np.float64]:
        """Image of a radius of the undistorted image, but for tangential terms."""
        r2 = radius**2
        return radius * (1 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3)))

    def undistorted(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> Points:
        """The point of the undistorted image that the lens images at (x, y).

        Strong barrel distortion folds the image over: nothing is imaged beyond some radius. For places out
        there, the nearest point that is imaged.

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

    @property
    def fold(self) -> float:
        """The undistorted radius beyond which the image folds back over itself; infinite where it never does.

        >>> round(BrownConrady(k1=-1 / 3).fold, 6), BrownConrady(k1=0.1).fold
        (1.0, inf)
        """
        squares = np.roots([7 * self.k3, 5 * self.k2, 3 * self.k1, 1.0])
        turns = squares.real[(np.abs(squares.imag) < 1e-9) & (squares.real > 0)]
        return float(np.sqrt(turns.min())) if turns.size else np.inf

    def reaches(self, radius: float) -> bool:
        """True if anything is imaged as far out as that, before the image folds over.

        >>> BrownConrady(k1=-0.3).reaches(0.5), BrownConrady(k1=-0.3).reaches(0.8)
        (True, False)
        """
        return bool(self._table(radius)[1][-1] >= radius)

    def _table(self, needed: float) -> Points:
        """Undistorted radii, rising from 0, and where they are imaged: to `needed`, or to the fold."""
        reach = needed
        while True:
            table = np.linspace(0.0, reach, _TABLE)
            imaged = self.radial(table)
            falls = np.flatnonzero(np.diff(imaged) <= 0)
            if falls.size:
                last = int(falls[0]) + 1
                return table[:last], imaged[:last]
            if imaged[-1] >= needed:
                return table, imaged
            reach *= 1.5

    def _newton(
        self, u: NDArray[np.float64], v: NDArray[np.float64], x: NDArray[np.float64], y: NDArray[np.float64]
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
