"""Facts of the file of a photograph."""

from __future__ import annotations

import math
import struct
import warnings
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from tacos_files.camera_images import LOSSY_SUFFIXES, RAW_SUFFIXES, black_of_raw, opened_raw
from tacos_files.image_headers import UNREADABLE
from tacos_framework import Fault, UserError
from tacos_framework.files import read_bytes
from tacos_gap.photographs.names import kind_in_name, settings_in_name

OF_NAME = "its name"

_FULL_FRAME_DIAGONAL_MM = math.hypot(36, 24)
_MM_PER_UNIT = {2: 25.4, 3: 10.0, 4: 1.0, 5: 1e-3}
"""Millimetres of EXIF's FocalPlaneResolutionUnit: inch, cm, mm, um."""

_MAKE, _MODEL, _SOFTWARE, _ORIENTATION, _EXIF = 0x010F, 0x0110, 0x0131, 0x0112, 0x8769
_EXPOSURE, _F_NUMBER, _TAKEN, _SUBSECOND = 0x829A, 0x829D, 0x9003, 0x9291
_ISOS = (0x8827, 0x8832, 0x8831, 0x8833)
"""ISO, of 16 bits, and where it holds no more: recommended exposure index, standard output, ISO speed."""

_ISO_ELSEWHERE = 0xFFFF
_SHUTTER, _COLUMNS, _ROWS = 0x9201, 0x0100, 0x0101
_TIFF = (b"II*\0", b"MM\0*")
_FOCAL, _FOCAL_35, _PLANE_X, _PLANE_UNIT, _WIDTH = 0x920A, 0xA405, 0xA20E, 0xA210, 0xA002

_POSSIBLE = {
    "exposure_ms": (1e-6, 1e9),
    "f_number": (0.1, 1e4),
    "focal_length_mm": (1e-3, 1e5),
    "pixel_um": (1e-3, 1e4),
}
"""The least and the most that captures may have; EXIF's infinity and other numbers are no settings."""


@dataclass(frozen=True)
class Facts:
    """Facts of a file; None where it does not say."""

    camera: str = ""
    exposure_ms: float | None = None
    """As the camera wrote it, like the three below."""
    f_number: float | None = None
    focal_length_mm: float | None = None
    iso: float | None = None
    pixel_um: float | None = None  # pitch of the file's pixels on the sensor [um]
    orientation: int = 1  # EXIF's: 1 for files that stand as the sensor does
    taken: str = ""
    software: str = ""  # what wrote the file
    lossy: bool = False  # compressed with loss
    raw: bool = False  # holds the sensor's own samples
    black_level_dn: float | None = None
    white_level_dn: float | None = None
    cfa: str | None = None
    gain_db: float | None = None  # gain, as the name of the file says it [dB]
    time_from: str = ""  # what says the exposure time, if not the camera: the name of the file, or a table
    kind: str | None = None  # dark or flat, as the name of the file or a table says


def read_facts(path: Path) -> Facts:
    """Facts of a file: EXIF, the header of a RAW file, at last its name.

    Raises UserError when it cannot be read.
    """
    said, size_px = _of_raw(path) if path.suffix.lower() in RAW_SUFFIXES else ({}, None)
    if path.suffix.lower() != ".npy":
        said = {**_of_exif(path, size_px), **said}
    for key, (least, most) in _POSSIBLE.items():
        if not least <= (said.get(key) or 0.0) <= most:
            said.pop(key, None)
    by_name = settings_in_name(path)
    if said.get("exposure_ms") is None and "exposure_ms" in by_name:
        said["time_from"] = OF_NAME
    said = by_name | {key: value for key, value in said.items() if value is not None}
    said["kind"] = kind_in_name(path)
    return Facts(**said, lossy=path.suffix.lower() in LOSSY_SUFFIXES)


def _of_exif(path: Path, raw_size_px: tuple[int, int] | None) -> dict[str, Any]:
    """Facts by EXIF; nothing of a file that has none, or of which it cannot be read.

    Of a RAW file the first image may be a preview, whose size says nothing of the pixels of the sensor.
    """
    tags, size_px = _tags_of(read_bytes(path, "image_mb"))
    width, height = raw_size_px or size_px
    exposure_s = _number(tags.get(_EXPOSURE)) or _apex_s(tags.get(_SHUTTER))
    return {
        "camera": " ".join(
            dict.fromkeys(_text(tags.get(tag)) for tag in (_MAKE, _MODEL) if _text(tags.get(tag)))
        ),
        "exposure_ms": exposure_s and exposure_s * 1e3,
        "f_number": _number(tags.get(_F_NUMBER)),
        "focal_length_mm": _number(tags.get(_FOCAL)),
        "iso": next(
            (iso for tag in _ISOS if (iso := _number(tags.get(tag))) not in (None, _ISO_ELSEWHERE)), None
        ),
        "pixel_um": _pitch_um(tags, width, height, scaled=raw_size_px is None),
        "orientation": int(_number(tags.get(_ORIENTATION)) or 1),
        "taken": _text(tags.get(_TAKEN)) + "." + _text(tags.get(_SUBSECOND)) if tags.get(_TAKEN) else "",
        "software": _text(tags.get(_SOFTWARE)),
    }


