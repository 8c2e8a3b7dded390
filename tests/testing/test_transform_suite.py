"""The suite for transforms passes a right one, and finds what is wrong with others."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import pytest
import toy_plugin

from tacos_framework.settings import Settings
from tacos_framework.testing import TransformConformance
from tacos_framework.values import FrameBatch


class TestMean(TransformConformance):
    component = toy_plugin.Mean
    config: ClassVar[Mapping[str, Any]] = {"gain": 1.0}


class Doubling:
    """Right but for what a subclass changes."""

    class Config(Settings):
        pass

    def __init__(self, config: Config) -> None:
        self.calls = 0

    def transform(self, frames: FrameBatch, *, memory: dict[str, Any]) -> toy_plugin.Levels:
        return toy_plugin.Levels(frames.episode, (2.0,), (float(frames.images[0].mean()),))


class Counts(Doubling):
    def transform(self, frames: FrameBatch, *, memory: dict[str, Any]) -> toy_plugin.Levels:
        self.calls += 1
        return toy_plugin.Levels(frames.episode, (float(self.calls),), ())


class Rolls(Doubling):
    def transform(self, frames: FrameBatch, *, memory: dict[str, Any]) -> toy_plugin.Levels:
        return toy_plugin.Levels(frames.episode, (float(np.random.default_rng().random()),), ())


class Lies(Doubling):
    def transform(self, frames: FrameBatch, *, memory: dict[str, Any]) -> toy_plugin.Levels:
        return frames  # type: ignore[return-value]


class Scribbles(Doubling):
    def transform(self, frames: FrameBatch, *, memory: dict[str, Any]) -> toy_plugin.Levels:
        frames.images[0].base[:] = 0
        return super().transform(frames, memory=memory)


class Wants(Doubling):
    def transform(self, frames: FrameBatch, *, weather: str) -> toy_plugin.Levels:
        return toy_plugin.Levels(frames.episode, (), ())


class WantsFour(Doubling):
    def transform(self, frames: FrameBatch) -> toy_plugin.Levels:
        return toy_plugin.Levels(frames.episode, (float(frames.images[0][3].mean()),), ())


@pytest.mark.parametrize(
    ("component", "test"),
    [
        (Counts, "test_it_keeps_nothing_of_its_own_between_calls"),
        (Rolls, "test_equal_inputs_and_generators_give_equal_outputs"),
        (Lies, "test_it_gives_what_it_says"),
        (Scribbles, "test_it_leaves_its_inputs_as_they_were"),
        (Wants, "test_its_ports_have_types"),
        (WantsFour, "test_it_takes_frames_one_by_one"),
    ],
)
def test_what_is_wrong_is_found(component: type[Any], test: str) -> None:
    suite = type("Suite", (TransformConformance,), {"component": component})()
    right = type("Suite", (TransformConformance,), {"component": Doubling})()
    getattr(right, test)()
    with pytest.raises((AssertionError, IndexError)):
        getattr(suite, test)()
