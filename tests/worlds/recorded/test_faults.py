"""Recordings at fault: each is named by its cause, and no other cause beside it."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from tacos_framework import UserError
from tacos_framework.cli.tacos import main
from tacos_worlds.recorded.consistency import by_lamp, out_of_order
from tacos_worlds.recorded.reader import read_recording

EXPOSURES_MS = (1, 2, 4, 8, 16, 32)
FRAMES = 6


def scene(seed: int) -> np.ndarray:
    """Light of a view (60, 80), 0 to 1, with parts as large as a third of it."""
    noise = np.random.default_rng(seed).normal(size=(60, 80))
    drawn = sum(cv2.GaussianBlur(noise, (0, 0), sigma) * sigma for sigma in (2, 5, 12))
    return np.asarray((drawn - drawn.min()) / np.ptp(drawn))


def record(folder: Path, *, views=(1,), lamp=lambda ms: 1.0, suffix: str = "png") -> Path:
    """12 bits coded by a square root; frames show the views in turn, each exposure lit by the lamp."""
    folder.mkdir()
    rng, lines = np.random.default_rng(4), ["file,taken_ns"]
    for k in range(FRAMES):
        light = 0.05 + scene(views[k % len(views)])
        for turn, ms in enumerate(EXPOSURES_MS):
            linear = 160 * ms * lamp(ms) * light
            noisy = linear + rng.normal(0, 1, light.shape) * np.sqrt(4 + linear)
            codes = np.rint(4095 * np.sqrt(np.clip(noisy / 4095, 0, 1))).astype(np.uint16)
            name = f"{ms:02d}ms_{k}.{suffix}"
            cv2.imwrite(str(folder / name), codes if suffix == "png" else (codes >> 4).astype(np.uint8))
            lines.append(f"{name},{10**9 + k * 250_000_000 + turn * 40_000_000}")
    (folder / "times.csv").write_text("\n".join(lines) + "\n")
    return folder


def faults_of(folder: Path, *, response_known: bool = False) -> list[str]:
    if response_known:
        (folder / "response.txt").write_text(" ".join(f"{x:.8f}" for x in np.linspace(0, 1, 256) ** 2))
    with pytest.raises(UserError) as raised:
        read_recording(folder)
    return [str(fault) for fault in raised.value.faults]


def test_two_cameras_whose_frames_alternate_are_named(tmp_path: Path) -> None:
    faults = faults_of(record(tmp_path / "r", views=(1, 2)))
    assert len(faults) == len(EXPOSURES_MS)
    assert all("shows two views in turn" in fault for fault in faults)
    assert "Two cameras are under one name" in faults[0]


def test_one_camera_that_turns_shows_no_two_views(tmp_path: Path) -> None:
    read_recording(record(tmp_path / "r", views=(1, 2, 3, 4, 5, 6)), response="estimated")


def test_a_lamp_may_be_why_short_exposures_do_not_match(tmp_path: Path) -> None:
    faults = faults_of(record(tmp_path / "r", lamp=lambda ms: 1.5 if ms < 4 else 1.0), response_known=True)
    assert [fault.split(": ")[1] for fault in faults] == ["1 ms", "2 ms"]
    assert all("a lamp on mains flickers" in fault for fault in faults)
    assert "Still usable: 4, 8, 16, 32 ms." in faults[-1]


def test_a_wrong_exposure_beyond_what_a_lamp_does_is_no_lamp(tmp_path: Path) -> None:
    (fault,) = faults_of(
        record(tmp_path / "r", lamp=lambda ms: 0.6 if ms == 32 else 1.0), response_known=True
    )
    assert "32 ms: is 0.6" in fault
    assert "lamp" not in fault
    assert by_lamp(2.0, 0.45)
    assert not by_lamp(1.0, 2.9)  # brighter than any wave about its mean


def test_frames_clipped_throughout_are_overexposed_and_no_copies(tmp_path: Path) -> None:
    folder = record(tmp_path / "r")
    for path in folder.glob("32ms*"):
        cv2.imwrite(str(path), np.full((60, 80), 4095, np.uint16))
    (fault,) = faults_of(folder)
    assert "overexposed throughout" in fault
    assert "Still usable: 1, 2, 4, 8, 16 ms." in fault


def test_exchanged_bytes_are_named_and_nothing_that_follows_from_them(tmp_path: Path) -> None:
    folder = record(tmp_path / "r", views=(1, 2, 3, 4, 5, 6))
    for path in folder.glob("*.png"):
        cv2.imwrite(str(path), cv2.imread(str(path), cv2.IMREAD_UNCHANGED).byteswap())
    (fault,) = faults_of(folder, response_known=True)
    assert "once the two bytes of each sample are exchanged" in fault
    assert "numpy: frame.byteswap()" in fault


def test_dropped_frames_leave_the_other_exposures_usable(tmp_path: Path) -> None:
    folder = record(tmp_path / "r")
    table = folder / "times.csv"
    gone = ("08ms_3.png", "16ms_2.png")
    table.write_text("\n".join(li for li in table.read_text().splitlines() if not li.startswith(gone)))
    for name in gone:
        (folder / name).unlink()
    faults = faults_of(folder)
    assert len(faults) == 2
    assert all("frames were dropped" in fault for fault in faults)
    assert "Still usable: 1, 2, 4, 32 ms." in faults[-1]


def test_a_bracket_without_its_response_comes_in_without_doubts(tmp_path: Path, capsys) -> None:
    source = record(tmp_path / "r")
    assert main(["recordings", "import", str(source), "--out", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().out.splitlines() == [f"36 frames (a table of times) in {tmp_path / 'out'}."]


def test_frames_that_were_jpeg_are_said_to_be(tmp_path: Path, capsys) -> None:
    source = record(tmp_path / "r", suffix="jpg")
    assert main(["recordings", "import", str(source), "--out", str(tmp_path / "out")]) == 0
    assert "36 frames are coded with loss" in capsys.readouterr().out


def test_stamps_of_two_frames_that_were_mixed_up_are_named(tmp_path: Path) -> None:
    folder = record(tmp_path / "r", views=(1, 2, 3, 4, 5, 6))
    table = folder / "times.csv"
    lines = dict(line.split(",") for line in table.read_text().split())
    lines["08ms_2.png"], lines["08ms_3.png"] = lines["08ms_3.png"], lines["08ms_2.png"]
    table.write_text("\n".join(",".join(line) for line in lines.items()) + "\n")
    (fault,) = faults_of(folder, response_known=True)
    assert "08ms_2.png: was taken after 08ms_3.png, by its stamp" in fault
    assert "Look whether times or names were mixed up." in fault


@pytest.mark.parametrize(
    "files",
    [
        ["a_8.png", "a_9.png", "a_0.png", "a_1.png"],  # counted on from nought
        ["a_1.png", "a_2.png", "b_1.png", "b_2.png"],
        ["7.png", "3.png", "9.png", "1.png", "8.png", "2.png"],  # numbers that say nothing
        ["first_8ms.png", "second_8ms.png"],
    ],
)
def test_a_count_that_begins_again_is_no_mixed_up_stamp(files: list[str]) -> None:
    assert out_of_order(Path("times.csv"), files) == []


def test_a_table_from_windows_names_frames_in_folders(tmp_path: Path) -> None:
    folder = record(tmp_path / "r")
    table = folder / "times.csv"
    expected = read_recording(folder, response="estimated")
    for path in folder.glob("*.png"):
        ms, k = path.stem.split("_")
        path.parent.joinpath(ms).mkdir(exist_ok=True)
        path.rename(folder / ms / f"{k}.png")
    table.write_text(table.read_text().replace("ms_", "ms\\").replace(".png", ".PNG"))
    assert read_recording(folder, response="estimated").exposures.keys() == expected.exposures.keys()
