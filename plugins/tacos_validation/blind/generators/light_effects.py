"""Effects of the light before it is counted: lamps, lens, exposure."""

from __future__ import annotations

import numpy as np
from scipy import fft, ndimage, special

from tacos_validation.blind.generators.camera import IdealShot, Image
from tacos_validation.blind.generators.injected_effect import InjectedEffect


class InjectedIlluminationGradient(InjectedEffect, name="illumination-gradient"):
    """Light that rises over the image."""

    gx: float = 0.0
    gy: float = 0.0

    def light(self, light: Image, shot: IdealShot, pad: int) -> Image:
        x, y = shot.camera.grid(pad)
        cx, cy = shot.camera.centre_px
        plane = 1 + self.gx * (x - cx) / shot.camera.width_px + self.gy * (y - cy) / shot.camera.height_px
        return light * np.maximum(plane, 0.0)[..., None]


class InjectedDefocus(InjectedEffect, name="defocus", place=1):
    """Discs in place of points, by their transfer function 2 J1(x) / x."""

    radius_px: float = 0.0

    def light(self, light: Image, shot: IdealShot, pad: int) -> Image:
        height, width = light.shape[:2]
        v = fft.fftfreq(height)[:, None]
        u = fft.rfftfreq(width)[None, :]
        argument = 2 * np.pi * self.radius_px * np.hypot(u, v)
        transfer = np.where(argument > 1e-9, 2 * special.j1(argument) / np.maximum(argument, 1e-9), 1.0)
        spectrum = fft.rfft2(light, axes=(0, 1)) * transfer[..., None]
        return np.asarray(fft.irfft2(spectrum, s=(height, width), axes=(0, 1))).clip(0)


class InjectedLensBlur(InjectedEffect, name="lens-blur", place=2):
    """A Gaussian that grows with the squared radius: between images blurred more and more."""

    sigma_px: float = 0.0
    growth: float = 0.0

    def light(self, light: Image, shot: IdealShot, pad: int) -> Image:
        """Blend of a stack, along variance, in which Gaussians add."""
        wanted = (self.sigma_px * (1 + self.growth * shot.camera.squared_radius(pad))) ** 2
        levels = np.linspace(wanted.min(), wanted.max(), 9 if self.growth else 1)
        stack = np.stack([_gaussian(light, float(np.sqrt(s))) for s in levels])
        if len(levels) == 1:
            return stack[0]
        place = (wanted - levels[0]) / (levels[1] - levels[0])
        below = np.clip(place.astype(int), 0, len(levels) - 2)
        part = (place - below)[..., None]
        rows, columns = np.indices(below.shape)
        return np.asarray(stack[below, rows, columns] * (1 - part) + stack[below + 1, rows, columns] * part)


def _gaussian(light: Image, sigma_px: float) -> Image:
    """By its transfer function: a kernel sampled at whole pixels is narrower than half a pixel asks for."""
    height, width = light.shape[:2]
    spectrum = fft.rfft2(light, axes=(0, 1))
    filtered = ndimage.fourier_gaussian(spectrum, (sigma_px, sigma_px, 0), n=width, axis=1)
    return np.asarray(fft.irfft2(filtered, s=(height, width), axes=(0, 1))).clip(0)


class InjectedVeilingGlare(InjectedEffect, name="veiling-glare", place=3):
    """A share of the light strays evenly."""

    share: float = 0.0

    def light(self, light: Image, shot: IdealShot, pad: int) -> Image:
        inner = light[pad : light.shape[0] - pad, pad : light.shape[1] - pad]
        return light + self.share * (inner.mean(axis=(0, 1)) - light)


class InjectedVignetting(InjectedEffect, name="vignetting", place=4):
    """Light that falls off with the radius."""

    k1: float = 0.0
    k2: float = 0.0
    k3: float = 0.0

    def light(self, light: Image, shot: IdealShot, pad: int) -> Image:
        s = shot.camera.squared_radius(pad)
        fall = 1 + s * (self.k1 + s * (self.k2 + s * self.k3))
        return light * np.maximum(fall, 0)[..., None]


class InjectedMotionBlur(InjectedEffect, name="motion-blur", place=5):
    """The camera shakes along a line while the shutter is open: the mean of many moments."""

    length_px: float = 0.0
    angle_deg: float = 0.0

    def light(self, light: Image, shot: IdealShot, pad: int) -> Image:
        height, width = light.shape[:2]
        v = fft.fftfreq(height)[:, None]
        u = fft.rfftfreq(width)[None, :]
        angle = np.radians(self.angle_deg)
        along = u * np.cos(angle) + v * np.sin(angle)
        moments = 4 * int(np.ceil(self.length_px)) + 9
        transfer = np.zeros(along.shape)
        for moment in (np.arange(moments) + 0.5) / moments - 0.5:
            transfer += np.cos(2 * np.pi * along * moment * self.length_px) / moments
        spectrum = fft.rfft2(light, axes=(0, 1)) * transfer[..., None]
        return np.asarray(fft.irfft2(spectrum, s=(height, width), axes=(0, 1))).clip(0)


class InjectedExposureError(InjectedEffect, name="exposure-error", place=6):
    """More or less light than believed."""

    scale: float = 1.0

    def light(self, light: Image, shot: IdealShot, pad: int) -> Image:
        return light * self.scale


class InjectedFlicker(InjectedEffect, name="flicker"):
    """Lamps that pulse while rows are read."""

    depth: float = 0.0
    period_rows: float = 100.0

    def frame_light(self, light: Image, shot: IdealShot, rng: np.random.Generator) -> Image:
        """A wave over the rows at a phase of each frame's own."""
        phase = rng.uniform(0, 1)
        rows = np.arange(light.shape[0])[:, None, None]
        return light * (1 + self.depth * np.cos(2 * np.pi * (rows / self.period_rows - phase)))
