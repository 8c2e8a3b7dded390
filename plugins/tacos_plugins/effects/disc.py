"""The kernel of an even disc: what light out of focus spreads over."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq


def disc_kernel(radius_px: float) -> NDArray[np.float64]:
    """The pixels' shares of a disc, with the variance of the disc that is asked for.

    Light falls on areas, so a tap is the share of the disc that lies on its pixel; none is negative, and a
    lamp has no dark ring. Shares on pixels alone would blur by the pixel's width a second time, as the image
    is averaged over pixels already. So the disc that is laid on the pixels is a little smaller, such that the
    taps' variance along each axis is R^2 / 4, that of the disc of radius R: exactly, however small R is. Up
    to an eighth of a cycle per pixel the transfer is that of the disc, 2 J1(z) / z, within 0.01.

    `radius_px`: R, above 0 [px].

    Returns: (K, K) float64 with K odd: never negative, sum 1, the same in its eight reflections.

    >>> disc_kernel(0.4).round(3).tolist()  # 0.4^2 / 4 = 2 * 0.02
    [[0.0, 0.02, 0.0], [0.02, 0.92, 0.02], [0.0, 0.02, 0.0]]
    >>> kernel = disc_kernel(5.0)
    >>> bool(abs(kernel.sum(axis=0) @ np.arange(-5, 6) ** 2 - 5.0**2 / 4) < 1e-9)
    True
    """
    variance = radius_px**2 / 4
    laid_px = brentq(lambda radius: _variance(radius) - variance, 0.5, radius_px + 1, xtol=1e-12)
    return covered_shares(float(laid_px))


def covered_shares(radius_px: float) -> NDArray[np.float64]:
    """Shares of a disc's area that lie on each pixel, the disc's centre being that of the middle pixel.

    `radius_px`: R, at least 0.5 [px].

    Returns: (K, K) float64, K = 2 ceil(R - 0.5) + 1, sum 1.
    """
    x, y = np.meshgrid(_edges(radius_px), _edges(radius_px))
    end = np.sqrt(np.maximum(radius_px**2 - y**2, 0.0))  # of the chord at each y
    x = np.minimum(x, end)
    # The disc's area beyond both x and y, and of it what lies within each pixel of one quadrant.
    beyond = _under_circle(end, radius_px) - _under_circle(x, radius_px) - y * (end - x)
    area = beyond[:-1, :-1] - beyond[1:, :-1] - beyond[:-1, 1:] + beyond[1:, 1:]
    area[0] *= 2  # the middle row and column lie half in the next quadrant
    area[:, 0] *= 2
    half = np.concatenate([area[:0:-1], area])
    shares = np.maximum(np.concatenate([half[:, :0:-1], half], axis=1), 0.0)
    return np.asarray(shares / shares.sum())


def _variance(radius_px: float) -> float:
    """Of `covered_shares` along one axis [px^2]."""
    columns = np.diff(_under_circle(np.minimum(_edges(radius_px), radius_px), radius_px))
    return float(4 * np.arange(len(columns)) ** 2 @ columns / (math.pi * radius_px**2))


def _edges(radius_px: float) -> NDArray[np.float64]:
    """Of the pixels that one quadrant of a disc touches, from its centre on [px]."""
    return np.concatenate([[0.0], np.arange(math.ceil(radius_px + 0.5)) + 0.5])


def _under_circle(x: NDArray[np.float64], radius_px: float) -> NDArray[np.float64]:
    """The area between the x axis and a circle about the origin, from 0 to x <= R [px^2]."""
    turned = np.arcsin(np.minimum(x / radius_px, 1.0))
    return np.asarray((x * np.sqrt(np.maximum(radius_px**2 - x**2, 0.0)) + radius_px**2 * turned) / 2)
