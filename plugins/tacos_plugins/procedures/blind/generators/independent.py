"""Other makers of the same effects: packages of others, and shapes the catalogue's formulas do not have.

What needs a package of the extra ``blind`` names it; `available` leaves it out where it is absent.
"""

from __future__ import annotations

import importlib.util
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import cv2
import numpy as np
from PIL import Image as Pillow
from PIL import ImageFilter
from scipy import fft, ndimage, signal

from tacos_plugins.procedures.blind.generators.camera import Image, Shot
from tacos_plugins.procedures.blind.generators.catalogue import Withheld
from tacos_plugins.procedures.blind.generators.flaw import Flaw


@dataclass(frozen=True)
class _Amplitude(Flaw):
    """A flaw of one amplitude, whose shape the catalogue's parameters do not describe."""

    amplitude: float = 0.0

    @property
    def parameters(self) -> dict[str, Any]:
        """None that could be compared."""
        return {}


class NaturalFallOff(_Amplitude):
    """The fourth power of the cosine, and a barrel that cuts off oblique light."""

    name: ClassVar[str] = "vignetting"
    order: ClassVar[int] = 4

    def light(self, light: Image, shot: Shot, pad: int) -> Image:
        """Angle of the ray, then a soft rim."""
        r = np.sqrt(shot.camera.squared_radius(pad))
        angle = np.arctan(r * np.sqrt(self.amplitude))
        rim = 1 - 0.5 * self.amplitude * np.clip((r - 0.7) / 0.6, 0, None) ** 2
        return light * (np.cos(angle) ** 4 * np.clip(rim, 0, 1))[..., None]


class FisheyeLens(_Amplitude):
    """OpenCV's fisheye model, mixed with a pinhole."""

    name: ClassVar[str] = "lens-distortion"
    order: ClassVar[int] = 1

    def rays(self, x: Image, y: Image, channel: int, shot: Shot, row: Image) -> tuple[Image, Image]:
        """Undistort by OpenCV: equidistant at amplitude 1, a pinhole at 0."""
        f, (cx, cy) = shot.camera.focal_px, shot.camera.centre_px
        matrix = np.array([[f, 0, cx], [0, f, cy], [0, 0, 1]])
        places = np.stack([x.ravel(), y.ravel()], axis=1)[:, None]
        true = cv2.fisheye.undistortPoints(places, matrix, np.zeros(4))[:, 0] * f + (cx, cy)
        mixed = places[:, 0] + self.amplitude * (true - places[:, 0])
        return mixed[:, 0].reshape(x.shape), mixed[:, 1].reshape(x.shape)


class RealLens(_Amplitude):
    """A lens of the lensfun database; amplitude picks one."""

    name: ClassVar[str] = "lens-distortion"
    order: ClassVar[int] = 1
    models: ClassVar[tuple[str, ...]] = (
        "Canon EF 16-35mm f/4L IS USM",
        "Canon EF 22-55mm f/4-5.6 USM",
        "Canon EF-S 17-85mm f/4-5.6 IS USM",
    )

    def rays(self, x: Image, y: Image, channel: int, shot: Shot, row: Image) -> tuple[Image, Image]:
        """Where the database says that pixels of a corrected image lie, backwards."""
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


class Hexagon(_Amplitude):
    """The out-of-focus image of a six-bladed aperture."""

    name: ClassVar[str] = "defocus"
    order: ClassVar[int] = 1

    def light(self, light: Image, shot: Shot, pad: int) -> Image:
        """Convolve with the polygon, drawn eight times as fine."""
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


class HandShake(_Amplitude):
    """A hand that trembles along a line, slower at the turning points."""

    name: ClassVar[str] = "motion-blur"
    order: ClassVar[int] = 5
    angle_deg: ClassVar[float] = 25.0

    def light(self, light: Image, shot: Shot, pad: int) -> Image:
        """Mean over a half swing of a pendulum."""
        height, width = light.shape[:2]
        v, u = fft.fftfreq(height)[:, None], fft.rfftfreq(width)[None, :]
        along = u * np.cos(np.radians(self.angle_deg)) + v * np.sin(np.radians(self.angle_deg))
        places = 0.5 * self.amplitude * np.sin(np.linspace(-1.2, 1.2, 48))
        transfer = np.mean([np.exp(-2j * np.pi * along * place) for place in places], axis=0)
        spectrum = fft.rfft2(light, axes=(0, 1)) * transfer[..., None]
        return np.asarray(fft.irfft2(spectrum, s=(height, width), axes=(0, 1))).clip(0)


class WidePsf(_Amplitude):
    """Stray light that falls off exponentially."""

    name: ClassVar[str] = "veiling-glare"
    order: ClassVar[int] = 3

    def light(self, light: Image, shot: Shot, pad: int) -> Image:
        """Convolve with a cone as wide as the image."""
        height, width = light.shape[:2]
        y, x = np.mgrid[-height : height + 1, -width : width + 1]
        kernel = np.exp(-np.hypot(x, y) / (0.35 * width))
        total = signal.fftconvolve(light, kernel[..., None], mode="same")
        reach = signal.fftconvolve(np.ones(light.shape[:2]), kernel, mode="same")[..., None]
        return ((1 - self.amplitude) * light + self.amplitude * total / reach).clip(0)


