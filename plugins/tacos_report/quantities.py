"""Numbers as people read them: sensible digits, units, names in words."""

from __future__ import annotations

import math
from typing import Any

_UNIT_SIGNS = {
    "deg": "°", "um": "µm", "um2": "µm²", "1": "", "percent": "%", "cd_m2": "cd/m²", "e": "e⁻", "e_s": "e⁻/s",
    "mw": "mW", "w": "W", "usd": "USD", "eur": "EUR", "hz": "Hz", "fps": "frames/s", "us": "µs", "dn": "DN",
    "1/s": "per s",
}  # fmt: skip
_UNIT_SUFFIXES = (
    "deg", "mm", "um", "m", "px", "db", "lux", "s", "ms", "percent", "e", "mw", "w", "g", "usd", "eur",
    "hz", "fps", "us", "dn",
)  # fmt: skip
_WORDS = {
    "hfov_deg": "Horizontal field of view",
    "vfov_deg": "Vertical field of view",
    "dfov_deg": "Diagonal field of view",
    "megapixels": "Pixel count",
    "pixel_um": "Pixel size",
    "pixels_per_deg": "Angular resolution",
    "f_number_min": "Smallest f-number",
    "max_sensor_format": "Largest sensor format",
    "tv_distortion_percent": "TV distortion",
    "cameras": "Number of cameras",
    "covered_deg": "Angle in view around",
    "first_yaw_deg": "Turn of the first camera",
    "side_yaw_deg": "Turn of the side cameras",
    "side_hfov_deg": "Field of view to the sides",
    "back_hfov_deg": "Field of view behind",
    "total_megapixels": "Pixels of all cameras",
    "total_power_w": "Power of all cameras",
    "f_number": "F-number",
    "focus_m": "Distance of focus",
    "exposure_ms": "Exposure time",
    "gain_db": "Gain",
    "sensor_binning": "Binning",
    "roi_width": "Share of the width read out",
    "roi_height": "Share of the height read out",
    "pixel_rate_mpx_s": "Pixel rate",
    "bandwidth_mbit_s": "Bandwidth",
    "exposure_min_us": "Shortest exposure",
    "exposure_max_ms": "Longest exposure",
    "min_exposure_us": "Shortest exposure",
    "gain_max_db": "Largest gain",
    "max_fps": "Highest frame rate",
    "row_time_us": "Line time",
    "frame_lines": "Lines of a frame",
    "cfa": "Colour filters",
    "black_level_dn": "Black level",
    "black_level_bits": "Bits of the black level",
    "fitness": "Fitness",
}
_NARROW_SPACE = "\u202f"
_MINUS = "\u2212"


def unit_of(name: str) -> str:
    """The unit that ends a name: ``focal_length_mm`` -> ``mm``; empty where there is none."""
    suffix = name.rpartition("_")[2]
    if name == "megapixels":
        return "MP"
    if name.endswith("_e_s"):
        return "e_s"
    if suffix == "db":
        return "dB"
    return suffix if suffix in _UNIT_SUFFIXES and "_" in name else ""


def unit_sign(unit: str) -> str:
    """A unit as printed: ``deg`` -> ``°``."""
    return _UNIT_SIGNS.get(unit, unit)


def words(name: str) -> str:
    """A variable, score or node in words: ``focal_length_mm`` -> ``Focal length``.

    Scores keep the node that reports them: ``features.inlier_ratio`` -> ``features: inlier ratio``. Settings
    that have a word need no owner where only one can be meant: ``scenario.f_number`` -> ``F-number``.
    """
    if name in _WORDS:
        return _WORDS[name]
    node, dot, score = name.rpartition(".")
    if dot and score in _WORDS and (node == "scenario" or node.startswith("effects.")):
        return _WORDS[score]
    if dot:
        return f"{node.replace('_', ' ')}: {score.replace('_', ' ')}"
    unit = unit_of(name)
    stem = name[: -len(unit) - 1] if unit and "_" in name else name
    text = stem.replace("_", " ")
    return text[:1].upper() + text[1:]


