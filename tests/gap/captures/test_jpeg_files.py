"""JPEG files say themselves how they were coded, and each its own way."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image

from tacos_files.jpeg_coding import JpegCoding, jpeg_coding, nearest_quality
from tacos_framework.contracts.observed import FileCoding
from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.answer.findings import Diagnosis
from tacos_gap.captures import CaptureFolder, read_captures
from tacos_gap.hypotheses.parameters import HypothesisTerm, initial_guesses_for
from tacos_gap.inference.discrete import whole_numbers
from tacos_plugins.effects.jpeg import Jpeg
from tests.gap.small_captures import BLACK_DN, HEIGHT, WIDTH, capture, effects_named

QUALITIES = {"flat_40": 95, "flat_100": 88, "flat_180": 80}


@given(
    st.integers(1, 100),
    st.sampled_from([(0, "4:4:4"), (1, "4:2:2"), (2, "4:2:0")]),
    st.sampled_from(["L", "RGB"]),
)
@settings(max_examples=30, deadline=None)
def test_what_a_library_wrote_is_read_back(tmp_path_factory, quality, sampling, mode):
    file = tmp_path_factory.mktemp("coded") / "file.jpg"
    number, name = sampling
    Image.new(mode, (16, 16), 100 if mode == "L" else (90, 120, 60)).save(
        file, quality=quality, subsampling=number
    )
    assert jpeg_coding(file) == JpegCoding(quality, name if mode == "RGB" else "4:4:4", 0)


def test_colours_that_were_coded_more_coarsely_are_read_and_guessed(tmp_path):
    tables = [_table_of(88, 0), _table_of(60, 1)]
    Image.new("RGB", (16, 16), (90, 120, 60)).save(tmp_path / "own.jpg", qtables=tables, subsampling=0)
    found = jpeg_coding(tmp_path / "own.jpg")
    assert found == JpegCoding(88, "4:4:4", -28)
    captures = [replace(capture(name, "flat", 100.0), coding=FileCoding(*found)) for name in "ab"]
    assert {"quality": 88, "subsampling": "4:4:4", "chroma_offset": -28} in Jpeg.guesses_from(captures)


def test_tables_of_a_camera_have_the_nearest_quality():
    coarse = [max(round(1.04 * step), 1) for step in _table_of(75)]
    assert 72 <= nearest_quality(coarse) <= 75


def test_other_files_say_nothing(tmp_path):
    Image.new("L", (16, 16)).save(tmp_path / "file.png")
    assert jpeg_coding(tmp_path / "file.png") is None
    (tmp_path / "no.jpg").write_bytes(b"\xff\xd8\xff no header")
    assert jpeg_coding(tmp_path / "no.jpg") is None


def _table_of(quality: int, number: int = 0) -> list[int]:
    from io import BytesIO

    coded = BytesIO()
    Image.new("RGB", (8, 8)).save(coded, "JPEG", quality=quality)
    return list(Image.open(coded).quantization[number])


def patterned(sigma: float) -> NDArray[np.float64]:
    """(H, W) gains of pixels."""
    return 1 + sigma * np.random.default_rng(8).standard_normal((HEIGHT, WIDTH))


def flats_in_files(folder: Path, sigma: float) -> CaptureFolder:
    """Flats of a sensor whose pixels differ, each level in files of another quality."""
    rng, captures = np.random.default_rng(9), []
    for name, quality in QUALITIES.items():
        level = float(name.partition("_")[2])
        files = []
        for i in range(4):
            light = level * patterned(sigma)
            noisy = BLACK_DN + light + rng.standard_normal(light.shape) * np.sqrt(1.8 + 0.24 * light)
            pixels = np.clip(np.round(noisy), 0, 255).astype(np.uint8)
            Image.fromarray(pixels).save(folder / f"{name}_{i}.jpg", quality=quality)
            files.append(f"{name}_{i}.jpg")
        captures.append({"id": name, "kind": "flat", "real": files, "simulated": BLACK_DN + level})
    camera = {"width_px": WIDTH, "height_px": HEIGHT, "bit_depth": 8, "black_level_dn": BLACK_DN}
    text = {"tacos_captures": 1, "camera": camera, "captures": captures}
    text["noise"] = {"photon_dn": 0.24, "thermal_dn2": 1.8}
    (folder / "captures.yaml").write_text(yaml.safe_dump(text), "utf-8")
    return read_captures(folder)


def test_captures_hold_how_their_files_were_coded(tmp_path):
    folder = flats_in_files(tmp_path, 0.0)
    assert {each.id: each.coding for each in folder.captures} == {
        name: FileCoding(quality, "4:4:4") for name, quality in QUALITIES.items()
    }


def in_files(quality: int | None, name: str = "flat"):
    coding = None if quality is None else FileCoding(quality, "4:2:0")
    return replace(capture(name, "flat", 100.0), coding=coding)


def test_files_of_one_quality_suggest_it_for_all():
    first = initial_guesses_for("jpeg", Jpeg, [in_files(83, "a"), in_files(83, "b")])[0]
    assert first.values == {"quality": 83, "subsampling": "4:2:0"}
    assert first.settings == {"quality": 83, "subsampling": "4:2:0"}


def test_files_of_several_qualities_suggest_each_its_own():
    guesses = initial_guesses_for("jpeg", Jpeg, [in_files(80, "a"), in_files(None, "b"), in_files(95, "c")])
    own = next(guess for guess in guesses if "quality@a" in guess.values)
    assert {name: own.values[f"quality@{name}"] for name in "abc"} == {"a": 80, "b": 100, "c": 95}
    placed = own.placed("b")
    assert placed is not None
    assert placed.config.quality == 100  # a PNG among them is left as it is


def test_what_files_say_is_not_searched():
    term = HypothesisTerm("jpeg", Jpeg, {"quality@a": 80, "quality@b": 95, "subsampling": "4:4:4"}, {})
    assert whole_numbers(term) == {}


def test_where_all_files_state_a_quality_no_other_is_tried():
    stated = initial_guesses_for("jpeg", Jpeg, [in_files(83, "a"), in_files(83, "b")])
    assert {guess.settings["quality"] for guess in stated} == {83}
    assert all(guess.is_stated for guess in stated)
    in_part = initial_guesses_for("jpeg", Jpeg, [in_files(83, "a"), in_files(None, "b")])
    assert len({guess.settings["quality"] for guess in in_part}) > 3
    assert not any(guess.is_stated for guess in in_part)


def test_files_that_say_nothing_suggest_nothing():
    assert list(Jpeg.guesses_from([in_files(None)])) == []


@pytest.fixture(scope="module")
def found(tmp_path_factory) -> Diagnosis:
    effects = effects_named("jpeg", "prnu", "read-noise", "denoise", "quantisation", "crosstalk")
    return diagnose(flats_in_files(tmp_path_factory.mktemp("flats"), 0.02), effects, seed=3)


def test_a_fixed_pattern_behind_files_of_three_qualities_is_found(found):
    assert found.verdict == "explained"
    first, codec = found.causes
    assert first.effect == "prnu"
    assert first.present > 0.9
    assert first.parameters["sigma"].value == pytest.approx(0.02, rel=0.15)
    assert codec.effect == "jpeg"


def test_each_capture_has_the_quality_of_its_files(found):
    own = found.causes[1].parameters["quality"].by_capture
    assert {name: parameter.value for name, parameter in own.items()} == QUALITIES
