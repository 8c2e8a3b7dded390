"""Photographs of one wall: which are frames of one capture, which of another light or turn of the camera."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

from tacos_gap.photographs.caps_and_walls import with_kinds_weighed
from tacos_gap.photographs.given import Given
from tacos_gap.photographs.grouping import Stack, stacks_of
from tacos_gap.photographs.picture import look_at

WIDTH, HEIGHT = 320, 240
ACROSS, DOWN = np.meshgrid(np.linspace(-1, 1, WIDTH), np.linspace(-1, 1, HEIGHT))
FALL_OFF = 1 - 0.25 * (ACROSS**2 + DOWN**2) / 2
LAMP = 1 + 0.02 * ACROSS
TURNED_LAMP = 1 + 0.02 * DOWN


def stacks(folder: Path, **walls_dn: np.ndarray) -> list[tuple[str, list[str]]]:
    """Kind or bracket, and files, of the stacks that walls make, one file each, with noise of 1.5 %."""
    rng = np.random.default_rng(3)
    pictures = []
    for name, wall_dn in walls_dn.items():
        path = folder / f"{name}.png"
        noisy = np.rint(wall_dn * (1 + 0.015 * rng.standard_normal(wall_dn.shape)))
        Image.fromarray(np.clip(noisy, 0, 255).astype(np.uint8)).save(path)
        pictures.append(look_at(path, 0.0, 8))
    return [_described(stack) for stack in stacks_of(pictures)]


def _described(stack: Stack) -> tuple[str, list[str]]:
    return stack.group or stack.kind, [picture.path.stem for picture in stack.pictures]


@pytest.mark.parametrize(
    "other",
    [FALL_OFF * TURNED_LAMP, FALL_OFF, FALL_OFF * (1 - 0.02 * ACROSS)],
    ids=["turned", "off", "moved"],
)
def test_walls_that_are_shaded_otherwise_are_captures_of_their_own(tmp_path, other):
    wall = 120 * FALL_OFF * LAMP
    found = stacks(tmp_path, a_10ms=wall, b_10ms=wall * 1.01, c_10ms=120 * other, d_10ms=120 * other)
    assert found == [("flat", ["a_10ms", "b_10ms"]), ("flat", ["c_10ms", "d_10ms"])]


@pytest.mark.parametrize("depth", [0.012, 0.03])
def test_walls_under_a_lamp_that_flickers_from_row_to_row_are_frames_of_one(tmp_path, depth):
    flickering = (120 * LAMP * (1 + depth * np.sin(8 * DOWN + phase)) for phase in (0, 2))
    first, second = flickering
    assert stacks(tmp_path, a_10ms=first, b_10ms=second) == [("flat", ["a_10ms", "b_10ms"])]


def test_a_wall_that_is_lit_from_above_and_then_from_below_is_two(tmp_path):
    lit = (120 * FALL_OFF * (1 + slope * DOWN) for slope in (0.04, -0.04))
    first, second = lit
    assert len(stacks(tmp_path, a_10ms=first, b_10ms=second)) == 2


def test_a_wall_that_was_turned_is_none_of_the_bracket(tmp_path):
    def wall_dn(lamp: np.ndarray, time_ms: float) -> np.ndarray:
        return 5 * time_ms * FALL_OFF * lamp

    found = stacks(
        tmp_path,
        a_10ms=wall_dn(LAMP, 10),
        b_20ms=wall_dn(LAMP, 20),
        c_40ms=wall_dn(LAMP, 40),
        turned_20ms=wall_dn(TURNED_LAMP, 20),
        turned_30ms=wall_dn(TURNED_LAMP, 30),
    )
    brackets = [(name, files[0]) for name, files in found if name != "flat"]
    assert brackets == [
        ("view_1", "a_10ms"),
        ("view_1", "b_20ms"),
        ("view_1", "c_40ms"),
        ("view_2", "turned_20ms"),
        ("view_2", "turned_30ms"),
    ]


@pytest.mark.parametrize("black_dn", [0, 16])
@pytest.mark.parametrize("gamma", [1.0, 0.45])
def test_a_bracket_of_a_wall_may_bend_and_clip(tmp_path, gamma, black_dn):
    def file_dn(light: float) -> np.ndarray:
        return black_dn + (255 - black_dn) * np.minimum(light * FALL_OFF**2 * LAMP, 1) ** gamma

    found = stacks(
        tmp_path, a_10ms=file_dn(0.2), b_20ms=file_dn(0.4), c_40ms=file_dn(0.8), d_80ms=file_dn(1.6)
    )
    names = [files[0] for name, files in found if name == "view_1"]
    assert names == ["a_10ms", "b_20ms", "c_40ms", "d_80ms"]


def test_a_view_that_is_cut_off_below_full_scale_stays_in_its_bracket(tmp_path):
    """Nearly all of the last picture is at its top, which lies at 214 of 255."""
    rng = np.random.default_rng(4)
    view = np.abs(ndimage.gaussian_filter(rng.normal(size=(240, 320)), 9)) * 2000
    found = []
    for number, gain in enumerate((1.0, 2.0, 4.0, 8.0, 16.0)):
        light = np.minimum(view * gain + 16 + rng.normal(0, 1, view.shape), 214)
        path = tmp_path / f"desk_{2**number}ms.png"
        Image.fromarray(np.rint(light).astype(np.uint8)).save(path)
        found.append(look_at(path, None, None))
    assert np.mean(np.asarray(Image.open(path)) == 214) > 0.7
    assert [stack.kind for stack in stacks_of(found)] == ["bracket"] * 5


def test_a_wall_under_a_lamp_that_flickers_is_a_wall_where_its_name_says_so(tmp_path):
    rows = np.arange(240)[:, None]
    light = 150 * (1 + 0.06 * np.sin(2 * np.pi * rows / 57)) + np.random.default_rng(4).normal(
        0, 2, (240, 320)
    )
    kinds = {}
    for name in ("wall_1", "IMG_1"):
        path = tmp_path / name / f"{name}.png"
        path.parent.mkdir()
        Image.fromarray(np.rint(light).astype(np.uint8)).save(path)
        (weighed,), _ = with_kinds_weighed([look_at(path, None, None)], Given())
        kinds[name] = weighed.shown.kind
    assert kinds == {"wall_1": "flat", "IMG_1": "scene"}
