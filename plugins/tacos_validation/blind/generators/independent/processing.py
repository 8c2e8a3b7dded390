"""Processing by other makers: curves, filters and codecs of other packages."""

from __future__ import annotations

import io
import warnings
from typing import Any

import cv2
import numpy as np
from PIL import Image as Pillow
from PIL import ImageFilter

from tacos_validation.blind.generators.camera import IdealShot, Image
from tacos_validation.blind.generators.independent.amplitude import SingleAmplitudeEffect


class SrgbMixed(SingleAmplitudeEffect, name="tone-curve", place=60):
    """Part of the way to the sRGB curve, with its straight foot."""

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        camera = shot.camera
        y = (codes - camera.black_dn) / camera.range_dn
        curve = np.where(y > 0.0031308, 1.055 * np.maximum(y, 1e-9) ** (1 / 2.4) - 0.055, 12.92 * y)
        return camera.black_dn + camera.range_dn * (y + self.amplitude * (curve - y))


class PillowUnsharp(SingleAmplitudeEffect, name="sharpening", place=70):
    """Pillow's unsharp mask, with a threshold."""

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        filtered = ImageFilter.UnsharpMask(
            radius=1.5, percent=max(1, round(100 * self.amplitude)), threshold=1
        )
        return np.stack(
            [np.asarray(Pillow.fromarray(plane).filter(filtered), np.float64) for plane in _planes(codes)],
            axis=-1,
        )


class NonLocalMeans(SingleAmplitudeEffect, name="denoise", place=40):
    """OpenCV's non-local means."""

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        return np.stack(
            [
                np.asarray(cv2.fastNlMeansDenoising(plane, None, self.amplitude, 3, 11), np.float64)
                for plane in _planes(codes)
            ],
            axis=-1,
        )


class TotalVariation(SingleAmplitudeEffect, name="denoise", place=40):
    """Scikit-image's total variation."""

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        from skimage.restoration import denoise_tv_chambolle  # type: ignore[import-untyped, import-not-found, unused-ignore]

        return np.asarray(denoise_tv_chambolle(codes, weight=self.amplitude, channel_axis=-1))


class Menon(SingleAmplitudeEffect, name="demosaic", place=30):
    """Menon's demosaicing, of colour-demosaicing."""

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        with warnings.catch_warnings():  # it imports names that SciPy has moved
            warnings.simplefilter("ignore", DeprecationWarning)
            from colour_demosaicing import (  # type: ignore[import-untyped, import-not-found, unused-ignore]
                demosaicing_CFA_Bayer_Menon2007,
                mosaicing_CFA_Bayer,
            )

        mosaic = mosaicing_CFA_Bayer(codes, "RGGB")
        return np.asarray(demosaicing_CFA_Bayer_Menon2007(mosaic, "RGGB"), np.float64)


class PhotographersJpeg(SingleAmplitudeEffect, name="jpeg", place=80):
    """JPEG with the tables of an image editor rather than those of libjpeg's scale."""

    def codes(self, codes: Image, shot: IdealShot, sensor: np.random.Generator) -> Image:
        presets = ("web_maximum", "web_very_high", "web_high", "web_medium", "web_low")
        file = io.BytesIO()
        image = np.repeat(codes, 3, axis=2) if codes.shape[2] == 1 else codes
        preset: Any = presets[min(int(self.amplitude), 4)]
        Pillow.fromarray(image.astype(np.uint8)).save(file, "jpeg", quality=preset)
        decoded = np.asarray(Pillow.open(file), np.float64)
        return decoded[..., :1] if codes.shape[2] == 1 else decoded


def _planes(codes: Image) -> list[np.ndarray]:
    return [np.ascontiguousarray(codes[..., c].astype(np.uint8)) for c in range(codes.shape[2])]
