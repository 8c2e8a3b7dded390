"""``tacos catalog``: what is known of parts and cameras, and what is not."""

from __future__ import annotations

import pytest

from tacos_framework.cli.tacos import main


def said(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(["catalog", *words]) == 0
    return capsys.readouterr().out


def test_cameras_are_listed_with_the_columns_that_decide(capsys) -> None:
    text = said(capsys, "cameras")
    heading = next(line for line in text.splitlines() if line.startswith("name"))
    assert heading.split()[:4] == ["name", "kind", "sensor", "width_px"]
    assert {"price_usd", "mass_g", "baseline_mm", "shutter"} <= set(heading.split())
    assert "row_time_us" not in heading
    assert sum(line.startswith(("luxonis_", "basler_")) for line in text.splitlines()) > 40
    assert "flea3: FLIR Flea3 (rig.monocular)" in text


def test_all_that_is_known_of_a_part_is_shown_with_its_source(capsys) -> None:
    text = said(capsys, "cameras", "raspberry_pi_camera_module_v2")
    row_time = next(line for line in text.splitlines() if line.startswith("row_time_us"))
    assert row_time.split()[1:4] == ["18.9", "driver", "code"]
    assert row_time.endswith("drivers/media/i2c/imx219.c")
    assert "min_exposure_us         75.6~" in text
    unknown = next(line for line in text.splitlines() if line.startswith("Unknown: "))
    assert "power_w" in unknown
    assert "* The price has no date." in text
    assert "note: 41 frames per second at 1640x1232." in text


def test_cameras_of_the_paper_are_shown_by_what_they_fix(capsys) -> None:
    assert "rig.stereo" in said(capsys, "cameras", "zed_2i")


def test_a_part_that_is_not_there_is_told_with_the_nearest(capsys) -> None:
    assert main(["catalog", "image_sensors", "IMX21"]) == 2
    assert "catalog image_sensors has no part 'IMX21'. Did you mean 'IMX219'?" in capsys.readouterr().err
