"""``tacos settings``: what a component takes and gives, in the terminal."""

from __future__ import annotations

import pytest

from tacos_framework.cli.tacos import main
from tacos_framework.recipe import Recipe
from tacos_plugins.authoring.reference.in_terminal import settings_text


def test_settings_are_shown_with_unit_bounds_default_and_meaning(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["settings", "rig.monocular"]) == 0
    text = capsys.readouterr().out
    assert "derived quantities: hfov_deg [deg]" in text
    assert "pitch_deg            number, ≥ -90, ≤ 90 [deg]; default 0.0\n        Tilt of the camera" in text
    assert "sensor               *SensorPart*; must be given" in text


def test_keys_of_a_recipe_are_shown() -> None:
    text = settings_text("recipe", width=80)
    assert {key for key in Recipe.model_fields if f"\n  {key} " not in f"\n{text}"} == set()


@pytest.mark.parametrize("width", [60, 110])
def test_lines_fit_the_terminal(width: int) -> None:
    assert max(map(len, settings_text("task.fiducials", width=width).splitlines())) <= width


def test_a_name_that_is_not_there_is_told_with_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["settings", "optimizer.randm"]) == 2
    assert "Did you mean 'optimizer.random'?" in capsys.readouterr().err
