"""What the file of a photograph says of how it was taken."""

from __future__ import annotations

import math
import re
import warnings
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

from tacos_files.images import UNREADABLE
from tacos_framework.files import read_bytes
from tacos_gap.captures.images import RAW_SUFFIXES, opened_raw

LOSSY_SUFFIXES = frozenset({".jpg", ".jpeg", ".webp", ".heic"})

_FULL_FRAME_DIAGONAL_MM = math.hypot(36, 24)
_MM_PER_UNIT = {2: 25.4, 3: 10.0, 4: 1.0, 5: 1e-3}
"""Millimetres of EXIF's FocalPlaneResolutionUnit: inch, cm, mm, um."""

_TIME_IN_NAME = re.compile(r"(?<![a-z0-9.])(\d+(?:\.\d+)?)\s?(us|ms|s)(?![a-z0-9])", re.IGNORECASE)
_MS = {"us": 1e-3, "ms": 1.0, "s": 1e3}

_MAKE, _MODEL, _SOFTWARE, _ORIENTATION, _EXIF = 0x010F, 0x0110, 0x0131, 0x0112, 0x8769
_EXPOSURE, _F_NUMBER, _ISO, _TAKEN, _SUBSECOND = 0x829A, 0x829D, 0x8827, 0x9003, 0x9291
_FOCAL, _FOCAL_35, _PLANE_X, _PLANE_UNIT, _WIDTH = 0x920A, 0xA405, 0xA20E, 0xA210, 0xA002


@dataclass(frozen=True)
class Facts:
    """What a file says; None where it does not.

    Parameters
    ----------
    camera
        Make and model; empty if unknown.
    exposure_ms, f_number, focal_length_mm, iso
        As the camera wrote them [ms, 1, mm, 1].
    pixel_um
        Pitch of the file's pixels on the sensor [um].
    orientation
        EXIF's: 1 for files that stand as the sensor does.
    taken
        Date and time, as written, to sort by.
    software
        What wrote the file.
    lossy, raw
        Whether the file is compressed with loss; whether it holds the sensor's own samples.
    black_level_dn, white_level_dn, cfa
        Of a RAW file.
    time_from_name
        Whether the exposure time was read from the name of the file.
    """

    camera: str = ""
    exposure_ms: float | None = None
    f_number: float | None = None
    focal_length_mm: float | None = None
    iso: float | None = None
    pixel_um: float | None = None
    orientation: int = 1
    taken: str = ""
    software: str = ""
    lossy: bool = False
    raw: bool = False
    black_level_dn: float | None = None
    white_level_dn: float | None = None
    cfa: str | None = None
    time_from_name: bool = False


def read_facts(path: Path) -> Facts:
    """What a file says of itself: EXIF, the header of a RAW file, at last its name.

    Raises
    ------
    UserError
        When it cannot be read.
    """
    said = _of_raw(path) if path.suffix.lower() in RAW_SUFFIXES else {}
    if path.suffix.lower() != ".npy":
        said = {**_of_exif(path), **said}
    if said.get("exposure_ms") is None and (found := _TIME_IN_NAME.search(path.stem.replace("_", " "))):
        said |= {"exposure_ms": float(found[1]) * _MS[found[2].lower()], "time_from_name": True}
    return Facts(**said, lossy=path.suffix.lower() in LOSSY_SUFFIXES)


def _of_exif(path: Path) -> dict[str, Any]:
    """What EXIF says; nothing of a file that Pillow does not know, which may hold a picture all the same."""
    from PIL import Image

    content = read_bytes(path, "image_mb")
    try:
        with warnings.catch_warnings():  # of a size that is checked where samples are decoded, of odd entries
            warnings.simplefilter("ignore")
            with Image.open(BytesIO(content)) as image:
                width, height = image.size
                base = image.getexif()
                tags = {**base, **base.get_ifd(_EXIF)}
    except (*UNREADABLE, Image.DecompressionBombError):
        return {}
    exposure_s, plane = _number(tags.get(_EXPOSURE)), _number(tags.get(_PLANE_X))
    return {
        "camera": " ".join(
            dict.fromkeys(_text(tags.get(tag)) for tag in (_MAKE, _MODEL) if _text(tags.get(tag)))
        ),
        "exposure_ms": exposure_s and exposure_s * 1e3,
        "f_number": _number(tags.get(_F_NUMBER)),
        "focal_length_mm": _number(tags.get(_FOCAL)),
        "iso": _number(tags.get(_ISO)),
        "pixel_um": _pitch_um(tags, plane, width, height),
        "orientation": int(_number(tags.get(_ORIENTATION)) or 1),
        "taken": _text(tags.get(_TAKEN)) + "." + _text(tags.get(_SUBSECOND)) if tags.get(_TAKEN) else "",
        "software": _text(tags.get(_SOFTWARE)),
    }


def _pitch_um(tags: dict[Any, Any], per_unit: float | None, width: int, height: int) -> float | None:
    """Pitch of the file's pixels by the resolution in the focal plane, or by the equivalent focal length.

    Files made smaller have larger pixels, in proportion to the width that the camera noted.
    """
    whole = _number(tags.get(_WIDTH)) or width
    if per_unit:
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
    try:
        number = float(value)
    except (TypeError, ValueError, ZeroDivisionError):
        return None
    return number if math.isfinite(number) and number > 0 else None


def _text(value: Any) -> str:
    return str(value).strip().strip("\0") if isinstance(value, str) else ""


def _of_raw(path: Path) -> dict[str, Any]:
    with opened_raw(path, str(path)) as raw:
        other = getattr(raw, "other", None)  # since rawpy 0.22; EXIF says the same of most cameras
        said = {
            "raw": True,
            "black_level_dn": float(sum(raw.black_level_per_channel) / len(raw.black_level_per_channel)),
            "white_level_dn": float(raw.white_level),
            "cfa": _bayer_pattern(raw),
        }
        for key, name, scale in (
            ("exposure_ms", "shutter_speed", 1e3),
            ("iso", "iso_speed", 1.0),
            ("f_number", "aperture", 1.0),
            ("focal_length_mm", "focal_length", 1.0),
        ):
            if value := _number(getattr(other, name, None)):
                said[key] = value * scale
        return said


def _bayer_pattern(raw: Any) -> str | None:
    """The filters of a RAW file's mosaic from its corner on; None for other mosaics, or none."""
    try:
        pattern = raw.raw_pattern
    except NotImplementedError:  # filters that rawpy has no name for
        return None
    if pattern is None or pattern.shape != (2, 2):
        return None
    letters = raw.color_desc.decode("ascii", "replace")
    filters = "".join(letters[k] for k in pattern.ravel().tolist())
    return filters if filters in ("RGGB", "BGGR", "GRBG", "GBRG") else None
