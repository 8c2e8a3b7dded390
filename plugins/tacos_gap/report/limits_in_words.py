"""Detection limits as something one can picture: percent of something, pixels, degrees, DN."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from tacos_framework import ImageGeometry
from tacos_gap.hypotheses.effect_names import effect_words
from tacos_report.quantities import number, unit_sign

_LEAST_PERCENT = 0.01
"""Percent below which a limit is no more than "less than that" to anyone."""

Worded = Callable[[float, ImageGeometry], str]


def limits_in_words(
    limits: Mapping[str, Mapping[str, float]], effects: Mapping[str, type[Any]], geometry: ImageGeometry
) -> dict[str, str]:
    """By effect, the least that would have shown.

    - `limits`: as `Diagnosis.detectable`.
    - `effects`: classes of the effects by name; they know the units and neutral values of the parameters that
      have no words of their own.
    - `geometry`: of the captured camera, whose corner counts.
    """
    said = {}
    for effect, values in sorted(limits.items()):
        parts = [
            _WORDED[effect, name](value, geometry)
            if (effect, name) in _WORDED
            else _plain(effects.get(effect), name, value)
            for name, value in values.items()
        ]
        said[effect] = ", ".join(parts)
    return said


def sentence(effect: str, limit: str) -> str:
    """A limit as a sentence.

    >>> sentence("lens-distortion", "0.3 % at the corner")
    'Lens distortion of 0.3 % at the corner would have shown.'
    """
    name = effect_words(effect)
    return f"{name[:1].upper()}{name[1:]} of {limit} would have shown."


def _percent(share: float, of: str = "") -> str:
    """A share without its sign: which way it goes makes no difference to whether it shows.

    >>> _percent(-0.00312, "of the light"), _percent(2e-6)
    ('0.31 % of the light', 'less than 0.01 %')
    """
    percent = 100 * abs(share)
    shown = f"{number(percent, 2)} %" if percent >= _LEAST_PERCENT else f"less than {_LEAST_PERCENT:g} %"
    return f"{shown} {of}".rstrip()


def _corner(geometry: ImageGeometry) -> float:
    """Half the diagonal of the sensor [px]."""
    return 0.5 * math.hypot(geometry.full_width_px, geometry.full_height_px)


def _bend(power: int) -> Worded:
    """A radial coefficient by how far it moves the corner, over its distance from the centre."""
    return lambda k, g: _percent(k * (_corner(g) / g.focal_length_px) ** power, "at the corner")


def _share(of: str, neutral: float = 0.0) -> Worded:
    return lambda value, g: _percent(value - neutral, of)


def _fringe(value: float, geometry: ImageGeometry) -> str:
    return f"{number(abs(value) * _corner(geometry), 2)} px at the corner"


def _dn(of: str = "") -> Worded:
    """Digital numbers, up or down alike."""
    return lambda value, g: f"{number(abs(value), 2)} DN {of}".rstrip()


def _readout(row_time_us: float, geometry: ImageGeometry) -> str:
    return f"{number(abs(row_time_us) * geometry.full_height_px * 1e-3, 2)} ms from the first row to the last"


def _grey(gamma: float, geometry: ImageGeometry) -> str:
    return _percent(0.5**gamma - 0.5, "of full scale in the middle greys")


def _bow(power: int) -> Worded:
    """Largest departure of y + a y^power from the straight line through its ends, over full scale."""
    y = np.linspace(0, 1, 201)
    most = float(np.max(np.abs(y**power - y)))
    return lambda a, g: _percent(a * most, "of full scale off a straight line")


_WORDED: dict[tuple[str, str], Worded] = {
    ("lens-distortion", "k1"): _bend(2),
    ("lens-distortion", "k2"): _bend(4),
    ("lens-distortion", "k3"): _bend(6),
    ("focal-length-error", "scale"): _share("of the focal length", 1.0),
    ("exposure-error", "scale"): _share("of the light", 1.0),
    ("conversion-gain-error", "scale"): _share("of the gain", 1.0),
    ("conversion-gain-mode", "noise_scale"): _share("of the noise in the dark", 1.0),
    ("white-balance", "red"): _share("of the red channel", 1.0),
    ("white-balance", "blue"): _share("of the blue channel", 1.0),
    ("vignetting", "k1"): _share("of the light at the corner"),
    ("lens-shading-correction", "k1"): _share("of the light at the corner"),
    ("illumination-gradient", "gx"): _share("of the light from side to side"),
    ("illumination-gradient", "gy"): _share("of the light from top to bottom"),
    ("veiling-glare", "share"): _share("of the light"),
    ("crosstalk", "share"): _share("of a pixel's signal in each neighbour"),
    ("prnu", "sigma"): _share("from pixel to pixel"),
    ("flicker", "depth"): _share("of the light"),
    ("lateral-chromatic-aberration", "red"): _fringe,
    ("lateral-chromatic-aberration", "blue"): _fringe,
    ("rolling-shutter", "row_time_us"): _readout,
    ("tone-curve", "gamma"): _grey,
    ("pose-error", "rx"): lambda angle, g: f"{number(abs(angle), 2)} deg",
    ("nonlinearity", "a2"): _bow(2),
    ("nonlinearity", "a3"): _bow(3),
    ("black-level", "offset_dn"): _dn(),
    ("dark-current", "rate_dn_s"): _dn("per second of exposure"),
    ("dark-current", "hot_share"): _share("of the pixels"),
    ("dsnu", "sigma_dn"): _dn("from pixel to pixel"),
    ("dsnu", "column_sigma_dn"): _dn("from column to column"),
    ("read-noise", "sigma_dn"): _dn("beside the noise expected"),
    ("read-noise", "after_gain_dn"): _dn("beside the noise expected"),
    ("row-noise", "sigma_dn"): _dn("from row to row"),
    ("row-noise", "column_sigma_dn"): _dn("from column to column"),
    ("denoise", "strength"): _share("of the noise smoothed"),
    ("denoise", "threshold"): _share("of full scale taken for noise"),
    ("sharpening", "amount"): _share("of the finest detail added again"),
}
"""By effect and parameter. Pixels and degrees can be pictured as they are, and have no entry."""


def _plain(effect: type[Any] | None, name: str, value: float) -> str:
    """A value with its unit, to two digits of its distance from neutral."""
    stem, _, suffix = name.rpartition("_")
    neutral = getattr(effect, "neutral", {}).get(name)
    shown = f"{_from(neutral, value):g}".replace("-", "\u2212")
    if suffix in _UNITS:
        return f"{stem.replace('_', ' ')} {shown} {unit_sign(_UNITS[suffix])}"
    return f"{name.replace('_', ' ')} {shown}"


_UNITS = {"px": "px", "deg": "deg", "dn": "DN", "mm": "mm", "s": "s", "us": "us", "ms": "ms"}


def _from(neutral: Any, value: float) -> float:
    """A value to two digits of how far it is from neutral.

    >>> _from(1.0, 1.02651), _from(None, -0.053964)
    (1.027, -0.054)
    """
    distance = abs(value - (neutral if isinstance(neutral, int | float) else 0.0))
    return value if distance == 0 else round(value, 1 - math.floor(math.log10(distance)))
