"""Figures of photosites that are not published: a prior over sensors whose figures are known.

A figure y of a photosite of pitch p is drawn of each image sensor by itself:

    f(y) = intercept + slope ln(p / 1 um) + spread z,    z ~ N(0, 1)

with f the logarithm, or the logit for shares. `z` follows from the names of sensor and figure and from the
draw, so that a sensor is the same wherever it is used.

Source: Full well, read noise, quantum efficiency: least squares over all parts of the catalogs
``image_sensors`` and ``image_sensors_more`` that know them (29, 28 and 18 sensors), which a test repeats.
Dark current: published figures of CMV4000, IMX900 and OV5647 (125, 1.47 and 16 e-/s), without a dependence on
the pitch. Read noise after the gain: its share of the dark variance at the lowest ISO from 100 on of 223
still cameras (profiles published with darktable), as the recipe `noise_over_gain` fits it. Red and blue over
green: grey at 6500 K in raw files of seven sensors of the catalogs, as drivers of libcamera are calibrated.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

from tacos_framework import generator


@dataclass(frozen=True)
class FigurePrior:
    """Prior of one figure over sensors."""

    intercept: float
    slope: float
    """Of f(y) over ln of the pitch in um [1]."""
    spread: float
    """Standard deviation of f(y) [1]."""
    sensors: int
    """Number of sensors it was fitted to [1]."""
    is_share: bool = False
    """True if f is the logit rather than the logarithm."""

    def value(self, pixel_um: float, z: float = 0.0) -> float:
        """The figure at a pitch, `z` standard deviations above the middle."""
        transformed = self.intercept + self.slope * math.log(pixel_um) + self.spread * z
        return 1 / (1 + math.exp(-transformed)) if self.is_share else math.exp(transformed)


PRIORS: Mapping[str, FigurePrior] = MappingProxyType(
    {
        "quantum_efficiency": FigurePrior(1.413, -0.375, 0.505, 18, is_share=True),
        "full_well_e": FigurePrior(8.078, 1.127, 0.411, 29),
        "read_noise_e": FigurePrior(0.807, 0.293, 0.560, 28),
        "dark_current_e_s": FigurePrior(2.66, 0.0, 2.2, 3),
        "read_noise_share_after_gain": FigurePrior(3.57, 0.0, 2.2, 223, is_share=True),
        "red_over_green": FigurePrior(-0.889, 0.0, 0.321, 7),
        "blue_over_green": FigurePrior(-0.327, 0.0, 0.124, 7),
    }
)
"""By name of the figure."""


Draw = tuple[int | str, ...]
"""Names a draw: a seed and names. A seed of 0 alone is the middle of the priors."""


@lru_cache(maxsize=1024)  # each frame asks for every figure
def assumed(figure: str, *, sensor: str, pixel_um: float, draw: Draw) -> float:
    """The figure of a sensor that does not state it; the same whenever the arguments are.

    `figure`: a name in `PRIORS`. `draw`: ``(0,)`` is the middle of the prior, others are draws of it.

    >>> round(assumed("full_well_e", sensor="IMX172", pixel_um=1.55, draw=(0,)))
    5281
    >>> assumed("full_well_e", sensor="A", pixel_um=3, draw=(1,)) == assumed(
    ...     "full_well_e", sensor="B", pixel_um=3, draw=(1,)
    ... )
    False
    """
    return PRIORS[figure].value(pixel_um, deviate(figure, sensor=sensor, draw=draw))


@lru_cache(maxsize=4096)
def deviate(figure: str, *, sensor: str, draw: Draw) -> float:
    """Place of a drawn figure in its prior, in standard deviations above the middle [1]."""
    if draw == (0,):
        return 0.0
    seed, *names = draw
    return float(generator(int(seed), *names, "photosite", sensor, figure).standard_normal())


def assumed_from(figure: str) -> str:
    """Origin of an assumed figure, and the scatter of sensors about it, in a phrase.

    >>> assumed_from("read_noise_e")
    'assumed from 28 sensors, within a factor of 1.8 in two of three'
    """
    prior = PRIORS[figure]
    if prior.is_share:
        low, high = prior.value(2.0, -1), prior.value(2.0, 1)
        return f"assumed from {prior.sensors} sensors, {low:.2f} to {high:.2f} in two of three"
    factor = math.exp(prior.spread)
    return f"assumed from {prior.sensors} sensors, within a factor of {factor:.2g} in two of three"