class FluorescentTube(_Amplitude):
    """A tube that follows the rectified mains."""

    name: ClassVar[str] = "flicker"

    def frame_light(self, light: Image, shot: Shot, rng: np.random.Generator) -> Image:
        """|sin|, about its mean."""
        rows = np.arange(light.shape[0])[:, None, None]
        wave = np.abs(np.sin(np.pi * rows / 90.0 + rng.uniform(0, np.pi)))
        return light * (1 + self.amplitude * (wave - 2 / np.pi) / (1 - 2 / np.pi))


class SoftFullWell(_Amplitude):
    """A response that bends like an exponential."""

    name: ClassVar[str] = "nonlinearity"
    order: ClassVar[int] = 2

    def samples(self, samples: Image, shot: Shot, rng: np.random.Generator) -> Image:
        """(1 - exp(-a y)) / a."""
        camera = shot.camera
        y = (samples - camera.black_dn) / camera.range_dn
        return camera.black_dn + camera.range_dn * -np.expm1(-self.amplitude * y) / self.amplitude


class TelegraphNoise(_Amplitude):
    """Read noise of a logistic shape, with pixels that jump between levels."""

    name: ClassVar[str] = "read-noise"
    order: ClassVar[int] = 3

    def samples(self, samples: Image, shot: Shot, rng: np.random.Generator) -> Image:
        """Add both."""
        jumps = 4 * self.amplitude * rng.integers(-1, 2, samples.shape) * (rng.random(samples.shape) < 0.005)
        scale = self.amplitude * np.sqrt(3) / np.pi
        return samples + rng.logistic(0.0, scale, size=samples.shape) + jumps


class DriftingRows(_Amplitude):
    """Row offsets that wander."""

    name: ClassVar[str] = "row-noise"
    order: ClassVar[int] = 4

    def samples(self, samples: Image, shot: Shot, rng: np.random.Generator) -> Image:
        """A first-order process."""
        drawn = np.asarray(rng.normal(size=samples.shape[0]))
        offsets = signal.lfilter(np.array([np.sqrt(1 - 0.4**2)]), np.array([1.0, -0.4]), drawn)
        return samples + self.amplitude * offsets[:, None, None]


class LognormalPixels(_Amplitude):
    """Responses that spread lognormally."""

    name: ClassVar[str] = "prnu"
    order: ClassVar[int] = 0

    def charge(self, mean: Image, shot: Shot, sensor: np.random.Generator) -> Image:
        """Multiply by the pattern."""
        return mean * sensor.lognormal(-(self.amplitude**2) / 2, self.amplitude, size=mean.shape)


class SrgbMixed(_Amplitude):
    """Part of the way to the sRGB curve, with its straight foot."""

    name: ClassVar[str] = "tone-curve"
    order: ClassVar[int] = 60

    def codes(self, codes: Image, shot: Shot, sensor: np.random.Generator) -> Image:
        """Bend what is above the pedestal."""
        camera = shot.camera
        y = (codes - camera.black_dn) / camera.range_dn
        curve = np.where(y > 0.0031308, 1.055 * np.maximum(y, 1e-9) ** (1 / 2.4) - 0.055, 12.92 * y)
        return camera.black_dn + camera.range_dn * (y + self.amplitude * (curve - y))


class PillowUnsharp(_Amplitude):
    """Pillow's unsharp mask, with a threshold."""

    name: ClassVar[str] = "sharpening"
    order: ClassVar[int] = 70

    def codes(self, codes: Image, shot: Shot, sensor: np.random.Generator) -> Image:
        """As in image editors."""
        filtered = ImageFilter.UnsharpMask(
            radius=1.5, percent=max(1, round(100 * self.amplitude)), threshold=1
        )
        return np.stack(
            [np.asarray(Pillow.fromarray(plane).filter(filtered), np.float64) for plane in _planes(codes)],
            axis=-1,
        )


class NonLocalMeans(_Amplitude):
    """OpenCV's non-local means."""

    name: ClassVar[str] = "denoise"
    order: ClassVar[int] = 40

    def codes(self, codes: Image, shot: Shot, sensor: np.random.Generator) -> Image:
        """Each channel alone."""
        return np.stack(
            [
                np.asarray(cv2.fastNlMeansDenoising(plane, None, self.amplitude, 3, 11), np.float64)
                for plane in _planes(codes)
            ],
            axis=-1,
        )


class TotalVariation(_Amplitude):
    """Scikit-image's total variation."""

    name: ClassVar[str] = "denoise"
    order: ClassVar[int] = 40

    def codes(self, codes: Image, shot: Shot, sensor: np.random.Generator) -> Image:
        """Chambolle's total variation."""
        from skimage.restoration import denoise_tv_chambolle  # type: ignore[import-untyped, import-not-found, unused-ignore]

        return np.asarray(denoise_tv_chambolle(codes, weight=self.amplitude, channel_axis=-1))


