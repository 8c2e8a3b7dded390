"""Image formation in a line: a sensor or an effect on captures and frames, as a study has them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from tacos_framework.formation import EpisodeDraws, ImageFormation, PlacedEffect, PlacedSensor
from tacos_framework.testing.samples import sample_exposure
from tacos_framework.values import Capture, Exposure, FrameBatch


def placed(effect: type[Any], **settings: Any) -> PlacedEffect:
    """An effect with settings, as a recipe lists it."""
    name = effect.__name__.lower()
    return PlacedEffect(f"effect.{name}", name, effect, effect.Config(**settings))


def with_effect(
    image: Capture | FrameBatch, effect: PlacedEffect, *, exposure: Exposure | None = None, seed: int = 1
) -> Any:
    """A capture or frames with an effect, of the same type; the very object where it is off.

    Effects of the stages pixel and readout wait in `Capture.pending` for `expose`.
    """
    formation = ImageFormation(exposure or sample_exposure())
    return formation.with_effect(image, effect, EpisodeDraws(seed, ("sample",)))


def expose(
    sensor: Any,
    capture: Capture,
    *,
    effects: Iterable[PlacedEffect] = (),
    exposure: Exposure | None = None,
    seed: int = 1,
) -> FrameBatch:
    """Frames of a capture by a sensor, with effects of any stage at their places.

    - `capture`: what a renderer gave.
    - `effects`: see `placed`.
    - `exposure`: that of `sample_exposure` unless given.
    - `seed`: of the study; frames are drawn by their number in the episode.
    """
    formation = ImageFormation(exposure or sample_exposure(), tuple(effects))
    draws = EpisodeDraws(seed, ("sample",))
    placed_sensor = PlacedSensor("sensor.sample", "frames", sensor)
    return formation.expose(formation.light(capture, draws), placed_sensor, draws)
