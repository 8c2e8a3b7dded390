"""Where catalogs, cameras and calibrations are found: beside the recipe, by path, or among those shipped."""

from __future__ import annotations

from pathlib import Path

import pytest

from tacos_framework.catalog import find_catalog, load_cameras
from tacos_framework.errors import UserError
from tacos_framework.packaged_resources import shipped_folder
from tacos_plugins.sensors.calibration import load_calibration
from tests.catalog.catalog_files import TABLE, write


def test_paths_of_a_recipe_start_beside_it_and_may_lead_anywhere(tmp_path: Path) -> None:
    folder = tmp_path / "recipes"
    (folder / "parts").mkdir(parents=True)
    write(tmp_path, TABLE, "outside.csv")
    write(folder / "parts", TABLE, "mine.csv")
    (folder / "link.csv").symlink_to(tmp_path / "outside.csv")
    for name in ("parts/mine.csv", "../outside.csv", str(tmp_path / "outside.csv"), "link.csv"):
        assert len(find_catalog(name, folder).rows) == 3
    assert len(find_catalog(tmp_path / "outside.csv").rows) == 3


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("image_sensor", r"no catalog of this name is shipped[\s\S]*Did you mean 'image_sensors'"),
        ("mine", r"Write 'mine.csv' to use the file beside the recipe"),
        ("missing.yaml", "there is no such catalog"),
        (".", "there is no such catalog"),
        ("", "there is no such catalog"),
        ("a\0.yaml", "NUL"),
    ],
)
def test_catalogs_that_are_not_there(tmp_path: Path, name: str, message: str) -> None:
    write(tmp_path, TABLE, "mine.csv")
    with pytest.raises(UserError, match=message):
        find_catalog(name, tmp_path)


def test_shipped_files_are_found_from_any_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert len(find_catalog("image_sensors").rows) == 43
    assert shipped_folder("recipes").is_absolute()
    assert load_calibration("flea3_imx172").bit_depth == 8


def test_all_unknown_cameras_are_told() -> None:
    with pytest.raises(UserError) as caught:
        load_cameras(["flea", "zed_2i", "basler_drat", "zed_2i"])
    assert [(fault.where, fault.remedy) for fault in caught.value.faults] == [
        ("flea", "Did you mean 'flea3'?"),
        ("basler_drat", "Did you mean 'basler_dart'?"),
        ("zed_2i", "Remove one."),
    ]


def test_cameras_of_users(tmp_path: Path) -> None:
    camera = "{title: T, maker: M, rig: rig.stereo, fixes: {baseline_m: 1}, sources: [me]}"
    write(tmp_path, f"cameras:\n  mine: {camera}\n", "cams.yaml")
    [found] = load_cameras(["mine"], "cams.yaml", tmp_path)
    assert (found.name, found.rig, found.fixes) == ("mine", "rig.stereo", {"baseline_m": 1})
    write(
        tmp_path,
        "cameras:\n  mine: {title: T, maker: M, rig: stereo, fixes: {}, source: [me]}\n",
        "cams.yaml",
    )
    with pytest.raises(UserError) as caught:
        load_cameras(["mine"], "cams.yaml", tmp_path)
    said = str(caught.value)
    assert all(text in said for text in ("cams.yaml:2:", "rig", "fixes", "'cameras.mine.sources' is missing"))


def test_calibrations_of_users(tmp_path: Path) -> None:
    text = (shipped_folder("catalogs") / "noise" / "flea3_imx172.yaml").read_text()
    write(tmp_path, text.replace("gain_db: 15", "gain_db: 3"), "mine.yaml")
    assert load_calibration("mine.yaml", tmp_path).gain_db == 3
    write(tmp_path, text.replace("[1.82, 0.91, 3.2]", "[1.82, 0.91]"), "mine.yaml")
    with pytest.raises(
        UserError, match="photon_dn has 3 channels and thermal_dn2 2; 3 of each, or 1 of each"
    ):
        load_calibration("mine.yaml", tmp_path)
    write(tmp_path, text.replace("0.91", "-0.91").replace("pixel_um: 1.55", "pixel_um: 0"), "mine.yaml")
    with pytest.raises(UserError) as caught:
        load_calibration("mine.yaml", tmp_path)
    assert len(caught.value.faults) == 2