class Menon(_Amplitude):
    """Menon's demosaicing, of colour-demosaicing."""

    name: ClassVar[str] = "demosaic"
    order: ClassVar[int] = 30

    def codes(self, codes: Image, shot: Shot, sensor: np.random.Generator) -> Image:
        """Sample red, green, green, blue, and fill in."""
        with warnings.catch_warnings():  # it imports names that SciPy has moved
            warnings.simplefilter("ignore", DeprecationWarning)
            from colour_demosaicing import (  # type: ignore[import-untyped, import-not-found, unused-ignore]
                demosaicing_CFA_Bayer_Menon2007,
                mosaicing_CFA_Bayer,
            )

        mosaic = mosaicing_CFA_Bayer(codes, "RGGB")
        return np.asarray(demosaicing_CFA_Bayer_Menon2007(mosaic, "RGGB"), np.float64)


class PhotographersJpeg(_Amplitude):
    """JPEG with the tables of an image editor rather than those of libjpeg's scale."""

    name: ClassVar[str] = "jpeg"
    order: ClassVar[int] = 80

    def codes(self, codes: Image, shot: Shot, sensor: np.random.Generator) -> Image:
        """There and back."""
        import io

        presets = ("web_maximum", "web_very_high", "web_high", "web_medium", "web_low")
        file = io.BytesIO()
        image = np.repeat(codes, 3, axis=2) if codes.shape[2] == 1 else codes
        preset: Any = presets[min(int(self.amplitude), 4)]
        Pillow.fromarray(image.astype(np.uint8)).save(file, "jpeg", quality=preset)
        decoded = np.asarray(Pillow.open(file), np.float64)
        return decoded[..., :1] if codes.shape[2] == 1 else decoded


class SideLamp(_Amplitude):
    """A lamp beside the scene: the inverse square of the distance."""

    name: ClassVar[str] = "illumination-gradient"
    order: ClassVar[int] = 0

    def light(self, light: Image, shot: Shot, pad: int) -> Image:
        """Scaled to 1 in the middle."""
        x, y = shot.camera.grid(pad)
        cx, cy = shot.camera.centre_px
        away = 4.0 / self.amplitude
        u, v = (x - cx) / shot.camera.width_px, (y - cy) / shot.camera.width_px
        return light * ((1 + away**2) / (1 + (away - u) ** 2 + v**2))[..., None]


def _planes(codes: Image) -> list[np.ndarray]:
    return [np.ascontiguousarray(codes[..., c].astype(np.uint8)) for c in range(codes.shape[2])]


@dataclass(frozen=True)
class Variant:
    """Another maker of an effect.

    Parameters
    ----------
    effect
        The effect of the catalogue that it is.
    entry
        How it is made.
    package
        What must be installed.
    """

    effect: str
    entry: Withheld
    package: str = ""


def _of(
    cls: type[_Amplitude],
    low: float,
    high: float,
    largest: float,
    package: str = "",
    colour: bool = False,
) -> Variant:
    return Variant(cls.name, Withheld(lambda a, r: cls(a), (low, high), largest, colour), package)


VARIANTS: Mapping[str, Variant] = {
    "natural fall-off": _of(NaturalFallOff, 0.05, 0.6, 1.0),
    "OpenCV fisheye": _of(FisheyeLens, 0.05, 0.6, 1.0),
    "lensfun lens": _of(RealLens, 0.0, 2.0, 2.0, "lensfunpy"),
    "hexagonal aperture": _of(Hexagon, 0.7, 3.0, 6.0),
    "hand shake": _of(HandShake, 1.5, 8.0, 16.0),
    "wide stray light": _of(WidePsf, 0.01, 0.1, 0.3),
    "fluorescent tube": _of(FluorescentTube, 0.02, 0.3, 0.6),
    "soft full well": _of(SoftFullWell, 0.05, 0.4, 1.0),
    "telegraph noise": _of(TelegraphNoise, 0.5, 3.0, 8.0),
    "drifting rows": _of(DriftingRows, 0.1, 1.0, 5.0),
    "lognormal pixels": _of(LognormalPixels, 0.003, 0.02, 0.1),
    "sRGB curve": _of(SrgbMixed, 0.03, 0.5, 1.0),
    "Pillow unsharp mask": _of(PillowUnsharp, 0.1, 1.0, 2.5),
    "non-local means": _of(NonLocalMeans, 1.0, 6.0, 12.0),
    "total variation": _of(TotalVariation, 0.3, 2.0, 6.0, "skimage"),
    "Menon demosaicing": _of(Menon, 1.0, 1.0, 1.0, "colour_demosaicing", colour=True),
    "editor's JPEG": _of(PhotographersJpeg, 0.1, 4.0, 4.9),
    "side lamp": _of(SideLamp, 0.05, 0.5, 1.5),
}
"""Other makers, by name."""


def available() -> list[str]:
    """Those whose packages are installed."""
    return [
        name
        for name, v in VARIANTS.items()
        if not v.package or importlib.util.find_spec(v.package) is not None
    ]