def _tags_of(content: bytes) -> tuple[dict[Any, Any], tuple[int, int]]:
    """EXIF's tags of a picture, and its width and height; none of them where there are none."""
    from PIL import Image

    with warnings.catch_warnings():  # of a size that is checked where samples are decoded, of odd entries
        warnings.simplefilter("ignore")
        try:
            with Image.open(BytesIO(content)) as image:
                exif = image.getexif()
                return {**exif, **exif.get_ifd(_EXIF)}, image.size
        except (*UNREADABLE, Image.DecompressionBombError):
            if not content.startswith(_TIFF):
                return {}, (0, 0)
        try:  # Pillow knows how to read its tags all the same, if not its samples
            exif = Image.Exif()
            exif.load(content)
            size = (int(_number(exif.get(tag)) or 0) for tag in (_COLUMNS, _ROWS))
            return {**exif, **exif.get_ifd(_EXIF)}, (next(size), next(size))
        except (*UNREADABLE, struct.error):
            return {}, (0, 0)


def _pitch_um(tags: dict[Any, Any], width: int, height: int, *, scaled: bool) -> float | None:
    """Pitch of the file's pixels by the resolution in the focal plane, or by the equivalent focal length.

    Files made smaller (`scaled`) have larger pixels, in proportion to the width that the camera noted.
    """
    if not width or not height:
        return None
    whole = (_number(tags.get(_WIDTH)) if scaled else None) or width
    if per_unit := _number(tags.get(_PLANE_X)):
        unit_mm = _MM_PER_UNIT.get(int(_number(tags.get(_PLANE_UNIT)) or 2), 25.4)
        return round(unit_mm / per_unit * 1e3 * whole / width, 3)
    focal, focal_35 = _number(tags.get(_FOCAL)), _number(tags.get(_FOCAL_35))
    if focal and focal_35:
        return round(_FULL_FRAME_DIAGONAL_MM * focal / focal_35 / math.hypot(width, height) * 1e3, 3)
    return None


def _number(value: Any) -> float | None:
    """A finite number above 0; None for what is none."""
    if isinstance(value, tuple):
        value = value[0] if value else None
    if isinstance(value, str):  # against the standard: "1/60"
        value, _, divisor = value.strip("\0 ").partition("/")
        return _ratio(value, divisor or 1)
    return _ratio(value, 1)


def _ratio(value: Any, divisor: Any) -> float | None:
    try:
        number = float(value) / float(divisor)
    except (TypeError, ValueError, ZeroDivisionError):
        return None
    return number if math.isfinite(number) and number > 0 else None


def _apex_s(value: Any) -> float | None:
    """Exposure time by EXIF's ShutterSpeedValue, a binary logarithm of its inverse [s]."""
    try:
        return 2.0 ** -float(value)
    except (TypeError, ValueError, ZeroDivisionError, OverflowError):
        return None


def _text(value: Any) -> str:
    return str(value).strip().strip("\0") if isinstance(value, str) else ""


def _of_raw(path: Path) -> tuple[dict[str, Any], tuple[int, int]]:
    with opened_raw(path, str(path)) as raw:
        other = getattr(raw, "other", None)  # since rawpy 0.22; EXIF says the same of most cameras
        said = {
            "raw": True,
            "black_level_dn": float(black_of_raw(raw.black_level_per_channel)),
            "white_level_dn": float(raw.white_level),
            "cfa": _bayer_pattern(raw, path),
        }
        for key, name, scale in (
            ("exposure_ms", "shutter_speed", 1e3),
            ("iso", "iso_speed", 1.0),
            ("f_number", "aperture", 1.0),
            ("focal_length_mm", "focal_length", 1.0),
        ):
            if value := _number(getattr(other, name, None)):
                said[key] = value * scale
        return said, (raw.sizes.width, raw.sizes.height)


def _bayer_pattern(raw: Any, path: Path) -> str | None:
    """The filters of a RAW file's mosaic from its corner on; None where there are none.

    Raises UserError when they are those of another mosaic, which would be taken for a pattern of the pixels.
    """
    try:
        pattern = raw.raw_pattern
    except NotImplementedError:  # filters that rawpy has no name for
        pattern = np.empty((0, 0), np.uint8)
    if pattern is None:
        return None
    letters = raw.color_desc.decode("ascii", "replace")
    filters = "".join(letters[k] for k in pattern.ravel().tolist())
    if filters in ("RGGB", "BGGR", "GRBG", "GBRG"):
        return filters
    raise UserError(
        Fault(
            str(path),
            f"{path.name} has colour filters that are no Bayer mosaic",
            "RGGB, BGGR, GRBG, GBRG, or none",
            "Import files in colour of that camera instead, TIFF or JPEG, in a folder without its RAW files.",
        )
    )
