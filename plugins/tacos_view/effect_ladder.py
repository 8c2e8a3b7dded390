"""One frame with an effect at rising severities."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from tacos_framework import EffectBase, Fault, FrameBatch, Plugins, UserError, check, optional
from tacos_framework.formation import EpisodeDraws, ImageFormation, PlacedEffect
from tacos_view.pictures import Picture, shown_frame
from tacos_view.setup import PURPOSE, RenderSetup

OF_THE_FIELD = (1.0, 2.0, 4.0)
"""Times the severity that an effect declares to meet in the field, its first initial guess."""

OF_THE_USER = (0.25, 0.5, 1.0)
"""Shares of the severity that a user gives."""


@dataclass(frozen=True, eq=False)
class Step:
    settings: Mapping[str, Any]  # those of the effect; none where it is off
    frame: Picture  # what the camera delivers
    difference: Picture  # what the effect has changed, amplified alike on all rungs; grey is no change

    @property
    def label(self) -> str:
        said = [f"{name} {_shown(value)}" for name, value in self.settings.items()]
        return ", ".join(said) or "off"


@dataclass(frozen=True, eq=False)
class EffectLadder:
    """The rungs, the mildest first, and how far differences were amplified [1]."""

    use: str
    steps: tuple[Step, ...]
    amplification: float


def effect_ladder(
    setup: RenderSetup, name: str, settings: Mapping[str, Any], plugins: Plugins, *, seed: int | None = None
) -> EffectLadder:
    """One frame with an effect at rising severities, with the same noise throughout.

    - `name`: the effect, with or without ``effect.``.
    - `settings`: the severest settings; where empty, the effect's own guess of what is met in the field leads
      on.
    - `seed`: which world; the recipe's if None.

    Raises UserError when there is no such effect, its settings are wrong, or it declares no severity and none
    is given.
    """
    use = name if name.startswith("effect.") else f"effect.{name}"
    cls = plugins.resolve(use, "effect")
    rungs = [{}, *_severities(use, cls, settings)]
    (scene,) = setup.along_the_trip(1, seed=seed)
    draws = setup.plan.recipe.seed if seed is None else seed
    frames = [_formed(setup, scene, use, cls, each, draws) for each in rungs]
    span = scene.white_level_dn - scene.black_level_dn
    changes = [(frame.astype(np.float64) - frames[0]) / span for frame in frames]
    largest = np.percentile(np.abs(changes[-1]), 99) or np.abs(changes[-1]).max() or 1.0
    amplification = max(1.0, 0.5 / float(largest))
    levels = scene.black_level_dn, scene.white_level_dn
    steps = [
        Step(each, shown_frame(frame, *levels, coded=scene.coded), _shown_difference(change * amplification))
        for each, frame, change in zip(rungs, frames, changes, strict=True)
    ]
    return EffectLadder(use, tuple(steps), amplification)


def _severities(use: str, cls: type[Any], given: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Settings from mild to severe; rungs that the effect rules out are left out."""
    top = dict(given)
    factors = OF_THE_USER
    if top:
        rungs = _listed(use, cls, top)
        if rungs:
            yield from rungs
            return
    else:
        guesses = optional(cls, EffectBase, "initial_guesses") or ()
        if not guesses:
            what = f"{use} does not say how severe it is met in the field"
            raise UserError(Fault(use, what, "a severity", "Give one: --set SETTING=VALUE."))
        top, factors = dict(guesses[0]), OF_THE_FIELD
    before: dict[str, Any] = {}
    for factor in factors:
        rung = {key: _between(cls.neutral.get(key), value, factor) for key, value in top.items()}
        try:
            cls.Config.model_validate(rung)
        except ValidationError:
            continue
        if rung != before:  # a setting that is off where it is not given, as a focus, has nothing between
            yield rung
        before = rung


def _listed(use: str, cls: type[Any], given: Mapping[str, Any]) -> list[dict[str, Any]]:
    """A rung for each value where one setting is given several; none where each has one.

    Raises UserError with what is wrong with the settings, one list among them or not.
    """

    def where(path: Sequence[str | int]) -> str:
        return ".".join(map(str, (use, *path)))

    _, faults, _ = check(cls.Config, dict(given), where)
    lists = [key for key, value in given.items() if isinstance(value, list) and value]
    if not faults:
        return []
    if len(lists) != 1:
        raise UserError(faults)
    (several,) = lists
    rungs = [{**given, several: value} for value in given[several]]
    faults = [fault for rung in rungs for fault in check(cls.Config, rung, where)[1]]
    if faults:
        raise UserError(faults)
    return rungs


def _between(neutral: Any, value: Any, factor: float) -> Any:
    """A setting at a multiple of its way from neutral; words and switches as they are."""
    if any(isinstance(each, bool) or not isinstance(each, int | float) for each in (neutral, value)):
        return value
    moved = neutral + factor * (value - neutral)
    return round(moved) if isinstance(value, int) else float(moved)


def _formed(
    setup: RenderSetup, scene: FrameBatch, use: str, cls: type[Any], settings: Mapping[str, Any], seed: int
) -> NDArray[np.unsignedinteger]:
    own = [PlacedEffect(use, use, cls, cls.Config.model_validate(settings))] if settings else []
    draws = EpisodeDraws(seed, (PURPOSE,))
    lit = ImageFormation(setup.exposure, own).light(scene.capture, draws)
    formed = ImageFormation(setup.exposure, [*setup.effects, *own]).expose(lit, setup.sensor, draws)
    return formed.images[0][0]


def _shown_difference(change: NDArray[np.float64]) -> Picture:
    grey = np.clip(127.5 + 127.5 * change, 0, 255).astype(np.uint8)
    return np.repeat(grey, 3, axis=-1) if grey.shape[-1] == 1 else grey


def _shown(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
