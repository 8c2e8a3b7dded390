"""A camera in use, diagnosed from its recording: blur that is there, blur that is not, and the response."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from unittest.mock import Mock

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from tacos_framework import Progress
from tacos_gap.in_use.diagnosis import InUse, diagnose_recording, in_words, is_recording

EXPOSURES_MS = (1, 4, 16, 32)
FRAMES = 8
RESTING = 4
SPEED_PX_S = 250.0
SIZE = 256


def texture() -> NDArray[np.float32]:
    rng = np.random.default_rng(5)
    layers = [
        cv2.GaussianBlur(rng.normal(0, 1, (SIZE, 2 * SIZE)), (0, 0), s) * s for s in (1.0, 2.0, 4.0, 8.0)
    ]
    drawn = sum(layers)
    return np.asarray(np.exp(0.5 * drawn / np.std(drawn)), np.float32)


def place_px(time_s: float) -> float:
    return max(0.0, time_s - RESTING * 0.25) * SPEED_PX_S


def record(
    folder: Path,
    *,
    moves: bool = True,
    defocused: str = "",
    corner: float = 0.0,
    blank: bool = False,
    lamp: Callable[[float], float] = lambda time_s: 1.0,
) -> Path:
    """A texture at rest and then in motion, 12 bits, coded by a square root; exposures in turn.

    `corner`: light that corners lack [1]; `blank`: true if all but a third is a wall without texture; `lamp`:
    its brightness over time [s].
    """
    y, x = np.mgrid[:SIZE, :SIZE] / (SIZE - 1) * 2 - 1
    passed = 1 - corner * (x**2 + y**2) / 2
    world, rng = texture(), np.random.default_rng(6)
    if blank:
        world[: SIZE // 3] = world[2 * SIZE // 3 :] = np.median(world)
    lines = ["file,taken_ns"]
    for frame in range(FRAMES):
        for turn, ms in enumerate(EXPOSURES_MS):
            middle_s = frame * 0.25 + turn * 0.05 + ms * 5e-4
            moments = middle_s + ((np.arange(24) + 0.5) / 24 - 0.5) * ms * 1e-3
            light = np.zeros((SIZE, SIZE), np.float32)
            for moment in moments:
                shift = np.float32([[1, 0, -place_px(moment) % SIZE - SIZE / 2], [0, 1, 0]])
                if not moves:
                    shift[0, 2] = -SIZE / 2
                light += cv2.warpAffine(world, shift, (SIZE, SIZE), borderMode=cv2.BORDER_WRAP) / 24
            name = f"{ms:02d}ms_{frame}.png"
            if name == defocused:
                light = cv2.GaussianBlur(light, (0, 0), 1.5)
            linear = 40.0 * ms * light * passed * lamp(middle_s)
            noisy = linear + rng.normal(0, 1, light.shape) * np.sqrt(4 + 0.3 * linear)
            codes = 4095 * np.sqrt(np.clip(noisy / 4095, 0, 1))
            cv2.imwrite(str(folder / name), np.rint(codes).astype(np.uint16))
            lines.append(f"{name},{round(middle_s * 1e9) + 10**9}")
    (folder / "times.csv").write_text("\n".join(lines))
    return folder


def diagnosed(folder: Path) -> InUse:
    return diagnose_recording(folder, Mock(spec=Progress))


@pytest.fixture(scope="module")
def moving(tmp_path_factory: pytest.TempPathFactory) -> InUse:
    folder = record(tmp_path_factory.mktemp("moving"))
    assert is_recording(folder)
    return diagnosed(folder)


def test_motion_is_named_where_it_blurs_and_nothing_at_rest(moving: InUse) -> None:
    assert moving.causes_in_motion["16"] == moving.causes_in_motion["32"] == ["effect.motion-blur"]
    assert not any(moving.causes_at_rest.values())
    longest = moving.blurs[-1]
    assert longest.share == pytest.approx(1, abs=0.35)
    assert longest.path_px == pytest.approx(SPEED_PX_S * 32e-3, rel=0.4)


def test_the_response_is_found_within_a_percent_without_being_told(moving: InUse) -> None:
    code, light = moving.response.code_dn / 4095, moving.response.light_dn
    inside = (code**2 > 0.05) & (code**2 < 0.95)
    ratio = light[inside] / code[inside] ** 2
    assert np.abs(ratio / np.median(ratio) - 1).max() < 0.01


def test_a_response_that_exposures_disagree_on_is_not_said_to_be_known(tmp_path: Path) -> None:
    found = diagnosed(record(tmp_path, moves=False, lamp=lambda time_s: 1.1 if time_s % 0.25 > 0.14 else 1.0))
    assert "exposures or colours disagree" in in_words(found)
    assert found.response_error.max() > 0.03


def test_a_camera_at_rest_has_no_cause_and_is_told_to_move(tmp_path: Path) -> None:
    found = diagnosed(record(tmp_path, moves=False))
    assert not any(found.causes_in_motion.values())
    assert not any(found.causes_at_rest.values())
    assert "in faster motion" in found.next_picture


def test_a_frame_at_rest_that_is_out_of_focus_is_not_taken_for_motion(tmp_path: Path) -> None:
    found = diagnosed(record(tmp_path, moves=False, defocused="32ms_1.png"))
    assert found.causes_at_rest["32"] == ["unsteady detail"]
    assert not any(found.causes_in_motion.values())
    assert "unsteady detail" in in_words(found)


def test_steady_light_and_even_corners_have_no_name(moving: InUse) -> None:
    assert moving.steadiness is not None
    assert moving.steadiness.cause is None
    assert not moving.vignetting.present
    assert moving.vignetting.interval is not None


def test_noise_over_light_is_an_upper_limit_where_all_has_texture(moving: InUse) -> None:
    assert 0.3 < moving.noise.slope_dn < 1.0
    assert "Noise of linear light, at most" in in_words(moving)


def test_dark_corners_and_an_exposure_that_settles_are_named(tmp_path: Path) -> None:
    found = diagnosed(record(tmp_path, corner=0.5, lamp=lambda time_s: 1 - 0.2 * np.exp(-time_s / 0.15)))
    assert found.vignetting.present
    assert found.vignetting.corner == pytest.approx(0.5, abs=0.15)
    assert found.steadiness is not None
    assert found.steadiness.cause == "settling exposure"
    assert "settling exposure named" in in_words(found)


def test_dark_corners_are_measured_beside_a_blank_wall_and_are_no_change_of_light(tmp_path: Path) -> None:
    found = diagnosed(record(tmp_path, corner=0.6, blank=True))
    assert found.vignetting.interval is not None
    low, high = found.vignetting.interval
    assert 0 < low < 0.6 < high <= 1
    assert found.steadiness is not None
    assert found.steadiness.cause is None


def test_a_lamp_that_flickers_is_named(tmp_path: Path) -> None:
    found = diagnosed(record(tmp_path, moves=False, lamp=lambda time_s: 1 + 0.15 * np.sin(41 * time_s)))
    assert found.steadiness is not None
    assert found.steadiness.cause == "flicker"
    assert '"flicker"' in json.dumps(found.as_data())
