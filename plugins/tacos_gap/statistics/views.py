"""Views of statistics: over what, in which unit, under which title."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Over = Literal["image", "arrows", "level", "radius", "frequency", "period", "places"]
Shown = Callable[[NDArray[np.float64]], NDArray[np.float64]]

_KEYS: Mapping[str, Over] = {
    "box_px": "image",
    "level_dn": "level",
    "frequency_cycles_px": "frequency",
    "period_rows": "period",
    "radius": "radius",
}


def _same(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return values


def _percent(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return 100 * values


def _contrast(log_power: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.exp(log_power / 2)


@dataclass(frozen=True)
class StatisticView:
    title: str
    quantity: str  # what is on the vertical axis, with its unit
    shown: Shown = _same  # from the statistic's values to that quantity
    explained: str = ""  # what a difference means, in a sentence


_VIEWS = {
    "relative_illumination": StatisticView(
        "Brightness over the image",
        "real over simulated [%]",
        _percent,
        "The mean level is taken out, so that exposure does not count.",
    ),
    "dark_field": StatisticView("Offset over the image, with the cap on", "real less simulated [DN]"),
    "displacement": StatisticView(
        "Where things appear", "displacement [px]", explained="Real less simulated position."
    ),
    "colour_displacement": StatisticView(
        "Where red and blue appear against green", "displacement [px]", explained="Real less simulated."
    ),
    "board_corners": StatisticView(
        "Corners of the boards", "misfit [px]", explained="What no pose of the board explains."
    ),
    "level": StatisticView("Level against expected level", "real less expected [DN]"),
    "dark_level": StatisticView("Level in the dark", "real less expected [DN]"),
    "photon_transfer": StatisticView(
        "Noise against signal", "variance over frames [DN²]", np.exp, "The photon-transfer curve."
    ),
    "spatial_noise": StatisticView("Noise against signal, from single frames", "variance [DN²]", np.exp),
    "noise_over_field": StatisticView(
        "Noise over the radius",
        "noise over its expectation [1]",
        np.exp,
        "Flat where light is lost, rising where values were scaled up afterwards.",
    ),
    "fixed_pattern": StatisticView(
        "Pattern that repeats from frame to frame",
        "its variance [DN²]",
        explained="Covariance of independent halves of the frames.",
    ),
    "blemishes": StatisticView(
        "Blemishes: patterns wider than pixels",
        "their variance [DN²]",
        explained="Dust on the sensor's cover glass, say, or a stain.",
    ),
    "detail": StatisticView(
        "Contrast of detail over spatial frequency",
        "contrast over that expected [1]",
        _contrast,
        "Below 1 detail is lost, above 1 it was sharpened.",
    ),
    "row_waves": StatisticView("Waves over the rows", "amplitude over the signal [%]", _percent),
    "row_noise": StatisticView("Noise shared by a row", "over that of independent pixels [1]", np.exp),
    "column_noise": StatisticView("Noise shared by a column", "over that of independent pixels [1]", np.exp),
    "noise_autocorrelation": StatisticView("Correlation of noise between neighbours", "correlation [1]"),
    "channel_correlation": StatisticView("Correlation of noise between channels", "correlation [1]"),
    "noise_lattice": StatisticView("Noise on the lattice of the colour filters", "over its mean [1]", np.exp),
    "noise_tails": StatisticView("Tails of the noise", "kurtosis [1]", np.exp),
    "column_pattern": StatisticView("Pattern of columns", "their variance [DN²]"),
    "row_pattern": StatisticView("Pattern of rows", "their variance [DN²]"),
    "line_offset": StatisticView("Rows and columns that stand out", "offset [DN]"),
    "hot_pixels": StatisticView("Hot pixels", "times what is negligible", np.expm1),
    "clipped": StatisticView("Clipped pixels", "share [%]", _percent),
    "top_level": StatisticView("The largest values", "share [%]", _percent),
    "code_comb": StatisticView("Empty codes", "strength [1]"),
    "colour_matrix": StatisticView("How channels mix", "entry of the matrix [1]"),
    "patches": StatisticView("Patches of the chart", "real less expected [DN]"),
    "level_over_time": StatisticView(
        "Brightness over time", "off the mean of the sequence [%]", _percent, "A drift is a control at work."
    ),
    "frame_to_frame": StatisticView("Brightness from frame to frame", "standard deviation [%]", _percent),
}


def view_of(statistic: str) -> StatisticView:
    words = statistic.replace("_", " ")
    return _VIEWS.get(statistic) or StatisticView(words[:1].upper() + words[1:], words)


def over(places: Iterable[Mapping[str, Any]]) -> Over:
    keys = {key for at in places for key in at}
    if "axis" in keys:
        return "arrows"
    return next((found for key, found in _KEYS.items() if key in keys), "places")


def position(value: Any) -> float:
    """A place on an axis: the middle of an interval, or the number itself."""
    return float(np.mean(value))


def place_words(at: Mapping[str, Any]) -> str:
    """A place in words: ``{"lag_px": [1, 0], "channel": "R"}`` becomes ``1, 0 R``.

    >>> place_words({"lag_px": [1, 0], "channel": "mono"}), place_words({"end": "white"})
    ('1, 0', 'white')
    """
    if "from" in at and "to" in at:
        return f"{at['from']} to {at['to']}"
    parts = []
    for key, value in at.items():
        if key == "channel" and value == "mono":
            continue
        parts.append(", ".join(f"{v:g}" for v in value) if isinstance(value, list) else str(value))
    return " ".join(parts)
