"""The projection of a fisheye from the curve that is published of it."""

from __future__ import annotations

import math
import re

import numpy as np

from tacos_framework import Lens

_TERM = re.compile(r"([+-]?\s*\d*\.?\d+)\s*\*\s*t(?:\^(\d))?")
_POWERS = 1 + 2 * np.arange(5)


def lens_of_curve(curve: str) -> tuple[float, Lens]:
    """Kannala and Brandt's lens along a curve, and its focal length over that with which the curve begins.

    `curve`: ``r/R = a*t + b*t^2 + ...`` with the field angle t [rad] and the radius R of the image circle, as
    canopy photographs are calibrated. Kannala and Brandt's odd powers follow those of the catalog within 0.15
    % of R by least squares.

    >>> scale, lens = lens_of_curve("r/R = 0.6391*t - 0.0252*t^2 + 0.0381*t^3 - 0.0214*t^4")
    >>> round(scale, 3), round(lens.half_field_deg, 1)
    (0.993, 94.7)
    """
    terms = {int(power or 1): float(factor.replace(" ", "")) for factor, power in _TERM.findall(curve)}
    if not curve.startswith("r/R") or terms.get(1, 0.0) <= 0:
        raise ValueError(f"curve {curve!r} is not like r/R = 0.64*t - 0.03*t^2")
    angle = np.linspace(0.0, math.pi, 4001)[1:]
    radius = np.sum([factor * angle**power for power, factor in terms.items()], axis=0)
    outside = np.flatnonzero((radius > 1) | (np.diff(radius, append=np.inf) <= 0))
    end = int(outside[0]) if outside.size else len(angle)
    powers = angle[:end, None] ** _POWERS
    first, *others = np.linalg.lstsq(powers, radius[:end], rcond=None)[0]
    lens = Lens("kannala-brandt", tuple(float(each / first) for each in others))
    half_field_rad = min(float(angle[end - 1]), lens.reach_rad)
    return float(first / terms[1]), Lens(lens.projection, lens.coefficients, math.degrees(half_field_rad))
