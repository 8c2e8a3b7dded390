"""Exposure times in tables beside photographs and in names, as people and programs write them."""

from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image

from tacos_gap.photographs.importing import Imported, import_photographs
from tests.gap.photographs.test_caps_and_walls import VIEW, save

TIMES_MS = (2.0, 8.0, 32.0, 128.0)


def bracket(folder: Path, names: list[str]) -> None:
    """A view that gets brighter with the time of each file."""
    for seed, (name, time_ms) in enumerate(zip(names, TIMES_MS, strict=True)):
        save(folder, name, 2 + 1.8 * time_ms * VIEW, seed)


def times_ms(found: Imported) -> list[float | None]:
    timed = sorted((entry["real"][0].rpartition("/")[2], entry.get("exposure_ms")) for entry in found.entries)
    return [time for _, time in timed]


@pytest.mark.parametrize(
    ("table", "lines", "guessed"),
    [
        ("times.csv", ["file,exposure_ms", "{0}.png,2", "{1}.png,8", "{2}.png,32", "{3}.png,128"], False),
        (
            "log.csv",
            [
                "frame;name;ISO;shutter [us]",
                *(f"{k};{{{k}}};100;{int(t * 1e3)}" for k, t in enumerate(TIMES_MS)),
            ],
            False,
        ),
        (
            "a.txt",
            ["# name time", "{0}.png 1/500 s", "{1}.png 1/125 s", "{2}.png 32ms", "{3}.png 128 ms"],
            False,
        ),
        (
            "image_list.txt",
            [
                "# Filename 1/shutter_speed f/stop gain(db)",
                "{0}.png 500 8 0",
                "{1}.png 125 8 0",
                "{2}.png 31.25 8 0",
                "{3}.png 7.8125 8 0",
            ],
            True,
        ),
        ("list.txt", ["{0}.png 0.002", "{1}.png 0.008", "{2}.png 0.032", "{3}.png 0.128"], True),
        ("t.txt", ["hdr/{0}.png 2000", "hdr/{1}.png 8000", "hdr/{2}.png 32000", "hdr/{3}.png 128000"], True),
        ("exposures.txt", ["0.002", "0.008", "0.032", "0.128"], True),
        ("exposure_times.txt", ["1/500", "1/125", "1/31.25", "1/7.8125"], True),
    ],
)
def test_a_table_beside_the_pictures_tells_their_times(tmp_path, table, lines, guessed):
    names = ["p8", "p9", "p10", "p11"]
    bracket(tmp_path / "in", names)
    (tmp_path / "in" / table).write_text("\n".join(lines).format(*names) + "\n")
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    by_name = {e["real"][0].rpartition("/")[2]: e["exposure_ms"] for e in found.entries}
    assert [by_name[f"{name}.png"] for name in names] == pytest.approx(TIMES_MS)
    assert {entry["kind"] for entry in found.entries} == {"bracket"}
    assert any(table in guess.text for guess in found.guesses) == guessed
    assert not any("Passed over" in doubt for doubt in found.doubts)


@pytest.mark.parametrize(
    ("table", "lines"),
    [
        ("times.csv", ["file,taken_ns", "{0}.png,1695668703498682368", "{1}.png,1695668703772763904"]),
        ("notes.txt", ["bought 2 lamps", "{0}.png is nice"]),
        ("sizes.txt", ["9", "7", "4", "1"]),
        ("copy.txt", ["4 pictures"]),
    ],
)
def test_tables_of_other_things_are_not_taken_for_times(tmp_path, table, lines):
    names = ["a", "b", "c", "d"]
    bracket(tmp_path / "in", names)
    (tmp_path / "in" / table).write_text("\n".join(lines).format(*names) + "\n")
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert not any("exposure_ms" in entry for entry in found.entries)


def test_loose_fractions_in_names_are_times_where_brightness_agrees(tmp_path):
    bracket(tmp_path / "in", ["a_1_500", "a_1_125", "a_1_32", "a_1_8"])
    names = ["a_1_500", "a_1_250", "a_1_125", "a_1_60"]
    bracket(tmp_path / "loose", names)
    found = import_photographs([tmp_path / "loose"], tmp_path / "out")
    by_name = {e["real"][0].rpartition("/")[2]: e["exposure_ms"] for e in found.entries}
    assert [by_name[f"{name}.png"] for name in names] == pytest.approx([2, 4, 8, 1000 / 60], rel=1e-4)
    assert any("Names are taken for shutter times" in guess.text for guess in found.guesses)
    bracket(tmp_path / "numbers", names[::-1])
    assert not any(
        "exposure_ms" in e for e in import_photographs([tmp_path / "numbers"], tmp_path / "other").entries
    )


@pytest.mark.parametrize(
    ("names", "expected_ms"),
    [
        ([f"view_ExposureTime{t * 1e3:g}_Gain4" for t in TIMES_MS], TIMES_MS),
        ([f"{k}_exp_{t:g}" for k, t in enumerate(TIMES_MS)], TIMES_MS),
        ([f"shutter{t / 1e3:g} ({k})" for k, t in enumerate(TIMES_MS)], TIMES_MS),
        ([f"scene_exp{k}" for k in (1, 2, 3, 4)], [None] * 4),
    ],
)
def test_times_without_a_unit_count_what_cameras_expose_for(tmp_path, names, expected_ms):
    bracket(tmp_path / "in", names)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    by_name = {e["real"][0].rpartition("/")[2]: e.get("exposure_ms") for e in found.entries}
    assert [by_name[f"{name}.png"] for name in names] == pytest.approx(expected_ms)
    marked = [guess.text for guess in found.guesses if "Names are taken for shutter times" in guess.text]
    assert len(marked) == (expected_ms[0] is not None)


def test_a_table_that_contradicts_the_names_is_doubted_and_taken(tmp_path):
    names = [f"a_{t:g}ms" for t in (1, 2, 3, 4)]
    bracket(tmp_path / "in", names)
    rows = [f"{name}.png,{time}" for name, time in zip(names, TIMES_MS, strict=True)]
    (tmp_path / "in/times.csv").write_text("\n".join(["name,exposure (ms)", *rows]))
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert times_ms(found) == list(TIMES_MS)
    assert any(
        doubt.startswith("times.csv says another exposure time than a_1ms.png") for doubt in found.doubts
    )


def test_names_that_contradict_what_the_camera_wrote_are_doubted(tmp_path):
    names = ["a_2ms_ISO100", "b_8ms_ISO200", "c_1-30s", "d_64ms_f2.8"]
    bracket(tmp_path / "in", names)
    for name, time_ms in zip(names, TIMES_MS, strict=True):
        with Image.open(tmp_path / "in" / f"{name}.png") as image:
            tags = Image.Exif()
            tags[0x0110] = "Camera"
            own = tags.get_ifd(0x8769)
            own |= {0x829A: time_ms / 1e3, 0x8827: 100, 0x829D: 2.8}
            image.save(tmp_path / "in" / f"{name}.png", exif=tags)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert times_ms(found) == pytest.approx(list(TIMES_MS))
    said = [doubt for doubt in found.doubts if "the name says another" in doubt]
    assert said == [
        "d_64ms_f2.8.png: the name says another exposure time than the camera wrote (64 and 128 ms); that of "
        "the camera is taken.",
        "b_8ms_ISO200.png: the name says another ISO speed than the camera wrote (200 and 100); that of the "
        "camera is taken.",
    ]
