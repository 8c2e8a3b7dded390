"""Surroundings from a panorama with high dynamic range (.hdr, .exr), and the sun in it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from tacos_framework import Light
from tacos_plugins.lighting import photopic
from tacos_worlds.imported.formats.file_bytes import Unreadable, file_bytes
from tacos_worlds.imported.lamps import sun
from tacos_worlds.kit.sky import cosine_mean

ROWS = 512
"""Rows of the panorama kept."""
_SUN_OVER_MEAN = 30.0
"""What is so many times brighter than the upper half on average is the sun's disc or its halo."""
_WIDEST_SUN_SR = 0.02
"""A larger bright patch is a cloud or a window, and stays in the panorama [sr]."""
_HDR_LIMITS = (16, 16384)


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Light from beyond the geometry, in the unit of the file."""

    panorama: NDArray[np.float32]
    """(H, 2 H, 3) float32 as `World.sky_cd_m2`, without the sun [the file's unit]."""
    mean: NDArray[np.float64]
    """(3,) mean of its upper half, weighted by the cosine from the zenith [the same]."""
    sun: Light | None


def even(luminance_cd_m2: float) -> Surroundings:
    """An overcast sky without features."""
    panorama = np.full((16, 32, 3), luminance_cd_m2, np.float32)
    return Surroundings(panorama, np.full(3, luminance_cd_m2), None)


def read_surroundings(file: Path, turn_deg: float) -> Surroundings:
    """Surroundings of an equirectangular panorama.

    Its first row is the zenith, its middle column looks along +x, and azimuth grows to the left, as seen from
    inside, which is how such files are made.

    `turn_deg`: turns the panorama about the vertical, to the left [deg]. Raises Unreadable where it cannot be
    decoded, or is not twice as wide as high.
    """
    image = _decoded(file)
    height, width = image.shape[:2]
    if width != 2 * height or height < _HDR_LIMITS[0]:
        raise Unreadable(
            f"{file.name} has {width} x {height} pixels, but a panorama is twice as wide as high"
        )
    image = np.maximum(np.nan_to_num(image, nan=0.0, posinf=float(np.finfo(np.float16).max)), 0)
    image, star = without_sun(image)
    panorama = cv2.resize(image, (2 * ROWS, ROWS), interpolation=cv2.INTER_AREA)
    # Columns of a world run from +x by way of +y, those of a file from -x by way of +y to its middle.
    panorama = np.roll(panorama[:, ::-1], ROWS + round(turn_deg / 180 * ROWS), axis=1)
    if star is not None:
        star = _turned(star, turn_deg)
    return Surroundings(panorama.astype(np.float32), cosine_mean(np.asarray(panorama, np.float32)), star)


def without_sun(image: NDArray[np.float32]) -> tuple[NDArray[np.float32], Light | None]:
    """A panorama without its sun, and the sun as a light of as much illuminance.

    The sun is the brightest patch, where it is many times brighter than the rest and small. Baked as part of
    a panorama it would cast no shadows.
    """
    height, width = image.shape[:2]
    luminance = photopic(image)
    zenith = (np.arange(height) + 0.5) / height * math.pi
    solid = np.broadcast_to(
        (np.sin(zenith) * (math.pi / height) * (2 * math.pi / width))[:, None], (height, width)
    )
    upper = luminance[: height // 2]
    typical = float(np.average(np.minimum(upper, np.quantile(upper, 0.99)), weights=solid[: height // 2]))
    disc, around = _brightest_patch(luminance, _SUN_OVER_MEAN * max(typical, 1e-9))
    if not disc.any() or solid[disc].sum() > _WIDEST_SUN_SR:
        return image, None
    fill = np.median(image[around], axis=0)
    lux = ((image - fill)[disc] * solid[disc][:, None]).sum(axis=0)  # on a surface that faces it
    weight = (luminance * solid)[disc]
    rows, columns = np.nonzero(disc)
    angle = math.pi - (columns + 0.5) / width * 2 * math.pi
    tilt = (rows + 0.5) / height * math.pi
    towards = np.stack([np.sin(tilt) * np.cos(angle), np.sin(tilt) * np.sin(angle), np.cos(tilt)])
    direction = (towards * weight).sum(axis=1)
    cleaned = image.copy()
    cleaned[disc] = fill
    return cleaned, sun(direction / np.linalg.norm(direction), np.maximum(lux, 0).astype(np.float64))


def _brightest_patch(
    luminance: NDArray[np.floating], above: float
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """The pixels above a limit that hang together with the brightest, and those around them.

    The first column is a neighbour of the last.
    """
    height, width = luminance.shape
    row, column = np.unravel_index(int(np.argmax(luminance)), luminance.shape)
    turn = width // 2 - int(column)  # away from the seam
    bright, _ = ndimage.label(np.roll(luminance, turn, axis=1) > above)
    patch = (bright == bright[row, width // 2]) & (bright > 0)
    around = ndimage.binary_dilation(patch, iterations=max(3, height // 256)) & ~patch
    return np.roll(patch, -turn, axis=1), np.roll(around, -turn, axis=1)


def _turned(light: Light, turn_deg: float) -> Light:
    cos, sin = math.cos(math.radians(turn_deg)), math.sin(math.radians(turn_deg))
    x, y, z = light.position_m.tolist()
    position = np.array([cos * x - sin * y, sin * x + cos * y, z], np.float32)
    return Light(position, light.flux_lm, radius_m=light.radius_m)


def _decoded(file: Path) -> NDArray[np.float32]:
    data = file_bytes(file)
    if file.suffix.lower() == ".exr":
        return _decoded_exr(file)
    head = data[:4096].split(b"\n\n", 1)[-1][:64].split()
    if data[:2] != b"#?" or len(head) < 4 or not (head[1].isdigit() and head[3].isdigit()):
        raise Unreadable(f"{file.name} is no Radiance picture (.hdr) or EXR")
    if max(int(head[1]), int(head[3])) > _HDR_LIMITS[1]:
        raise Unreadable(f"{file.name} has more than {_HDR_LIMITS[1]} pixels along an edge")
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if image is None or image.ndim != 3:
        raise Unreadable(f"{file.name} cannot be decoded: it may be cut short")
    return np.asarray(image[..., 2::-1], np.float32)


def _decoded_exr(file: Path) -> NDArray[np.float32]:
    try:
        import OpenEXR
    except ModuleNotFoundError as error:
        raise Unreadable(
            f"{file.name} takes the package OpenEXR: pip install 'tacos-framework[export]', or give a "
            f".hdr file"
        ) from error
    try:
        with OpenEXR.File(str(file)) as opened:
            pixels = {name: channel.pixels for name, channel in opened.channels().items()}
    except (RuntimeError, ValueError, TypeError) as error:
        raise Unreadable(f"{file.name} cannot be decoded: {error}") from error
    for name in ("RGB", "RGBA"):
        if name in pixels:
            return np.asarray(pixels[name][..., :3], np.float32)
    if missing := {"R", "G", "B"} - set(pixels):
        raise Unreadable(f"{file.name} has no channel {', '.join(sorted(missing))}")
    return np.stack([pixels[name] for name in "RGB"], axis=-1).astype(np.float32)