def number(value: float, digits: int = 3) -> str:
    """A number to so many significant digits, never in scientific notation, thousands set apart.

    >>> number(0.123456), number(12.0), number(1234567.0)
    ('0.123', '12', '1\\u202f234\\u202f567')
    """
    if not math.isfinite(value):
        return "not a number"
    if value == 0:
        return "0"
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    text = _grouped(value, min(decimals, 8))
    return text.rstrip("0").rstrip(".") if "." in text else text


def measured(value: float, error: float | None) -> str:
    """A value with its standard error, both to the digits the error supports: ``3.42 ± 0.05``."""
    if error is None or not math.isfinite(error) or error <= 0:
        return number(value)
    decimals = _error_decimals(error)
    return f"{_grouped(value, decimals)} ± {_grouped(error, decimals)}"


def signed(value: float, error: float | None = None) -> str:
    """A difference, with its sign shown unless it rounds to nothing: ``+0.52 ± 0.08``, ``0.00 ± 0.02``.

    >>> signed(0.52, 0.08), signed(-0.0035, 0.02), signed(0.0)
    ('+0.52 ± 0.08', '0.00 ± 0.02', '0')
    """
    text = measured(value, error) if error else number(value, 2)
    nothing = not any(digit in "123456789" for digit in text.partition(" ")[0])
    return text if text.startswith(_MINUS) or nothing else f"+{text}"


def percent(share: float) -> str:
    """A relative change with its sign: 0.183 -> ``+18 %``."""
    value = share * 100
    decimals = 1 if abs(value) < 9.95 else 0
    text = _grouped(value, decimals)
    return f"{text if value < 0 else '+' + text}{_NARROW_SPACE}%"


def quantity(value: float, unit: str, digits: int = 3) -> str:
    """A number and its unit: ``2.9 mm``, ``−22.4°``."""
    return joined(_angle(value) if unit == "deg" else number(value, digits), unit)


def joined(text: str, unit: str) -> str:
    """A printed number and its unit, never broken over two lines."""
    sign = unit_sign(unit)
    if sign == "°":
        return f"{text}°"
    return f"{text}{_NARROW_SPACE}{sign}" if sign else text


def duration(seconds: float) -> str:
    """Seconds as a person says them: ``2 min 47 s``."""
    if seconds < 10:
        return quantity(seconds, "s", digits=2)
    whole = round(seconds)
    if whole < 60:
        return quantity(whole, "s")
    hours, rest = divmod(whole, 3600)
    minutes, left = divmod(rest, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {left} s"


def shown(name: str, value: Any, unit: str | None = None) -> str:
    """The value of a design variable or derived quantity; a catalog row by its title, or its name."""
    if isinstance(value, dict):
        return str(value.get("title") or value.get("name", "unnamed"))
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return quantity(float(value), unit_of(name) if unit is None else unit)
    return str(value)


def row_detail(row: dict[str, Any]) -> str:
    """Characteristics of a sensor: ``2.4 µm pixels, 7.4 × 5.0 mm``; empty where they are not known."""
    parts = []
    if _is_number(row.get("pixel_um")):
        parts.append(f"{quantity(row['pixel_um'], 'um')} pixels")
    if _is_number(row.get("width_mm")) and _is_number(row.get("height_mm")):
        parts.append(f"{number(row['width_mm'])} × {quantity(row['height_mm'], 'mm')}")
    return ", ".join(parts)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _angle(value: float) -> str:
    text = _grouped(value, 1)
    return text.removesuffix(".0")


def _error_decimals(error: float) -> int:
    """Decimals that leave one significant digit of the error, two where it begins with 1."""
    exponent = math.floor(math.log10(error))
    leading = error / 10**exponent
    return min(8, max(0, -exponent + (1 if leading < 1.95 else 0)))


def _grouped(value: float, decimals: int) -> str:
    rounded = round(value, decimals) + 0.0  # + 0.0 turns a negative zero into zero
    text = f"{abs(rounded):,.{decimals}f}".replace(",", _NARROW_SPACE)
    return f"{_MINUS}{text}" if rounded < 0 else text
