"""What is suggested for a name that is not known."""

from __future__ import annotations

import pytest

from tacos_framework.errors import did_you_mean
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Scenario
from tacos_framework.settings import also_called

LIGHT = tuple(Scenario.model_fields)


@pytest.mark.parametrize(
    ("given", "known", "suggested"),
    [
        ("gain", LIGHT, "gain_db"),
        ("ISO", LIGHT, "gain_db"),
        ("shutter_speed", LIGHT, "exposure_ms"),
        ("aperture", LIGHT, "f_number"),
        ("lux", LIGHT, "illumination_lux"),
        ("flea", ("flea3_imx172", "other"), "flea3_imx172"),
        ("workers", ("worker", "iso"), "worker"),
        ("task.orb", ("task.sgbm", "task.orb-features"), "task.orb-features"),
        ("task.sbgm", ("task.sgbm", "task.orb-features"), "task.sgbm"),
        ("mt9p031", ("MT9P031", "MT9V032"), "MT9P031"),
        ("tsk.sgbm", ("task.sgbm", "task.orb-features"), "task.sgbm"),
    ],
)
def test_by_letters_or_by_meaning(given: str, known: tuple[str, ...], suggested: str) -> None:
    assert did_you_mean(given, known, also_called(Scenario)) == f"Did you mean {suggested!r}?"


def test_names_that_share_as_much_are_all_told() -> None:
    effects = ("effect.motion-blur", "effect.lens-blur", "effect.flare")
    assert did_you_mean("effect.blur", effects) == "Did you mean 'effect.lens-blur' or 'effect.motion-blur'?"


@pytest.mark.parametrize(
    ("given", "known"),
    [("optimizer.ga", ("optimizer.cma-es", "optimizer.ppo")), ("roll_deg", ("pan_deg", "tilt_deg", "x"))],
)
def test_letters_and_units_alike_by_chance_are_no_suggestion(given: str, known: tuple[str, ...]) -> None:
    assert did_you_mean(given, known) == f"Known names: {', '.join(known)}."


def test_a_word_nobody_uses_gets_the_names_there_are() -> None:
    assert did_you_mean("zzz", ("b", "a")) == "Known names: a, b."


@pytest.mark.parametrize(
    ("rig", "given", "suggested"),
    [
        ("stereo", "fov", "hfov_deg"),
        ("stereo", "zoom", "focal_length_mm"),
        ("monocular", "fov", "focal_length_mm"),
    ],
)
def test_a_field_of_view_is_one_where_the_rig_has_it(rig: str, given: str, suggested: str) -> None:
    variables = Plugins.discover().resolve(f"rig.{rig}").Variables
    assert (
        did_you_mean(given, variables.model_fields, also_called(variables)) == f"Did you mean {suggested!r}?"
    )


def test_components_say_what_others_call_their_settings() -> None:
    plugins = Plugins.discover()
    random = plugins.resolve("optimizer.random").Config
    assert did_you_mean("trials", random.model_fields, also_called(random)) == "Did you mean 'evaluations'?"


def test_no_other_word_is_a_setting_itself_and_all_are_in_lower_case() -> None:
    plugins = Plugins.discover()
    usable = [each.component.use for each in plugins if not each.component.missing_packages()]
    classes = [plugins.resolve(use) for use in usable]
    settings = [Scenario, *(c for cls in classes for c in (cls.Config, getattr(cls, "Variables", None)) if c)]
    for each in settings:
        for words in also_called(each).values():
            assert [word for word in words if word != word.lower() or word in each.model_fields] == []
