"""JSON beside photographs, as camera software and programs of their owners write it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tacos_gap.photographs.importing import import_photographs
from tests.gap.photographs.test_exposure_times import TIMES_MS, bracket, times_ms

STEMS = [f"view{k}" for k in range(4)]
NAMES = [f"{stem}.png" for stem in STEMS]


def libcamera(time_ms: float) -> dict[str, Any]:
    """As ``rpicam-still --metadata`` and picamera2 write it."""
    return {
        "SensorTimestamp": 1_200_345_000,
        "FrameDuration": 150_000,
        "SensorBlackLevels": [4096, 4096, 4096, 4096],
        "ColourGains": [2.1, 1.7],
        "ExposureTime": round(time_ms * 1e3),
        "AnalogueGain": 1.0,
        "DigitalGain": 1.0,
        "Lux": 61.2,
    }


def one_file_each(folder: Path) -> None:
    for name, time_ms in zip(NAMES, TIMES_MS, strict=True):
        (folder / name).with_suffix(".json").write_text(json.dumps(libcamera(time_ms)))


def of_all(content: Any) -> Callable[[Path], int]:
    return lambda folder: (folder / "metadata.json").write_text(json.dumps(content))


WITH_TIMES = list(zip(NAMES, TIMES_MS, strict=True))


@pytest.mark.parametrize(
    "written",
    [
        one_file_each,
        of_all({name: libcamera(time_ms) for name, time_ms in WITH_TIMES}),
        of_all([{"SourceFile": f"./{name}", "ExposureTime": t / 1e3, "ISO": 100} for name, t in WITH_TIMES]),
        of_all([{"SourceFile": f"./{name}", "ExposureTime": f"1/{1e3 / t:g}"} for name, t in WITH_TIMES]),
        of_all(
            {"rig": "A", "frames": [{"file": n, "settings": {"exposure_us": t * 1e3}} for n, t in WITH_TIMES]}
        ),
        of_all([{"image": Path(n).stem, "exposureTimeMs": t, "duration": 7} for n, t in WITH_TIMES]),
    ],
)
def test_times_of_pictures_are_read(tmp_path, written):
    bracket(tmp_path / "in", STEMS)
    written(tmp_path / "in")
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert times_ms(found) == pytest.approx(list(TIMES_MS))
    assert not any("passed over" in doubt.lower() for doubt in found.doubts)


def test_the_gain_of_libcamera_is_a_factor_and_one_file_speaks_for_all_beside_it(tmp_path):
    bracket(tmp_path / "in", STEMS)
    of_all(libcamera(10.0) | {"AnalogueGain": 4.0, "DigitalGain": 2.0})(tmp_path / "in")
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert {entry["exposure_ms"] for entry in found.entries} == {10.0}
    assert {entry["gain_db"] for entry in found.entries} == {18.06}


@pytest.mark.parametrize(
    "content", ['{"cut', "[1, 2, 3]", '{"name": "Ada"}', '{"deep": {"view0.png": {"x": true}}}']
)
def test_json_of_another_kind_is_passed_over_and_named(tmp_path, content):
    bracket(tmp_path / "in", STEMS)
    (tmp_path / "in" / "notes.json").write_text(content)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert any("notes.json" in doubt for doubt in found.doubts)
