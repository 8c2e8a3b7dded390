"""Noise of one camera over its gain, from the gains at which it was measured.

Signal x is a share of full scale, so the variance of the noise is ``a x + b``. A chain with noise before and
after its amplifier has

    a(G) = k G e^u(g)                         slope: the system gain over full scale
    b(G) = (p G^2 + q) e^w(g),  g = log2 G    intercept: noise before (p) and after (q) the gain

Real cameras depart from this chain where they switch the conversion gain of a photosite, where a gain is
digital, or where its label is not what it does. The gains of such steps are seldom published; a function that
jumps at unknown places has the exponential covariance, so that u and w are Gaussian processes with

    cov(g, g') = s^2 exp(-|g - g'| / l) + n^2 (g = g')

Near a measured gain they follow the measurements; far from all they return to the chain, with an interval as
wide as real cameras differ from it.

Source: EMVA Standard 1288, Release 4.0 Linear, Sec. 2 (the chain); Rasmussen and Williams, Gaussian Processes
for Machine Learning, 2006, eq. 2.25 and 2.26 (prediction), eq. 4.14 with nu = 1/2 (covariance).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import least_squares

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Departure:
    """Prior of how far cameras depart from the chain, as natural logarithms."""

    spread: float  # s: standard deviation over cameras and gains [1]
    range_stops: float  # l: distance over which a departure is forgotten [log2 of gain]
    scatter: float  # n: standard deviation of one measurement [1]

    def covariance(self, one: Array, other: Array) -> Array:
        """Covariance of the departures at two lists of gains [log2], without scatter."""
        distance = np.abs(one[:, None] - other[None, :])
        return self.spread**2 * np.exp(-distance / self.range_stops)


SLOPE_DEPARTURE = Departure(spread=0.5, range_stops=6.0, scatter=0.12)
INTERCEPT_DEPARTURE = Departure(spread=2.5, range_stops=6.0, scatter=0.5)
"""Widths at which 90 % intervals hold 89 and 90 % of the left-out gains of two halves of 262 cameras.

The scatter is wider than the likelihood asks for: a normal interval has to hold the cameras that jump too.
"""


class Noise(NamedTuple):
    """Predicted noise at one gain; signal is a share of full scale."""

    slope: float  # a: variance per signal [1]
    intercept: float  # b: variance without signal [1]
    slope_sd: float  # of ln a [1]
    intercept_sd: float  # of ln b [1]

    def variance(self, signal: float) -> float:
        """Variance at a signal, both as shares of full scale [1]."""
        return self.slope * signal + self.intercept

    def variance_sd(self, signal: float) -> float:
        """Standard deviation of the logarithm of that variance [1]."""
        share = self.intercept / self.variance(signal)
        return float(np.hypot((1 - share) * self.slope_sd, share * self.intercept_sd))


class NoiseOverGain:
    """Noise at any gain, from measurements at some.

    Intercepts at or below zero are fits that failed in the dark; they bear on the slope alone.

    - `gains`: (N,) linear gains, in any unit; ISO values will do [1].
    - `slopes`, `intercepts`: (N,) measured a and b over full scale [1].

    Raises ValueError without a gain, with a gain or slope that is not above 0, or with no intercept above 0.

    Noise before the gain of 2e-9, after it of 8e-9, predicted between and beyond the measured gains:

    >>> gain = np.array([1.0, 2.0, 8.0])
    >>> camera = NoiseOverGain(gain, 1e-5 * gain, 2e-9 * gain**2 + 8e-9)
    >>> noise = camera.at(4.0)
    >>> f"{noise.slope:.2g} {noise.intercept:.2g}"
    '4e-05 4e-08'
    >>> camera.at(64.0).slope_sd > 1.5 * noise.slope_sd
    True
    """

    def __init__(self, gains: ArrayLike, slopes: ArrayLike, intercepts: ArrayLike) -> None:
        gain, slope, intercept = (np.atleast_1d(np.asarray(v, float)) for v in (gains, slopes, intercepts))
        dark = intercept > 0
        if not len(gain) or not dark.any() or not (gain > 0).all() or not (slope > 0).all():
            raise ValueError(
                "noise over gain needs gains and slopes above 0, and at least one intercept above 0; "
                f"given were gains {gain.tolist()}, slopes {slope.tolist()}, intercepts {intercept.tolist()}"
            )
        scaled = slope / gain
        self._gain_slope = float(np.exp(np.median(np.log(scaled))))
        self.before, self.after = fit_two_stages(gain[dark], intercept[dark])
        self._slope = _Departures(SLOPE_DEPARTURE, np.log2(gain), np.log(scaled / self._gain_slope))
        self._intercept = _Departures(
            INTERCEPT_DEPARTURE, np.log2(gain[dark]), np.log(intercept[dark] / self._chain(gain[dark]))
        )

    def at(self, gain: float) -> Noise:
        """Noise at a gain, in the unit of the measured ones."""
        slope, slope_sd = self._slope.at(float(np.log2(gain)))
        intercept, intercept_sd = self._intercept.at(float(np.log2(gain)))
        return Noise(
            self._gain_slope * gain * float(np.exp(slope)),
            float(self._chain(np.array([gain]))[0] * np.exp(intercept)),
            slope_sd,
            intercept_sd,
        )

    def _chain(self, gain: Array) -> Array:
        return self.before * gain**2 + self.after


def fit_two_stages(gains: Array, intercepts: Array) -> tuple[float, float]:
    """p and q of ``b = p G^2 + q``, by least absolute-like residuals of the logarithm.

    One gain cannot tell the two apart; half of the variance is then given to each.

    - `gains`, `intercepts`: (N,) above 0.

    Returns: p and q, both above 0.

    >>> gain = np.array([1.0, 4.0, 16.0])
    >>> p, q = fit_two_stages(gain, 3e-9 * gain**2 + 5e-8)
    >>> f"{p:.3g} {q:.3g}"
    '3e-09 4.99e-08'
    """
    observed = np.log(intercepts)
    top, bottom = intercepts[np.argmax(gains)], intercepts[np.argmin(gains)]
    start = np.log([top / (2 * gains.max() ** 2), bottom / 2])
    if len(np.unique(gains)) == 1:
        return float(np.exp(start[0])), float(np.exp(start[1]))

    def residuals(logs: Array) -> Array:
        misfit = np.logaddexp(logs[0] + 2 * np.log(gains), logs[1]) - observed
        # A stage that the data do not show at all stays within four stops of where it would show.
        return np.concatenate([misfit, 0.05 * (logs - start)])

    found = least_squares(residuals, start, loss="soft_l1", f_scale=0.3).x
    return float(np.exp(found[0])), float(np.exp(found[1]))


class _Departures:
    """A Gaussian process with a constant mean of its own, conditioned on departures."""

    def __init__(self, prior: Departure, stops: Array, departures: Array) -> None:
        self._prior, self._stops = prior, stops
        known = prior.covariance(stops, stops) + prior.scatter**2 * np.eye(len(stops))
        self._factor = cho_factor(known)
        self._weights = cho_solve(self._factor, departures)

    def at(self, stop: float) -> tuple[float, float]:
        prior = self._prior
        to_known = prior.covariance(np.array([stop]), self._stops)[0]
        explained = to_known @ cho_solve(self._factor, to_known)
        variance = max(prior.spread**2 - explained, 0.0) + prior.scatter**2
        return float(to_known @ self._weights), float(np.sqrt(variance))
