"""What pictures say against their description: a fault, or a limitation that is stated."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tacos_gap.captures import read_captures
from tests.gap.captures.folders import (
    CAMERA,
    HEIGHT,
    WIDTH,
    describe,
    faults,
    flat_folder,
    noisy,
    only,
    save,
    save_frames,
)


def test_values_above_the_white_level(tmp_path):
    names = save_frames(tmp_path, "flat", noisy(100).astype(np.uint16) * 256)
    entry = {"id": "flat", "kind": "flat", "real": names, "simulated": 100}
    fault = only(faults(describe(tmp_path, entry, camera={**CAMERA, "bit_depth": 12})))
    assert "at most the white level, 4095" in fault
    assert "right-aligned" in fault


def test_values_below_zero(tmp_path):
    names = save_frames(tmp_path, "flat", noisy(100).astype(np.float32) - 200, ".npy")
    entry = {"id": "flat", "kind": "flat", "real": names, "simulated": 100}
    assert "go down to" in only(faults(describe(tmp_path, entry)))


@pytest.mark.parametrize(
    ("real_dn", "simulated_dn", "remedy"),
    [
        (120, 120 / 255, "Shares of full scale have to be multiplied by 255, with the black level in them."),
        (120, 120 * 257.0, "Divide it by about 257 if it is in other units."),
        (240, 1.5, "Multiply it by about 160 if it is in other units."),
        (240, 0.0, "It has to hold the black level, 1, and the light above it."),
        (1, 120, "The files hold no light above the black level, 1: is this capture a dark?"),
    ],
)
def test_an_expectation_in_other_units(tmp_path, real_dn, simulated_dn, remedy):
    names = save_frames(tmp_path, "flat", noisy(real_dn))
    entry = {"id": "flat", "kind": "flat", "real": names, "simulated": simulated_dn}
    fault = only(faults(describe(tmp_path, entry, camera={**CAMERA, "black_level_dn": 1})))
    assert "digital numbers up to 255, as in the files" in fault
    assert fault.endswith(remedy)


def test_darker_files_than_expected_within_the_scale_are_a_matter_of_light(tmp_path):
    names = save_frames(tmp_path, "flat", noisy(40).astype(np.uint16))
    entry = {"id": "flat", "kind": "flat", "real": names, "simulated": 4000}
    fault = only(faults(describe(tmp_path, entry, camera={**CAMERA, "bit_depth": 12})))
    assert fault.endswith("Make sure that light, exposure_ms and gain_db were those of the files.")


def test_units_that_may_be_right_are_doubted_aloud(tmp_path):
    folder = read_captures(flat_folder(tmp_path, simulated=100.0 / 16))
    assert any("16 times as bright as expected" in text for text in folder.limitations)


def test_a_saturated_frame_may_expect_any_light_above(tmp_path):
    names = save_frames(tmp_path, "bracket", np.full((2, HEIGHT, WIDTH), 255, np.uint8))
    entry = {"id": "long", "kind": "bracket", "real": names, "simulated": 80_000, "exposure_ms": 1000}
    folder = read_captures(describe(tmp_path, entry))
    assert any(re.search("constant|saturated", text) for text in folder.limitations)


def test_exposures_that_were_mixed_up(tmp_path):
    captures = [
        {
            "id": f"at_{ms}",
            "kind": "bracket",
            "real": save_frames(tmp_path, f"{ms}", noisy(level)),
            "simulated": level,
            "exposure_ms": ms,
            "group": "lamp",
        }
        for ms, level in [(10, 40), (20, 160), (40, 80)]
    ]
    fault = only(faults(describe(tmp_path, *captures)))
    assert "'at_40' at 40 ms is darker (80) than 'at_20' at 20 ms (160), in the group 'lamp'" in fault


def test_the_same_frame_twice_is_no_stack(tmp_path):
    frame = noisy(frames=1)
    names = save_frames(tmp_path, "flat", np.concatenate([frame, noisy(frames=1, seed=5), frame]))
    entry = {"id": "flat", "kind": "flat", "real": names, "simulated": 100}
    assert "frames 1 and 3 of 'flat' are the same" in only(faults(describe(tmp_path, entry)))


def test_dark_frames_without_noise_may_be_alike(tmp_path):
    names = save_frames(tmp_path, "dark", np.zeros((2, HEIGHT, WIDTH), np.uint8))
    entry = {"id": "dark", "kind": "dark", "real": names, "exposure_ms": 10}
    assert faults(describe(tmp_path, entry)) == []


@pytest.mark.parametrize(
    ("frames", "message"),
    [
        (np.full((2, HEIGHT, WIDTH), 77, np.uint8), "a constant image has no information"),
        (np.where(noisy(100) > 95, 255, noisy(100)).astype(np.uint8), "nearly all pixels are saturated"),
        (np.where(noisy(100) > 104, 20, 0).astype(np.uint8), "nearly all pixels are 0"),
        (noisy(frames=1), "a single frame has no real-against-real noise floor"),
    ],
    ids=["constant", "saturated", "black", "single"],
)
def test_pictures_that_tell_little_are_a_stated_limitation(tmp_path, frames, message):
    names = save_frames(tmp_path, "flat", frames)
    entry = {"id": "flat", "kind": "flat", "real": names, "simulated": float(frames.mean())}
    folder = read_captures(describe(tmp_path, entry))
    assert any(message in text for text in folder.limitations), folder.limitations


def test_a_mask_without_a_pixel_is_a_stated_limitation(tmp_path):
    save(tmp_path / "mask.png", np.zeros((HEIGHT, WIDTH), np.uint8))
    assert any(
        "its mask leaves no pixel" in text
        for text in read_captures(flat_folder(tmp_path, mask="mask.png")).limitations
    )
