"""Files of images and arrays, and what they say of themselves."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from tacos_files.arrays import read_npy, read_npz
from tacos_files.images import read_samples
from tests.fuzz.reader import Reader
from tests.gap.captures.dng import dng


def samples(dtype: type = np.uint8, channels: int = 3) -> np.ndarray:
    """A small image, (12, 20, channels)."""
    return np.random.default_rng(0).integers(0, 255, (12, 20, channels)).astype(dtype)


def encoded(suffix: str, dtype: type = np.uint8, channels: int = 3) -> Callable[[], bytes]:
    """Makes that image as a file."""
    return lambda: cv2.imencode(suffix, samples(dtype, channels))[1].tobytes()


def _packed(kind: str, **options: object) -> Callable[[], bytes]:
    def made() -> bytes:
        stream = io.BytesIO()
        Image.fromarray(samples()).save(stream, kind, **options)
        return stream.getvalue()

    return made


def _npy() -> bytes:
    stream = io.BytesIO()
    np.save(stream, samples())
    return stream.getvalue()


def _npz() -> bytes:
    stream = io.BytesIO()
    np.savez_compressed(stream, a=samples(), b=np.array(["x", "y"]))
    return stream.getvalue()


def _photograph() -> bytes:
    exif = Image.Exif()
    exif[0x010F], exif[0x0110], exif[0x0112] = "Maker", "Model", 1
    exif.get_ifd(0x8769).update({0x829A: 0.01, 0x8827: 100, 0x920A: 4.2, 0xA405: 28})
    return _packed("JPEG", exif=exif, quality=90)()


def _raw_photograph() -> bytes:
    return dng(np.random.default_rng(0).integers(0, 65535, (24, 32)).astype(np.uint16))


def _facts(path: Path) -> object:
    from tacos_gap.photographs.facts import read_facts

    return read_facts(path)


def _raw(path: Path) -> object:
    """The mosaic as captures take it, and the facts as the import of photographs does."""
    from tacos_files.camera_images import read_image

    return read_image(path, path.name), _facts(path)


def _panorama() -> bytes:
    light = np.random.default_rng(0).uniform(0.1, 1, (16, 32, 3)).astype(np.float32)
    light[4, 7] = 1e4  # a sun
    return cv2.imencode(".hdr", light)[1].tobytes()


def _surroundings(path: Path) -> object:
    """A sky as `scene.imported` takes it."""
    from tacos_framework.errors import Fault, UserError
    from tacos_worlds.imported.formats.file_bytes import Unreadable
    from tacos_worlds.imported.sky import read_surroundings

    try:
        return read_surroundings(path, 30.0)
    except Unreadable as error:  # the scene says so, beside what else is wrong with its settings
        raise UserError(Fault(path.name, str(error))) from error


IMAGES: Mapping[str, Reader] = {
    "png": Reader(".png", read_samples, encoded(".png"), whole_or_fault=True),
    "png16": Reader(".png", read_samples, encoded(".png", np.uint16, 1), whole_or_fault=True),
    "jpeg": Reader(".jpg", read_samples, encoded(".jpg"), whole_or_fault=True),
    "progressive": Reader(".jpg", read_samples, _packed("JPEG", progressive=True), whole_or_fault=True),
    "tiff": Reader(".tif", read_samples, encoded(".tif"), whole_or_fault=True),
    "webp": Reader(".webp", read_samples, _packed("WEBP"), whole_or_fault=True),
    "bmp": Reader(".bmp", read_samples, encoded(".bmp"), whole_or_fault=True),
    "ppm": Reader(".ppm", read_samples, encoded(".ppm"), whole_or_fault=True),
    "npy": Reader(".npy", read_npy, _npy, whole_or_fault=True),
    "npz": Reader(".npz", read_npz, _npz, whole_or_fault=True),
    "raw": Reader(".dng", _raw, _raw_photograph),  # cut short: tests/gap/captures/test_raw.py
    "exif": Reader(".jpg", _facts, _photograph),
    "panorama": Reader(".hdr", _surroundings, _panorama, whole_or_fault=True),
}
