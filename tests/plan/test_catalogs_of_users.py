"""Catalogs of one's own: where their paths start, what a rig needs of them, what ``--check`` says of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tacos_framework.cli import run_main
from tacos_framework.errors import UserError
from tacos_framework.plan import make_plan
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import load_recipe
from tacos_framework.variables import CatalogChoice

SENSORS = """name,width_px,height_px,pixel_um
small,640,480,3.75
large,2048,1536,3.45
unknown,1280,960,
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder a command is typed in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_path_on_the_command_line_starts_where_it_is_typed(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "mine.csv").write_text(SENSORS)
    assert run_main(["headset_quick", "--set", "design.sensor.from=mine.csv", "--check"]) == 0
    said = capsys.readouterr().out
    assert (
        "1 of 3 parts of mine cannot be chosen, width_mm and height_mm and pixel_um unknown: unknown." in said
    )


def test_a_missing_column_is_told_with_the_catalog_and_the_option(here: Path) -> None:
    (here / "mine.csv").write_text("name,width_mm,height_mm,pixel_um\na,6.2,4.6,1.55\n")
    recipe = load_recipe("headset_quick", sets={"design.sensor.from": "mine.csv"})
    with pytest.raises(UserError) as caught:
        make_plan(recipe, Plugins.discover())
    assert [(fault.where, fault.what) for fault in caught.value.faults] == [
        ("--set design.sensor.from", f"the catalog mine has no column {name!r}, which rig.monocular needs")
        for name in ("width_px", "height_px")
    ]


def test_a_slip_of_the_unit_is_doubted_by_check(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "mine.csv").write_text(SENSORS.replace("3.45", "0.00345"))
    run_main(["headset_quick", "--set", "design.sensor.from=mine.csv", "--check"])
    assert "large: pixel_um is 0.00345; parts have 0.4 to 60" in capsys.readouterr().out


def test_settings_that_clash_are_told_at_their_own_key(here: Path) -> None:
    recipe = load_recipe("headset_day", sets={"optimizer.keep": 20})
    with pytest.raises(UserError) as caught:
        make_plan(recipe, Plugins.discover())
    (fault,) = caught.value.faults
    assert (fault.where, fault.what) == ("--set optimizer.keep", "keep=20 of a population of 10")


def test_parts_may_be_named_that_alone_are_chosen_from() -> None:
    recipe = load_recipe("headset_quick", sets={"design.sensor.only": ["IMX250", "AR0134", "IMX250"]})
    sensor = next(v for v in make_plan(recipe, Plugins.discover()).space.variables if v.name == "sensor")
    assert isinstance(sensor, CatalogChoice)
    assert (
        {row.name for row in sensor.catalog.rows} == {row.name for row in sensor.rows} == {"IMX250", "AR0134"}
    )


@pytest.mark.parametrize(
    ("only", "said"), [(["IMX25"], "has no part 'IMX25'. Did you mean 'IMX250'?"), ([], "has no parts")]
)
def test_a_part_named_that_is_not_there_is_told(only: list[str], said: str) -> None:
    recipe = load_recipe("headset_quick", sets={"design.sensor.only": only})
    with pytest.raises(UserError) as caught:
        make_plan(recipe, Plugins.discover())
    (fault,) = caught.value.faults
    assert fault.where == "--set design.sensor.only"
    assert said in str(fault)
