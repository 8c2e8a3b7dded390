"""Effects as hypotheses: which, with which parameters free, starting where."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import EffectBase, calling, optional, period_of
from tacos_framework.formation import PlacedEffect
from tacos_gap.captures import RealCapture
from tacos_gap.hypotheses.by_capture import captures_with_values, guesses_by_capture, setting_of, values_in

KNOT_STEP = 0.04
"""Step that matters of a point of a curve [full scale]."""

SUGGESTED_STEP = 0.1
"""A change that matters, over the distance from neutral that captures suggest."""


@dataclass(frozen=True)
class HypothesisTerm:
    name: str
    cls: type[Any]
    values: Mapping[str, Any]
    """Parameters that differ from the class's defaults; those of one capture are as
    `tacos_gap.hypotheses.by_capture` names them."""
    free: Mapping[str, float]  # names of those that are fitted, each with a step that matters
    is_stated: bool = False
    """Whether the files themselves state its discrete settings, so that these are not searched."""

    @property
    def use(self) -> str:
        return f"effect.{self.name}"

    def placed(self, capture: str | None = None) -> PlacedEffect | None:
        """The effect as a recipe places it; None where it refuses the values, or no camera has them."""
        if any(self._placed(own) is None for own in captures_with_values(self.values)):
            return None
        return self._placed(capture)

    def _placed(self, capture: str | None) -> PlacedEffect | None:
        with calling(self.use, doing="with settings of a diagnosis"):
            try:
                config = self.cls.Config(**_nested(values_in(self.values, capture)))
                effect = self.cls(config)
            except ValueError:  # pydantic's ValidationError is one
                return None
            plausible = optional(effect, EffectBase, "plausible")
        return PlacedEffect(self.use, self.use, self.cls, config) if plausible else None

    def with_free(self, theta: Sequence[float]) -> HypothesisTerm:
        changed = {name: float(value) for name, value in zip(self.free, theta, strict=True)}
        return replace(self, values={**self.values, **changed})

    @property
    def theta(self) -> NDArray[np.float64]:
        return np.array([self.values[name] for name in self.free], float)

    @property
    def settings(self) -> dict[str, Any]:
        """Its values as a recipe has them, for all captures; angles from 0 on."""
        values = _nested(values_in(self.values))
        return {name: self._from_zero(name, value) for name, value in values.items()}

    def _from_zero(self, name: str, value: Any) -> Any:
        period = period_of(self.cls.Config, name)
        return value % period if period is not None and isinstance(value, float) else value


def _nested(values: Mapping[str, Any]) -> dict[str, Any]:
    """Put what is fitted entry by entry together again.

    Six free entries of a matrix are ``matrix.row.column``; its rows sum to 1. Free points of a curve from
    (0, 0) to (1, 1) are ``knots.x``, x in thousandths.
    """
    plain = {name: value for name, value in values.items() if "." not in name}
    if any(name.startswith("matrix.") for name in values):
        matrix = np.zeros((3, 3))
        for name, value in values.items():
            if name.startswith("matrix."):
                _, row, column = name.split(".")
                matrix[int(row), int(column)] = value
        matrix[np.diag_indices(3)] = 1 - matrix.sum(axis=1)
        plain["matrix"] = tuple(tuple(float(v) for v in row) for row in matrix)
    inner = [(_neutral_of(name, {}), value) for name, value in values.items() if name.startswith("knots.")]
    if inner:
        plain["knots"] = ((0.0, 0.0), *sorted(inner), (1.0, 1.0))
    return plain


def _neutral_of(name: str, neutral: Mapping[str, Any]) -> float | None:
    if name.startswith("matrix."):
        return 0.0
    if name.startswith("knots."):
        return int(name.removeprefix("knots.")) / 1000
    value = neutral.get(setting_of(name))
    return value if isinstance(value, float) else None


def neutral_value(cls: type[Any], name: str) -> float | None:
    """Neutral value of a free parameter of an effect; None where there is no such value by itself."""
    return _neutral_of(name, cls.neutral)


def initial_guesses_for(name: str, cls: type[Any], captures: Sequence[RealCapture]) -> list[HypothesisTerm]:
    """Initial guesses of the search for an effect: those of its class from captures, and in general."""
    suggested: list[Mapping[str, Any]] = []
    with calling(f"effect.{name}", doing="guesses_from"):
        if callable(guess := optional(cls, EffectBase, "guesses_from")):
            suggested += guess(captures)
        suggested += guesses_by_capture(cls, captures)
    if cls.stage == "codec" and suggested and all(each.coding is not None for each in captures):
        return [replace(term, is_stated=True) for term in initial_guesses_of(name, cls, suggested)]
    return [*initial_guesses_of(name, cls, suggested), *initial_guesses_of(name, cls)]


def initial_guesses_of(
    name: str, cls: type[Any], suggested: Sequence[Mapping[str, Any]] | None = None
) -> Iterator[HypothesisTerm]:
    """Initial guesses for the fit of an effect.

    Those `suggested`, where given, else the ``initial_guesses`` of the class. Without them, each float with a
    neutral value is moved a little to either side of it.
    """
    floats = {k: v for k, v in cls.neutral.items() if isinstance(v, float)}
    own = optional(cls, EffectBase, "initial_guesses")
    if own is None:
        own = [{key: value + side * step(cls, key)} for key, value in floats.items() for side in (1, -1)]
    guesses = [_flattened(guess) for guess in (own if suggested is None else suggested)]
    scales = _scales(guesses, cls) | _scales([_flattened(guess) for guess in own], cls)
    for values in guesses:
        free = {
            key: _step(cls, key, value, scales.get(setting_of(key), 1.0), suggested is not None)
            for key, value in values.items()
            if isinstance(value, float)
        }
        term = HypothesisTerm(name, cls, values, free)
        if term.placed() is not None:
            yield term


def _step(cls: type[Any], name: str, value: float, scale: float, is_suggested: bool) -> float:
    """A change that matters of a parameter that begins at a value.

    A guess of a class is itself the least that matters, but for points of a curve, which have a short way to
    go. What captures suggest may be many times that. One coefficient of a series may be next to nothing where
    it is uncertain by more.
    """
    distance = abs(value - (neutral_value(cls, name) or 0.0))
    if not distance:
        return scale
    if name.startswith("knots."):
        return min(distance, KNOT_STEP)
    if series_of(cls, name):
        return max(scale, SUGGESTED_STEP * distance)
    return min(distance, max(scale, SUGGESTED_STEP * distance)) if is_suggested else distance


def series_of(cls: type[Any], name: str) -> tuple[str, ...]:
    """The coefficients of rising powers that a parameter is one of; none where it is no such."""
    return next((tuple(each) for each in optional(cls, EffectBase, "series") if name in each), ())


def _scales(guesses: Sequence[Mapping[str, Any]], cls: type[Any]) -> dict[str, float]:
    """The least distance from neutral at which a guess stands, for those that begin at it: 0 degrees, say."""
    scales: dict[str, float] = {}
    for guess in guesses:
        for key, value in guess.items():
            if isinstance(value, float) and (distance := abs(value - (neutral_value(cls, key) or 0.0))):
                scales[key] = min(distance, scales.get(key, distance))
    return scales


def _flattened(guess: Mapping[str, Any]) -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, value in guess.items():
        if key == "matrix":
            flat |= {f"matrix.{r}.{c}": float(value[r][c]) for r in range(3) for c in range(3) if r != c}
        elif key == "knots" and value is not None:
            flat |= {f"knots.{round(1000 * x)}": float(y) for x, y in value[1:-1]}
        else:
            flat[key] = value
    return flat


def step(cls: type[Any], name: str) -> float:
    """A change of a parameter that matters: a twentieth of its bounds' span, at most a tenth of its scale."""
    field = cls.Config.model_fields[name]
    bounds = [getattr(m, key) for m in field.metadata for key in ("ge", "gt", "le", "lt") if hasattr(m, key)]
    neutral = float(cls.neutral[name])
    if len(bounds) == 2:
        return min(abs(bounds[1] - bounds[0]) / 20, max(abs(neutral), 1.0) / 10)
    return max(abs(neutral), 1.0) / 10
