"""Processing in the camera that the simulator knows nothing of; codecs and filters of other packages."""

from __future__ import annotations

import io

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow
from scipy import ndimage

from tacos_validation.blind.generators.camera import IdealShot, Image
from tacos_validation.blind.generators.injected_effect import InjectedEffect


class InjectedShadingCorrection(InjectedEffect, name="lens-shading-correction", place=10):
    """Corners made brighter after the noise."""

    k1: float = 0.0
    k2: float = 0.0

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        s = shot.camera.squared_radius()[..., None]
        black = shot.camera.black_dn
        return black + (codes - black) * (1 + s * (self.k1 + s * self.k2))


class InjectedWhiteBalance(InjectedEffect, name="white-balance", place=20):
    """Red and blue multiplied."""

    red: float = 1.0
    blue: float = 1.0

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        black = shot.camera.black_dn
        return black + (codes - black) * np.array([self.red, 1.0, self.blue])


class InjectedDemosaicing(InjectedEffect, name="demosaic", place=30):
    """One colour per pixel, the others made up by OpenCV."""

    method: str = "bilinear"

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        raw = codes[..., 1].copy()
        raw[0::2, 0::2] = codes[0::2, 0::2, 0]
        raw[1::2, 1::2] = codes[1::2, 1::2, 2]
        way = {"bilinear": cv2.COLOR_BayerBG2RGB, "edge-aware": cv2.COLOR_BayerBG2RGB_EA}[self.method]
        return np.asarray(cv2.cvtColor(raw.astype(np.uint8), way), np.float64)


class InjectedDenoising(InjectedEffect, name="denoise", place=40):
    """Local means where there is no more than noise, which the camera knows from its own calibration."""

    strength: float = 0.0

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        """Lee's filter by moments, each channel alone."""
        smooth = np.empty_like(codes)
        for c in range(codes.shape[2]):
            x = codes[..., c]
            mean = ndimage.uniform_filter(x, 5)
            variance = np.maximum(ndimage.uniform_filter(x * x, 5) - mean**2, 0)
            camera = shot.camera
            signal = np.maximum(mean - camera.black_dn, 0)
            noise = self.strength * (camera.photon_dn * signal + camera.thermal_dn2)
            gain = np.where(variance > noise, 1 - noise / np.maximum(variance, 1e-12), 0.0)
            smooth[..., c] = mean + gain * (x - mean)
        return smooth


class InjectedColourMatrix(InjectedEffect, name="colour-matrix", place=50):
    """Colours mixed from one another, greys kept; the off-diagonal entries row by row."""

    matrix: tuple[tuple[float, ...], ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        black = shot.camera.black_dn
        return np.asarray(black + np.einsum("ij,hwj->hwi", np.array(self.matrix), codes - black))


class InjectedToneCurve(InjectedEffect, name="tone-curve", place=60):
    """Codes as for a display: a power of the signal."""

    gamma: float = 1.0

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        black, span = shot.camera.black_dn, shot.camera.range_dn
        signal = (np.arange(int(shot.camera.white_dn) + 1) - black) / span
        table: NDArray[np.float64] = black + span * np.sign(signal) * np.abs(signal) ** self.gamma
        return table[codes.astype(int)]


class InjectedSharpening(InjectedEffect, name="sharpening", place=70):
    """An unsharp mask."""

    amount: float = 0.0
    radius_px: float = 1.0

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        soft = ndimage.gaussian_filter(codes, (self.radius_px, self.radius_px, 0), truncate=5)
        return codes + self.amount * (codes - soft)


class InjectedJpeg(InjectedEffect, name="jpeg", place=80):
    """JPEG by Pillow."""

    quality: int = 100
    subsampling: str = "4:2:0"

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        pixels = codes.astype(np.uint8)
        file = io.BytesIO()
        grey = pixels.shape[2] == 1
        Pillow.fromarray(pixels[..., 0] if grey else pixels).save(
            file, "jpeg", quality=self.quality, **({} if grey else {"subsampling": self.subsampling})
        )
        decoded = np.asarray(Pillow.open(file), np.float64)
        return decoded[..., None] if grey else decoded
