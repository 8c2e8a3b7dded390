"""A curve between signal and code."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from tacos_framework import (
    Captures,
    Estimate,
    ImageContext,
    ImageGeometry,
    LookAlike,
    Settings,
    ShownBy,
    Stage,
    lit,
    of_kind,
    setting,
)
from tacos_plugins.effects import observations
from tacos_plugins.effects.chart_greys import exponent_of
from tacos_plugins.effects.pointwise import moments_behind
from tacos_plugins.effects.samples import Moments, Samples
from tacos_plugins.effects.shown_by import BRACKET

_STEPS = 4096  # of the table that stands for the cubic

_KNOTS = (0.03, 0.08, 0.18, 0.35, 0.55, 0.78)
"""Signals at which a curve is guessed, closer where curves of cameras are steep."""

_LEVEL, _FULL = 1e-3, 0.98
"""Rise from point to point below which a curve is level, and the code from which on it may be."""

_MIDDLE_GREY, _CODED_GREY = 0.18, 0.3
_BENT = 0.05
"""Departure of a guessed exponent from 1 below which captures suggest none."""

_BENT_CHART = 0.25
"""Departure from 1 that charts give linear cameras: a real one in the sun came to 0.88."""

_FEWEST_KNOTS = 3
_NEAREST = 15  # levels whose middle one is the code of a knot
_LEVELS_OF_EACH = 300


class ToneCurve:
    """Bends the signal t, from 0 at the pedestal to 1 at the white level, to ``t^gamma`` or along knots.

    A gamma of 0.45 brightens shadows as files for a display do; one above 1 darkens them. Below the
    pedestal the curve goes on point-symmetrically, so that the noise in the dark keeps both sides. Knots are
    joined by a monotone cubic, from (0, 0) to (1, 1); between the ends the curve keeps their order.

    Sources: Grossberg & Nayar 2004, "Modeling the space of camera response functions", IEEE Trans. PAMI
    26(10). Fritsch & Butland 1984, "A method for constructing local monotone piecewise cubic interpolants",
    SIAM J. Sci. Stat. Comput. 5(2): the cubic.
    """

    class Config(Settings):
        gamma: float = setting(1.0, help="Exponent of the curve.", gt=0, le=100)
        knots: tuple[tuple[float, float], ...] | None = setting(
            None,
            help="Points (signal, code) the curve passes, rising, from (0, 0) to (1, 1); in place of gamma.",
            min_length=2,
        )

        @model_validator(mode="after")
        def _one_rising_curve(self) -> Self:
            if self.knots is None:
                return self
            if self.gamma != 1:
                raise ValueError("either gamma or knots, not both")
            signal, code = np.array(self.knots).T
            if self.knots[0] != (0, 0) or self.knots[-1] != (1, 1) or np.any(np.diff(signal) <= 0):
                raise ValueError(f"knots whose signal rises from (0, 0) to (1, 1), not {list(self.knots)}")
            if np.any(np.diff(code) < 0):
                raise ValueError(f"knots whose code does not fall, not {list(self.knots)}")
            return self

    stage: ClassVar[Stage] = "isp"
    rank: ClassVar[int] = 60
    neutral: ClassVar[Mapping[str, Any]] = {"gamma": 1.0, "knots": None}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = (
        {"gamma": 0.85},
        {"gamma": 1.2},
        {"gamma": 0.45},
    )
    look_alikes: ClassVar[Sequence[LookAlike]] = (
        LookAlike(
            "exposure-error",
            observations.one_exposure_of_a_scene,
            "bracket",
            "levels against exposure times tell a curve from a scale",
        ),
        LookAlike(
            "exposure-error",
            observations.one_or_two_levels,
            "bracket",
            "levels against exposure times tell a curve from a scale",
        ),
    )
    shown_by: ClassVar[Sequence[ShownBy]] = (BRACKET,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def estimate_from(cls, captures: Captures) -> Iterator[Estimate]:
        """The exponent of the greys of charts, where it is far from 1: they exclude no slight curve."""
        found = [exponent for each in of_kind(captures, "chart") if (exponent := exponent_of(each))]
        if not found:
            return
        best = min(found, key=lambda each: each.standard_error)
        if abs(best.value - 1) > _BENT_CHART:
            yield Estimate("gamma", *best, negligible=_BENT_CHART)

    @classmethod
    def guesses_from(cls, captures: Captures) -> Iterator[Mapping[str, Any]]:
        """The exponent, and the curve, along which the levels of all captures lie that reach far enough."""
        expected, found = levels_of(captures)
        used = (expected > 0.005) & (expected < 1) & (found > 0.01) & (found < 0.97)
        if used.sum() > _NEAREST and np.ptp(np.log(expected[used])) > 1:
            gamma = float(np.polyfit(np.log(expected[used]), np.log(found[used]), 1)[0])
            if abs(gamma - 1) > _BENT:
                yield {"gamma": float(np.clip(gamma, 0.2, 5.0))}
        ends = np.quantile(expected, (0.02, 0.98)) if len(expected) else (0.0, 0.0)
        places = [x for x in _KNOTS if ends[0] <= x <= ends[1]]
        if len(places) < _FEWEST_KNOTS:
            return
        codes = [float(np.median(found[np.argsort(np.abs(expected - x))[:_NEAREST]])) for x in places]
        rising = np.clip(np.maximum.accumulate(codes), 0.0, 1.0).round(4).tolist()
        yield {"knots": ((0.0, 0.0), *zip(places, rising, strict=True), (1.0, 1.0))}

    @property
    def plausible(self) -> bool:
        """True if cameras have such curves: one that is level before full scale has been cut off."""
        if self.config.knots is None:
            return True
        code = np.array(self.config.knots)[:, 1]
        return not bool(np.any((np.diff(code) < _LEVEL) & (code[1:] < _FULL) & (code[:-1] > 0)))

    @property
    def codes(self) -> bool:
        """True if it codes files for a display: middle grey, 0.18, comes out above 0.3."""
        if not self._bends:
            return False
        grey = np.array([_MIDDLE_GREY])
        code = self._looked_up(grey) if self.config.knots else grey**self.config.gamma
        return bool(code[0] > _CODED_GREY)

    @property
    def _bends(self) -> bool:
        return self.config.gamma != 1 or self.config.knots is not None

    def _bent(self, signal: NDArray[Any], context: ImageContext) -> NDArray[Any]:
        full_scale_dn = context.white_level_dn - context.black_level_dn
        t = (signal - context.black_level_dn) / full_scale_dn
        size = np.abs(t)
        if self.config.knots is None:
            size **= self.config.gamma
        else:
            size = self._looked_up(size)
        return np.copysign(size, t) * full_scale_dn + context.black_level_dn

    @cached_property
    def _table(self) -> NDArray[np.float64]:
        from scipy.interpolate import PchipInterpolator  # late: checking a recipe draws no curve

        knots = np.array(self.config.knots).round(9)  # slopes of subnormal numbers would overflow
        return np.asarray(PchipInterpolator(knots[:, 0], knots[:, 1])(np.linspace(0, 1, _STEPS + 1)))

    def _looked_up(self, t: NDArray[Any]) -> NDArray[Any]:
        """The curve between knots; level from 1 on, where files end. `numpy.interp` is five times slower."""
        place = np.minimum(t * _STEPS, _STEPS)
        step = np.minimum(place.astype(np.int32), _STEPS - 1)
        table = self._table.astype(t.dtype)
        beyond = place - step.astype(t.dtype)
        return np.take(table, step) + beyond * np.take(np.diff(table), step)

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        return self._bent(signal, context) if self._bends else signal

    def moments(
        self, mean_dn: Samples, variance_dn2: Samples, *, geometry: ImageGeometry, context: ImageContext
    ) -> Moments:
        """Moments of Gaussian noise on the curve."""
        if not self._bends:
            return mean_dn, variance_dn2
        return moments_behind(lambda x: self._bent(x, context), mean_dn, variance_dn2)


def levels_of(captures: Captures) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Levels that captures are expected to have and those they have, above the pedestal over full scale.

    A few hundred of each capture, of pixels whose neighbourhood is the more even half.
    """
    expected, found = [], []
    for capture in lit(captures):
        if capture.expected_dn is None or not capture.valid.any():
            continue
        black = capture.context.black_level_dn
        full_scale_dn = capture.context.white_level_dn - black
        should = (capture.expected_dn.mean(axis=(0, 3)) - black) / full_scale_dn
        does = (capture.real_dn.mean(axis=(0, 3)) - black) / full_scale_dn
        steps = np.hypot(*np.gradient(should)) if min(should.shape) > 1 else np.zeros_like(should)
        even = capture.valid & (steps <= np.quantile(steps[capture.valid], 0.5))
        stride = max(int(even.sum()) // _LEVELS_OF_EACH, 1)
        expected.append(should[even][::stride])
        found.append(does[even][::stride])
    if not expected:
        return np.zeros(0), np.zeros(0)
    return np.concatenate(expected).astype(np.float64), np.concatenate(found).astype(np.float64)
