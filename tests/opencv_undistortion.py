"""OpenCV's undistortion of points, iterated to the end, by the name it has in OpenCV 4 and in OpenCV 5."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

_TO_THE_END = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 200, 1e-12)


def undistorted(
    points: NDArray[Any],
    matrix: NDArray[Any],
    coefficients: NDArray[Any],
    new_matrix: NDArray[Any] | None = None,
) -> NDArray[Any]:
    """(n, 1, 2) pixels as (n, 2) rays, or as pixels of another camera without distortion."""
    undistort: Any = getattr(cv2, "undistortPointsIter", cv2.undistortPoints)
    found = undistort(points, matrix, coefficients, R=None, P=new_matrix, criteria=_TO_THE_END)
    return np.asarray(found).reshape(-1, 2)
