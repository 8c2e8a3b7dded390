"""Caps, walls and views in too little light, where no single number tells them apart."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from tacos_gap.photographs.given import Given
from tacos_gap.photographs.importing import Imported, import_photographs

SHAPE = (180, 240)
Y, X = np.mgrid[-1 : 1 : SHAPE[0] * 1j, -1 : 1 : SHAPE[1] * 1j]
FALL_OFF = np.cos(0.5 * np.hypot(X, 0.75 * Y)) ** 4
VIEW = cv2.GaussianBlur(np.random.default_rng(7).uniform(0, 1, SHAPE), (0, 0), 5.0)
VIEW = (VIEW - VIEW.min()) / np.ptp(VIEW)


def save(folder: Path, name: str, level_dn: np.ndarray, seed: int) -> None:
    """A grey file of 8 bits with photon and read noise."""
    folder.mkdir(exist_ok=True)
    rng = np.random.default_rng(seed)
    noisy = level_dn + rng.normal(0, 1, SHAPE) * np.sqrt(1.5 + 0.05 * np.maximum(level_dn, 0))
    Image.fromarray(np.clip(np.rint(noisy), 0, 255).astype(np.uint8)).save(folder / f"{name}.png")


def kinds(found: Imported) -> dict[str, str]:
    return {name.rpartition("/")[2]: entry["kind"] for entry in found.entries for name in entry["real"]}


@pytest.mark.parametrize("pedestal_dn", [0.0, 26.0, 34.0])
@pytest.mark.parametrize("names", [("IMG_1", "IMG_2"), ("lens_cap", "paper")])
def test_a_cap_is_told_from_a_wall_whatever_its_pedestal(tmp_path, pedestal_dn, names):
    for k in range(2):
        save(tmp_path / "in", f"{names[0]}_{k}", np.full(SHAPE, pedestal_dn), k)
        save(tmp_path / "in", f"{names[1]}_{k}", pedestal_dn + 150 * FALL_OFF, 10 + k)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert kinds(found) == {
        f"{name}_{k}.png": kind for name, kind in zip(names, ("dark", "flat"), strict=True) for k in range(2)
    }
    assert found.camera.entry["black_level_dn"] == pytest.approx(pedestal_dn, abs=0.6)
    assert not [guess for guess in found.guesses if guess.key == "kinds"]


def test_the_black_level_is_that_of_darks_without_their_current(tmp_path):
    for time_ms in (20, 400):
        save(tmp_path / "in", f"cap_{time_ms}ms", np.full(SHAPE, 30 + 0.05 * time_ms), time_ms)
    save(tmp_path / "in", "wall_20ms", 30 + 150 * FALL_OFF, 9)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert found.camera.entry["black_level_dn"] == pytest.approx(30.0, abs=0.1)


def test_dim_walls_of_a_series_are_walls(tmp_path):
    for time_ms in (1, 2, 4, 8, 16):
        save(tmp_path / "in", f"a_{time_ms}ms", 4 + 12 * time_ms * FALL_OFF, time_ms)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert "dark" not in kinds(found).values()
    assert sum(entry["kind"] == "bracket" for entry in found.entries) == 5


def test_dim_frames_of_a_bracket_are_of_it_and_set_no_black_level(tmp_path):
    for time_ms in (1, 4, 16, 64):
        save(tmp_path / "in", f"a_{time_ms}ms", 2 + 3 * time_ms * VIEW, time_ms)
    for k in range(2):
        save(tmp_path / "in", f"b_{k}_16ms", np.full(SHAPE, 2.0), 100 + k)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    of_view = {name: kind for name, kind in kinds(found).items() if name.startswith("a")}
    assert set(of_view.values()) == {"bracket"}
    assert len(of_view) == 4
    assert {kind for name, kind in kinds(found).items() if name.startswith("b")} == {"dark"}
    assert any("show faintly what" in guess.text for guess in found.guesses)


def test_a_wall_seen_by_a_sensor_with_bad_lines_is_a_wall(tmp_path):
    for k, level_dn in enumerate((60, 120, 200)):
        wall_dn = level_dn * FALL_OFF
        wall_dn[:, 101] = 9
        wall_dn[44:46] += 30
        save(tmp_path / "in", f"IMG_{k}", wall_dn, k)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert set(kinds(found).values()) == {"flat"}


def test_what_could_be_either_is_a_guess_with_its_alternative_and_may_be_answered(tmp_path):
    save(tmp_path / "in", "a", np.full(SHAPE, 30.0) * (1 + 0.03 * X), 1)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    guess = next(guess for guess in found.guesses if guess.key == "kinds")
    assert guess.pictures == ("a.png",)
    assert "else" in guess.text
    assert f"# a guess: kind {guess.assumed}" in found.path.read_text()
    other = {"dark": "flat", "flat": "dark"}[guess.assumed]
    answered = import_photographs([tmp_path / "in"], tmp_path / "other", Given(kinds={"a.png": other}))
    assert kinds(answered) == {"a.png": other}
    assert not any(each.key == "kinds" for each in answered.guesses)
