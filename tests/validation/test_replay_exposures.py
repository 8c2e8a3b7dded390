"""``tacos-run replay_exposures``: recordings that cannot be replayed, and the response of those that can."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from tacos_framework import UserError
from tacos_validation.exposures_replayed.emulation import Lack, Replay
from tacos_validation.exposures_replayed.findings import TOO_FEW_FOR_BLUR, replayed
from tacos_worlds.recorded.consistency import faults_of_stamps
from tacos_worlds.recorded.motion import Motion, blurred
from tacos_worlds.recorded.noise import LinearNoise
from tacos_worlds.recorded.reader import read_recording
from tacos_worlds.recorded.recording import ExposedFrames, Recording
from tacos_worlds.recorded.response import estimated_response, linear_response
from tacos_worlds.recorded.saturation import clipping_codes

STEP_NS = 100_000_000


def record(folder: Path, *, sizes: dict[str, tuple[int, int]] | None = None) -> Path:
    """Noisy frames of one texture at 1, 2 and 4 ms, 12 bits, linear."""
    rng = np.random.default_rng(3)
    texture = rng.uniform(100, 900, (48, 64))
    lines = ["file,taken_ns"]
    for place, ms in enumerate((1, 2, 4)):
        for frame in range(5):
            name = f"{ms:02d}ms_{frame}.png"
            light = texture * ms + rng.normal(0, 3, texture.shape)
            height, width = (sizes or {}).get(name, texture.shape)
            cv2.imwrite(str(folder / name), np.clip(light, 0, 4095).astype(np.uint16)[:height, :width])
            lines.append(f"{name},{frame * STEP_NS + place * 30_000_000}")
    (folder / "times.csv").write_text("\n".join(lines))
    np.savetxt(folder / "response.txt", np.linspace(0, 255, 256)[None])
    return folder


def test_all_faults_are_named_at_once_with_what_is_still_usable(tmp_path: Path) -> None:
    folder = record(tmp_path, sizes={"01ms_2.png": (40, 64)})
    table = (folder / "times.csv").read_text().splitlines()
    (folder / "times.csv").write_text("\n".join(line for line in table if "02ms_2" not in line))
    (folder / "02ms_2.png").unlink()
    with pytest.raises(UserError) as caught:
        read_recording(folder)
    said = "\n".join(str(fault) for fault in caught.value.faults)
    assert "01ms_2.png: is 64 x 40 px" in said
    assert "frames were dropped between them (1)" in said
    assert "Still usable: 4 ms." in said


def test_a_folder_without_times_says_what_to_write(tmp_path: Path) -> None:
    (record(tmp_path) / "times.csv").unlink()
    with pytest.raises(UserError, match=r"times\.csv: there is no such file beside 15 frames"):
        read_recording(tmp_path)


def test_two_cameras_under_one_name_are_one_fault_an_exposure() -> None:
    files = [f"{name}_{k}.png" for k in range(5) for name in ("left", "right")]
    stamps = [k * STEP_NS + late for k in range(5) for late in (0, 1_000_000)]
    (fault,) = faults_of_stamps(Path("times.csv"), files, stamps)
    assert "from 1 to 99 ms" in fault.what
    assert "two cameras" in fault.remedy


def test_a_response_is_found_from_exposures_of_one_scene() -> None:
    rng = np.random.default_rng(1)
    light = np.exp(rng.uniform(np.log(2), np.log(900), (1, 400, 500)))
    stacks = {
        ms: np.rint(4095 * np.clip(light * ms / 4095, 0, 1) ** 0.5).astype(np.uint16)
        for ms in (1.0, 2.0, 4.0, 8.0)
    }
    found = estimated_response(stacks, 4095)
    inside = slice(25, 243)
    np.testing.assert_allclose(found.light_dn[inside], 4095 * (found.code_dn[inside] / 4095) ** 2, rtol=0.02)


def recorded(folder: Path, texture: np.ndarray, told: np.ndarray, taken_ms: tuple[float, ...]) -> None:
    """Two frames each of 1, 2 and 4 ms by their names, of a linear camera that exposed for `taken_ms`."""
    rng = np.random.default_rng(3)
    lines = ["file,taken_ns"]
    for place, (ms, taken) in enumerate(zip((1, 2, 4), taken_ms, strict=True)):
        for frame in range(2):
            light = np.clip(texture * taken + rng.normal(0, 2, texture.shape), 0, 4095)
            cv2.imwrite(str(folder / f"{ms:02d}ms_{frame}.png"), light.astype(np.uint16))
            lines.append(f"{ms:02d}ms_{frame}.png,{frame * STEP_NS + place * 30_000_000}")
    (folder / "times.csv").write_text("\n".join(lines))
    np.savetxt(folder / "response.txt", told)


CODES = np.linspace(0, 4095, 256)


def test_a_told_response_is_mended_where_exposures_contradict_it(tmp_path: Path) -> None:
    texture = np.exp(np.random.default_rng(4).uniform(np.log(100), np.log(950), (96, 128)))
    recorded(tmp_path, texture, CODES + np.maximum(CODES - 2500, 0), (1, 2, 4))  # true up to code 2500
    found = read_recording(tmp_path)
    assert "beyond, where they contradict it" in found.response_from
    assert found.told_response is not None
    there = found.response.light(np.array([1000, 2000, 3700], np.uint16))
    np.testing.assert_allclose(there / there[0], [1, 2, 3.7], rtol=0.06)  # told: 4.9
    assert found.clipped("4") > 0  # what was mended stays doubtful


def test_a_response_that_is_wrong_for_the_brightest_blames_no_exposure(tmp_path: Path) -> None:
    texture = np.repeat([20.0, 250.0, 600.0], [30, 26, 44])  # too dark for 1 ms, true and wrong at 4 ms
    texture = np.random.default_rng(4).permuted(np.resize(texture, (96, 128)))
    texture *= np.random.default_rng(5).uniform(0.9, 1.1, texture.shape)
    recorded(tmp_path, texture, CODES + 0.8 * np.maximum(CODES - 1500, 0), (1, 2, 4))
    assert "contradict it" in read_recording(tmp_path).response_from
    other = tmp_path / "other"
    other.mkdir()
    recorded(other, texture, CODES, (1, 2, 5.2))
    with pytest.raises(UserError, match=r"4 ms.*is 1\.\d+ times as bright"):
        read_recording(other)


def test_blur_along_the_path_is_the_mean_over_the_longer_exposure() -> None:
    columns = np.arange(128, dtype=np.float32)
    source = np.tile(np.sin(columns / 6), (64, 1)).astype(np.float32)
    velocity = np.zeros((1, 32, 64, 2), np.float32)
    velocity[..., 0] = 1000.0  # 1 px/ms
    found = blurred(source, Motion(np.zeros(1), velocity), middle_s=0.0, own_ms=1, wanted_ms=8, mosaic=1)
    expected = np.mean([np.sin((columns - shift) / 6) for shift in np.arange(8) - 3.5], axis=0)
    np.testing.assert_allclose(found[32, 16:-16], expected[16:-16], atol=0.01)


@pytest.mark.parametrize(("row", "column"), [(0, 0), (0, 1), (1, 1)])
def test_highlights_that_one_colour_clips_are_clipped_further_in_all(row: int, column: int) -> None:
    codes = np.tile(np.linspace(100, 3000, 96), (2, 96, 1)).astype(np.uint16)
    codes[:, row::2, column::2][..., 32:] = 3978  # full photosites, below the largest code
    exposures = {f"{ms}": ExposedFrames(float(ms), np.arange(2.0), codes) for ms in (1, 2)}
    clipping = clipping_codes(codes, 4095)
    recording = Recording(exposures, 12, linear_response(4095), "linear", clipping)
    still = Motion(np.zeros(1), np.zeros((1, 48, 48, 2), np.float32))
    replay = Replay(recording, "2", "1", recording.light("2"), LinearNoise(0.0, 0.0), still, 0.0, 2)
    assert "highlights" in replay.lacks()
    as_is, clipped = (next(replay.frames(np.random.default_rng(0), lack)) for lack in (None, "highlights"))
    others = np.ones((96, 96), bool)
    others[row::2, column::2] = False
    assert (clipped < as_is)[others].any()


def replay_of(own_s: list[float], wanted_s: list[float]) -> Replay:
    codes = np.zeros((len(own_s), 8, 8), np.uint16)
    exposures = {
        "1": ExposedFrames(1.0, np.array(own_s), codes),
        "2": ExposedFrames(2.0, np.array(wanted_s), np.zeros((len(wanted_s), 8, 8), np.uint16)),
    }
    recording = Recording(exposures, 12, linear_response(4095), "linear", np.full((2, 2), 4095))
    still = Motion(np.zeros(1), np.zeros((1, 4, 4, 2), np.float32))
    return Replay(recording, "1", "2", recording.light("1"), LinearNoise(0.0, 0.0), still, 0.0, 1)


def test_frames_are_replayed_as_those_of_their_moment() -> None:
    assert replay_of([0.23, 0.5, 0.77], [0.0, 0.27, 0.54]).moments() == ((0, 1), (1, 2))
    assert replay_of([0.0, 0.1, 0.2, 0.3], [0.01, 0.21]).moments() == ((0, 0), (2, 1))
    assert replay_of([0.0, 0.1], [5.0, 5.1]).moments() == ()


def test_shadows_that_are_cut_off_in_the_source_are_cut_off_further() -> None:
    replay = replay_of([0.0, 1.0], [0.0, 1.0])
    assert replay.lacks() == ("noise", "shadows")
    light = np.tile(np.linspace(-3, 9, 64, dtype=np.float32).clip(0), (64, 1))
    codes = np.stack([light, light]).round().astype(np.uint16)
    exposures = {f"{ms}": ExposedFrames(float(ms), np.arange(2.0), codes) for ms in (1, 2)}
    recording = Recording(exposures, 12, linear_response(4095), "linear", np.full((2, 2), 4095))
    again = Replay(recording, "1", "2", recording.light("1"), LinearNoise(0.0, 0.0), replay.motion, 0.0, 1)
    as_is, cut = (next(again.frames(np.random.default_rng(0), lack)) for lack in (None, "shadows"))
    assert cut.min() > as_is.min() == 0
    assert cut.max() == as_is.max()


def test_a_blurred_source_that_leaves_next_to_nothing_is_refused() -> None:
    def refused(inliers: float, blur_px: float) -> str | None:
        worse: dict[Lack, float] = {"blur": inliers}
        return replayed(1.0, None, np.full(4, inliers), worse, ratio=0.1, blur_px=blur_px).refused

    assert refused(0, blur_px=0.2) is None
    assert refused(0, blur_px=4.0) == TOO_FEW_FOR_BLUR
    assert refused(50, blur_px=4.0) is None


def test_two_pairs_leave_an_interval_of_counts() -> None:
    found = replayed(1.0, None, np.full(2, 50.0), {}, ratio=1.0, blur_px=0.0)
    assert found.interval == pytest.approx((40.2, 59.8), abs=0.1)


def test_noise_that_left_few_inliers_counts_for_each_doubling() -> None:
    def refused(inliers: float, ratio: float) -> str | None:
        worse: dict[Lack, float] = {"noise": inliers - 4}
        return replayed(8.0, None, np.full(4, inliers), worse, ratio=ratio, blur_px=0.0).refused

    assert refused(40, ratio=2) is None
    assert "changes 40 inliers by 4" in (refused(40, ratio=16) or "")
    assert refused(400, ratio=16) is None
