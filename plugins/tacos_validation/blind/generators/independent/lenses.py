"""Lenses and poses by other makers: a lens database, wave optics, OpenCV's geometry."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, ClassVar

import cv2
import numpy as np
from scipy import fft, ndimage

from tacos_validation.blind.generators.camera import IdealCamera, IdealShot, Image
from tacos_validation.blind.generators.independent.amplitude import SingleAmplitudeEffect


class RealFringes(SingleAmplitudeEffect, name="lateral-chromatic-aberration"):
    """Lateral colour as lensfun measured it on a zoom lens, times the amplitude."""

    lens: ClassVar[str] = "Canon EF 100-400mm f/4.5-5.6L IS USM"

    def rays(self, x: Image, y: Image, channel: int, shot: IdealShot, row: Image) -> tuple[Image, Image]:
        size = shot.camera.width_px, shot.camera.height_px
        moved = _fringes(self.lens, *size)[:, :, channel]
        at = [ndimage.map_coordinates(moved[..., i], (y, x), order=1, mode="nearest") for i in (0, 1)]
        return x + self.amplitude * at[0], y + self.amplitude * at[1]


@lru_cache(maxsize=4)
def _fringes(lens: str, width_px: int, height_px: int) -> Image:
    """(H, W, channel, x and y) displacement of a lens of the database [px]."""
    import lensfunpy  # type: ignore[import-untyped, import-not-found, unused-ignore]

    chosen = next(each for each in lensfunpy.Database().lenses if each.model == lens)
    modifier = lensfunpy.Modifier(chosen, chosen.crop_factor, width_px, height_px)
    modifier.initialize(chosen.min_focal, 8.0, 1000.0, 0.0, flags=lensfunpy.ModifyFlags.TCA, reverse=True)
    found = modifier.apply_subpixel_distortion().astype(np.float64)
    y, x = np.mgrid[:height_px, :width_px]
    return np.asarray(found - np.stack([x, y], axis=-1)[:, :, None])


class AberratedPupil(SingleAmplitudeEffect, name="lens-blur", place=2):
    """Diffraction by a round pupil with spherical aberration.

    The amplitude is wavelength times f-number over the pixel pitch: nothing of a finer period passes.

    Source: Goodman 2005, "Introduction to Fourier Optics", 6.4: the transfer function is the pupil's
    autocorrelation.
    """

    waves: ClassVar[float] = 0.2

    def light(self, light: Image, shot: IdealShot, pad: int) -> Image:
        height, width = light.shape[:2]
        frequency = np.hypot(fft.fftfreq(height)[:, None], fft.rfftfreq(width)[None, :])
        at, transfer = pupil_transfer(self.waves)
        passed = np.interp(frequency * self.amplitude, at, transfer, right=0.0)
        spectrum = fft.rfft2(light, axes=(0, 1)) * passed[..., None]
        return np.asarray(fft.irfft2(spectrum, s=(height, width), axes=(0, 1))).clip(0)


@lru_cache(maxsize=4)
def pupil_transfer(waves: float) -> tuple[Image, Image]:
    """Frequencies over the cut-off, and what a round pupil with spherical aberration passes of them."""
    samples, radius = 512, 128
    v, u = (np.indices((samples, samples)) - samples // 2) / radius
    square = u**2 + v**2
    zernike = 6 * square**2 - 6 * square + 1
    pupil = np.where(square <= 1, np.exp(2j * np.pi * waves * zernike), 0)
    correlated = np.abs(fft.fftshift(fft.ifft2(np.abs(fft.fft2(pupil)) ** 2)))
    profile = correlated[samples // 2, samples // 2 :]
    return np.arange(len(profile)) / (2 * radius), profile / profile[0]


class OpenCvPose(SingleAmplitudeEffect, name="pose-error", place=3):
    """Another pose, projected forwards by OpenCV and inverted by the homography of four points."""

    turn: ClassVar[tuple[float, float, float]] = (0.5, -0.7, 0.5)
    shift: ClassVar[tuple[float, float, float]] = (2.0, 1.5, -2.0)

    def rays(self, x: Image, y: Image, channel: int, shot: IdealShot, row: Image) -> tuple[Image, Image]:
        if not shot.has_pose:
            return x, y
        matrix = _matrix(shot.camera)
        w, h = shot.camera.width_px - 1.0, shot.camera.height_px - 1.0
        believed = np.array([[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]])
        rays = (believed - shot.camera.centre_px) / shot.camera.focal_px
        plane = np.column_stack([rays, np.ones(4)]) * shot.depth_m
        turned, _ = cv2.Rodrigues(np.radians(self.amplitude) * np.array(self.turn))
        eye = self.amplitude * np.array(self.shift) * 1e-3
        real, _ = cv2.projectPoints(plane, cv2.Rodrigues(turned.T)[0], -turned.T @ eye, matrix, None)
        homography, _ = cv2.findHomography(real[:, 0], believed)
        return _moved(x, y, lambda places: cv2.perspectiveTransform(places, homography))

    @property
    def parameters(self) -> dict[str, Any]:
        """Rotation vector [deg] and place of the camera [mm]."""
        turned = zip(("rx", "ry", "rz"), self.turn, strict=True)
        shifted = zip(("tx", "ty", "tz"), self.shift, strict=True)
        return {key: self.amplitude * part for key, part in (*turned, *shifted)}


class OpenCvFocalLength(SingleAmplitudeEffect, name="focal-length-error", place=2):
    """Another camera matrix, undone by OpenCV."""

    def rays(self, x: Image, y: Image, channel: int, shot: IdealShot, row: Image) -> tuple[Image, Image]:
        believed = _matrix(shot.camera)
        real = believed * np.array([[self._scale, 1, 1], [1, self._scale, 1], [1, 1, 1]])
        return _moved(x, y, lambda places: cv2.undistortPoints(places, real, None, P=believed))

    @property
    def _scale(self) -> float:
        return 1 + self.amplitude

    @property
    def parameters(self) -> dict[str, Any]:
        return {"scale": self._scale}


def _matrix(camera: IdealCamera) -> Image:
    cx, cy = camera.centre_px
    return np.array([[camera.focal_px, 0.0, cx], [0.0, camera.focal_px, cy], [0.0, 0.0, 1.0]])


def _moved(x: Image, y: Image, move: Any) -> tuple[Image, Image]:
    """Places moved by a function of OpenCV on (N, 1, 2) points."""
    places = np.stack([np.ravel(x), np.ravel(y)], axis=1)[:, None].astype(np.float64)
    found = np.asarray(move(places), np.float64)[:, 0]
    return found[:, 0].reshape(x.shape), found[:, 1].reshape(x.shape)
