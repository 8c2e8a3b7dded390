"""Parameters that an answer fitted, against those that were withheld."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

NEUTRAL = {"scale": 1.0, "gamma": 1.0, "level_dn": 255.0, "step_dn": 1.0, "quality": 100.0}
"""Neutral values that are not 0; of white balance `red` and `blue` are neutral at 1 too."""

NOT_COMPARED = frozenset(
    {"angle_deg", "period_rows", "radius_px of sharpening", "step_dn", "quality", "hot_share"}
)
"""Parameters without an amplitude, or chosen rather than fitted."""

SUMMED = {
    "vignetting": ("k1", "k2", "k3"),
    "lens-shading-correction": ("k1", "k2"),
    "nonlinearity": ("a2", "a3"),
}
"""Coefficients of a polynomial stand for one another; what they come to at 1 is compared."""

OWN_SCALE = frozenset({"denoise"})
"""Effects whose parameter means something else for the generator than for the catalogue."""


@dataclass(frozen=True)
class ParameterFound:
    """A parameter as it was withheld and as it was found."""

    effect: str
    name: str
    true: float
    found: float
    neutral: float  # the value at which the effect is off
    interval: tuple[float, float] | None  # the answer's, of 90 %; None where it gives none

    @property
    def relative_error(self) -> float:
        """Error over the distance of the truth from neutral."""
        return abs(self.found - self.true) / max(abs(self.true - self.neutral), 1e-9)

    @property
    def relative_width(self) -> float | None:
        """Half the interval's width over the distance of the truth from neutral."""
        if self.interval is None:
            return None
        return (self.interval[1] - self.interval[0]) / 2 / max(abs(self.true - self.neutral), 1e-9)

    @property
    def holds(self) -> bool | None:
        return None if self.interval is None else self.interval[0] <= self.true <= self.interval[1]

    @property
    def half_widths_off(self) -> float | None:
        """Distance of the truth from the value found, in half widths of the interval on that side."""
        if self.interval is None:
            return None
        low, high = self.interval
        half = self.found - low if self.true < self.found else high - self.found
        return abs(self.true - self.found) / max(half, 1e-12)


def parameters_found(effect: str, true: Mapping[str, Any], cause: Mapping[str, Any]) -> list[ParameterFound]:
    if effect in OWN_SCALE or not true:
        return []
    found = cause["parameters"]
    if effect in SUMMED:
        keys = SUMMED[effect]
        total = sum(found[key]["value"] for key in keys if key in found)
        return [ParameterFound(effect, "sum", sum(true.get(k, 0.0) for k in keys), total, 0.0, None)]
    return list(_one_by_one(effect, true, found))


def _one_by_one(effect: str, true: Mapping[str, Any], found: Mapping[str, Any]) -> Iterator[ParameterFound]:
    for key, value in true.items():
        neutral = 1.0 if effect == "white-balance" else NEUTRAL.get(key, 0.0)
        skipped = key in NOT_COMPARED or f"{key} of {effect}" in NOT_COMPARED
        if skipped or not isinstance(value, int | float) or key not in found or value == neutral:
            continue
        guess, interval = found[key]["value"], found[key].get("ci")
        if isinstance(guess, int | float):
            ends = (float(interval[0]), float(interval[1])) if interval else None
            yield ParameterFound(effect, key, float(value), float(guess), neutral, ends)
