"""Blur by a point spread function that is known through its transfer function.

A kernel is made from the optical transfer function rather than by sampling the spread: it then has the
transfer of the real thing up to the Nyquist frequency, however narrow the spread, and changes smoothly with
its parameters. A sampled Gaussian of 0.3 px would do neither.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import j1

Transfer = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]
"""Takes frequencies along x and y [cycles/px] to the contrast that is left [1]."""

_TAPER_PX = 6
_REACH_SIGMAS = 4.0


def gaussian_transfer(sigma_px: float) -> Transfer:
    """Of a Gaussian of standard deviation `sigma_px`: exp(-2 (pi sigma f)^2)."""
    return lambda fx, fy: np.exp(-2 * (math.pi * sigma_px) ** 2 * (fx**2 + fy**2))


def disc_transfer(radius_px: float) -> Transfer:
    """Of an even disc: 2 J1(z) / z with z = 2 pi R f."""

    def transfer(fx: NDArray[np.float64], fy: NDArray[np.float64]) -> NDArray[np.float64]:
        z = 2 * math.pi * radius_px * np.hypot(fx, fy)
        return np.where(z < 1e-6, 1.0, 2 * j1(z) / np.maximum(z, 1e-6))

    return transfer


def line_transfer(length_px: float, angle_deg: float) -> Transfer:
    """Of an even line: sin(pi L f) / (pi L f) along it; the angle turns from x to y, that is downwards."""
    along_x, along_y = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    return lambda fx, fy: np.sinc(length_px * (fx * along_x + fy * along_y))


def airy_transfer(cut_off: float) -> Transfer:
    """Of diffraction at a round aperture, with nothing left from `cut_off` [cycles/px] on.

    The cut-off is the pixel pitch over wavelength times f-number.
    """

    def transfer(fx: NDArray[np.float64], fy: NDArray[np.float64]) -> NDArray[np.float64]:
        share = np.minimum(np.hypot(fx, fy) / cut_off, 1.0)
        return 2 / math.pi * (np.arccos(share) - share * np.sqrt(1 - share**2))

    return transfer


def kernel_of(transfer: Transfer, reach_px: float) -> NDArray[np.float64]:
    """The kernel with a transfer function.

    `transfer`: the transfer function, real: the spread is symmetric about its centre. `reach_px`: how far the
    spread reaches; beyond, the ripples of the band limit are faded out [px].

    Returns: (K, K) float64 with K odd and sum 1.

    >>> kernel = kernel_of(gaussian_transfer(0.4), reach_px=2)
    >>> offset = np.arange(len(kernel)) - len(kernel) // 2
    >>> round(float(kernel.sum(axis=0) @ offset**2), 3)  # its variance, 0.4^2, whatever the pixels
    0.16
    """
    flat = math.ceil(reach_px)
    half = flat + _TAPER_PX
    count = 1 << (4 * half).bit_length()
    frequency = np.asarray(np.fft.fftfreq(count), dtype=np.float64)
    spread = np.fft.fftshift(np.fft.ifft2(transfer(frequency[None, :], frequency[:, None])).real)
    middle = count // 2
    kernel = spread[middle - half : middle + half + 1, middle - half : middle + half + 1]
    beyond = np.clip((np.abs(np.arange(-half, half + 1)) - flat) / (_TAPER_PX + 1), 0.0, 1.0)
    fade = 0.5 + 0.5 * np.cos(math.pi * beyond)
    kernel = kernel * fade * fade[:, None]
    return kernel / kernel.sum()


def gaussian_kernel(sigma_px: float) -> NDArray[np.float64]:
    """(K,) the kernel of a Gaussian along either axis, true to its variance and transfer however narrow.

    A Gaussian is a product of two, and so is the way `kernel_of` fades: their outer product is its kernel.
    """
    kernel = kernel_of(gaussian_transfer(sigma_px), reach_px=_REACH_SIGMAS * sigma_px)
    return np.asarray(kernel.sum(axis=0))


def blur(frames: NDArray[np.floating], kernel: NDArray[np.float64]) -> NDArray[np.floating]:
    """Frames convolved with a symmetric kernel; the image's edge is continued outwards.

    `frames`: (N, H, W, C) float32 or float64. `kernel`: (K, K), K odd; or (K,), along either axis in turn, of
    a spread that is a product of two.

    Returns: same shape and dtype; nowhere outside the range of its frame, as no blur makes light.
    """
    blurred = np.empty_like(frames)
    for frame, out in zip(frames, blurred, strict=True):
        least, most = frame.min(), frame.max()
        if least == most:  # an even frame stays as it is, to the bit
            out[...] = frame
            continue
        filtered = _filtered(np.ascontiguousarray(frame), kernel)
        np.clip(filtered.reshape(frame.shape), least, most, out=out)
    return blurred


def _filtered(frame: NDArray[np.floating], kernel: NDArray[np.float64]) -> NDArray[np.floating]:
    """(H, W, C) a frame convolved with a kernel of one axis or of both; float32 or float64."""
    if kernel.ndim == 1:
        filtered = cv2.sepFilter2D(frame, -1, kernel, kernel, borderType=cv2.BORDER_REPLICATE)
    else:
        filtered = cv2.filter2D(frame, -1, kernel, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(filtered)
