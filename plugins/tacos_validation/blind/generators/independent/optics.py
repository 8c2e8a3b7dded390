"""Light by other makers: lamps, lenses, apertures, hands."""

from __future__ import annotations

from typing import ClassVar

import cv2
import numpy as np
from scipy import fft, ndimage, signal

from tacos_validation.blind.generators.camera import IdealShot, Image
from tacos_validation.blind.generators.independent.amplitude import SingleAmplitudeEffect


class SideLamp(SingleAmplitudeEffect, name="illumination-gradient"):
    """A lamp beside the scene: the inverse square of the distance."""

    def light(self, light: Image, shot: IdealShot, pad: int) -> Image:
        """Scaled to 1 in the middle."""
        x, y = shot.camera.grid(pad)
        cx, cy = shot.camera.centre_px
        away = 4.0 / self.amplitude
        u, v = (x - cx) / shot.camera.width_px, (y - cy) / shot.camera.width_px
        return light * ((1 + away**2) / (1 + (away - u) ** 2 + v**2))[..., None]


class NaturalFallOff(SingleAmplitudeEffect, name="vignetting", place=4):
    """The fourth power of the cosine, and a barrel that cuts off oblique light."""

    def light(self, light: Image, shot: IdealShot, pad: int) -> Image:
        r = np.sqrt(shot.camera.squared_radius(pad))
        angle = np.arctan(r * np.sqrt(self.amplitude))
        rim = 1 - 0.5 * self.amplitude * np.clip((r - 0.7) / 0.6, 0, None) ** 2
        return light * (np.cos(angle) ** 4 * np.clip(rim, 0, 1))[..., None]


class FisheyeLens(SingleAmplitudeEffect, name="lens-distortion", place=1):
    """OpenCV's fisheye model, mixed with a pinhole."""

    def rays(self, x: Image, y: Image, channel: int, shot: IdealShot, row: Image) -> tuple[Image, Image]:
        """Undistort by OpenCV: equidistant at amplitude 1, a pinhole at 0."""
        f, (cx, cy) = shot.camera.focal_px, shot.camera.centre_px
        matrix = np.array([[f, 0, cx], [0, f, cy], [0, 0, 1]])
        places = np.stack([x.ravel(), y.ravel()], axis=1)[:, None]
        true = cv2.fisheye.undistortPoints(places, matrix, np.zeros(4))[:, 0] * f + (cx, cy)
        mixed = places[:, 0] + self.amplitude * (true - places[:, 0])
        return mixed[:, 0].reshape(x.shape), mixed[:, 1].reshape(x.shape)


class RealLens(SingleAmplitudeEffect, name="lens-distortion", place=1):
    """A lens of the lensfun database; amplitude picks one."""

    models: ClassVar[tuple[str, ...]] = (
        "Canon EF 16-35mm f/4L IS USM",
        "Canon EF 22-55mm f/4-5.6 USM",
        "Canon EF-S 17-85mm f/4-5.6 IS USM",
    )

    def rays(self, x: Image, y: Image, channel: int, shot: IdealShot, row: Image) -> tuple[Image, Image]:
        import lensfunpy  # type: ignore[import-untyped, import-not-found, unused-ignore]

        lenses = [
            lens
            for lens in lensfunpy.Database().lenses
            if lens.maker == "Canon" and lens.model in self.models
        ]
        lens = sorted(lenses, key=lambda each: str(each.model))[int(self.amplitude) % len(self.models)]
        size = shot.camera.width_px, shot.camera.height_px
        modifier = lensfunpy.Modifier(lens, lens.crop_factor, *size)
        modifier.initialize(
            lens.min_focal, 8.0, 10.0, 0.0, flags=lensfunpy.ModifyFlags.DISTORTION, reverse=True
        )
        found = modifier.apply_geometry_distortion().astype(np.float64)
        moved = [found[..., i] - shot.camera.grid()[i] for i in (0, 1)]
        at = [ndimage.map_coordinates(part, (y, x), order=1, mode="nearest") for part in moved]
        return x + at[0], y + at[1]


class Hexagon(SingleAmplitudeEffect, name="defocus", place=1):
    """The out-of-focus image of a six-bladed aperture."""

    def light(self, light: Image, shot: IdealShot, pad: int) -> Image:
        fine = 8
        size = 2 * int(np.ceil(self.amplitude + 1)) + 1
        middle = fine * size / 2
        corners = middle + self.amplitude * fine * np.stack(
            [np.cos(np.arange(6) * np.pi / 3), np.sin(np.arange(6) * np.pi / 3)], axis=1
        )
        mask = np.zeros((size * fine, size * fine), np.uint8)
        cv2.fillPoly(mask, [np.round(corners).astype(np.int32)], 1)
        kernel = mask.reshape(size, fine, size, fine).mean(axis=(1, 3))
        return signal.fftconvolve(light, (kernel / kernel.sum())[..., None], mode="same").clip(0)


class HandShake(SingleAmplitudeEffect, name="motion-blur", place=5):
    """A hand that trembles along a line, slower at the turning points."""

    angle_deg: ClassVar[float] = 25.0

    def light(self, light: Image, shot: IdealShot, pad: int) -> Image:
        """Mean over a half swing of a pendulum."""
        height, width = light.shape[:2]
        v, u = fft.fftfreq(height)[:, None], fft.rfftfreq(width)[None, :]
        along = u * np.cos(np.radians(self.angle_deg)) + v * np.sin(np.radians(self.angle_deg))
        places = 0.5 * self.amplitude * np.sin(np.linspace(-1.2, 1.2, 48))
        transfer = np.mean([np.exp(-2j * np.pi * along * place) for place in places], axis=0)
        spectrum = fft.rfft2(light, axes=(0, 1)) * transfer[..., None]
        return np.asarray(fft.irfft2(spectrum, s=(height, width), axes=(0, 1))).clip(0)


class WidePsf(SingleAmplitudeEffect, name="veiling-glare", place=3):
    """Stray light that falls off exponentially."""

    def light(self, light: Image, shot: IdealShot, pad: int) -> Image:
        height, width = light.shape[:2]
        y, x = np.mgrid[-height : height + 1, -width : width + 1]
        kernel = np.exp(-np.hypot(x, y) / (0.35 * width))
        total = signal.fftconvolve(light, kernel[..., None], mode="same")
        reach = signal.fftconvolve(np.ones(light.shape[:2]), kernel, mode="same")[..., None]
        return ((1 - self.amplitude) * light + self.amplitude * total / reach).clip(0)


class FluorescentTube(SingleAmplitudeEffect, name="flicker"):
    """A tube that follows the rectified mains."""

    def frame_light(self, light: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        rows = np.arange(light.shape[0])[:, None, None]
        wave = np.abs(np.sin(np.pi * rows / 90.0 + rng.uniform(0, np.pi)))
        return light * (1 + self.amplitude * (wave - 2 / np.pi) / (1 - 2 / np.pi))
