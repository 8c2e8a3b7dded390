"""What is suggested for a name that is not known."""

from __future__ import annotations

import pytest

from tacos_framework.errors import did_you_mean
from tacos_framework.recipe import Scenario
from tacos_framework.synonyms import SYNONYMS

LIGHT = tuple(Scenario.model_fields)


@pytest.mark.parametrize(
    ("given", "known", "suggested"),
    [
        ("gain", LIGHT, "gain_db"),
        ("ISO", LIGHT, "gain_db"),
        ("shutter_speed", LIGHT, "exposure_ms"),
        ("aperture", LIGHT, "f_number"),
        ("lux", LIGHT, "illumination_lux"),
        ("jobs", ("workers", "timeout_s"), "workers"),
        ("flea", ("flea3_imx172", "other"), "flea3_imx172"),
        ("workers", ("worker", "iso"), "worker"),
    ],
)
def test_by_letters_or_by_meaning(given: str, known: tuple[str, ...], suggested: str) -> None:
    assert did_you_mean(given, known) == f"Did you mean {suggested!r}?"


def test_a_word_nobody_uses_gets_the_names_there_are() -> None:
    assert did_you_mean("zzz", ("b", "a")) == "Known names: a, b."


def test_synonyms_are_looked_up_in_lower_case() -> None:
    assert all(word == word.lower() for word in SYNONYMS)
