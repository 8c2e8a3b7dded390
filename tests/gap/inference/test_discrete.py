"""Settings that no slope leads to: whole numbers and words, found by search."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_framework.settings import Settings, setting
from tacos_gap.evidence import Label
from tacos_gap.hypotheses.parameters import HypothesisTerm
from tacos_gap.inference.codec import codec_of_files
from tacos_gap.inference.discrete import searched, whole_numbers, words_of
from tacos_gap.inference.problem import Problem
from tacos_gap.inference.screening import ScreeningDirection


class Coder:
    """An effect with a grade from 1 to 100, off at 100, in two ways."""

    class Config(Settings):
        grade: int = setting(100, help="Grade.", ge=1, le=100)
        way: Literal["even", "odd"] = setting("even", help="Way.")

    stage: ClassVar = "codec"
    neutral: ClassVar = {"grade": 100}
    initial_guesses: ClassVar = ({"grade": 90}, {"grade": 70}, {"grade": 40})

    def __init__(self, config: Config) -> None:
        self.config = config


class Coded:
    """Evidence of one number for the grade and one for the way, of the stage codec or of another."""

    def __init__(self, grade: int, way: str, stage: str = "codec"):
        self.grade, self.way = grade, way
        self.labels = [Label("flat", "flat", name, stage, {}) for name in ("grade", "way")]
        self.null_replicates = np.random.default_rng(0).normal(size=(16, 2))

    def residual(self, effects: Sequence[Any], draws: int = 1) -> np.ndarray:
        grade, way = (effects[0].config.grade, effects[0].config.way) if effects else (100, "even")
        return np.array([self.grade - grade, 8.0 * (way != self.way)])


def begun(grade: int) -> tuple[HypothesisTerm, ...]:
    return (HypothesisTerm("coder", Coder, {"grade": grade}, {}),)


@settings(max_examples=30, deadline=None)
@given(st.integers(26, 99), st.sampled_from(["even", "odd"]))
def test_the_grade_and_the_way_are_found_exactly_from_the_nearest_guess(grade, way):
    of = Problem([Coded(grade, way)])  # type: ignore[list-item]
    nearest = min((90, 70, 40), key=lambda guess: abs(guess - grade))
    found = searched(of, begun(nearest))[0].values
    assert found["grade"] == grade
    assert found.get("way", "even") == way


def test_bounds_of_a_whole_number_are_kept_and_few_of_them_are_tried():
    of = Problem([Coded(1, "even")])  # type: ignore[list-item]
    assert searched(of, begun(12))[0].values["grade"] >= 1
    assert of.simulations < 40


def test_what_there_is_to_search_is_what_the_effect_declares():
    (term,) = begun(70)
    assert whole_numbers(term) == {"grade": 16}  # the next guess is 20 away
    assert words_of(term) == {"way": ("even", "odd")}


@pytest.mark.parametrize(("stage", "seen"), [("codec", True), ("readout", False)])
def test_a_codec_is_taken_as_given_where_its_own_traces_show_it(stage, seen):
    of = Problem([Coded(66, "odd", stage)])  # type: ignore[list-item]
    directions = {"coder": [ScreeningDirection(begun(70)[0], np.array([-30.0, 0.0]))]}
    found = codec_of_files(of, directions)
    assert [term.name for term in found] == (["coder"] if seen else [])
    if seen:
        assert found[0].values == {"grade": 66, "way": "odd"}
