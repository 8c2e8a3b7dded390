"""What a reader doubts aloud: sentences that say what to do, and none about a sound folder."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from tacos_gap.captures import read_captures
from tests.gap.captures.folders import HEIGHT, WIDTH, describe, flat_folder, noisy, save, save_frames


def said(folder: Path) -> str:
    return "\n".join(read_captures(folder).limitations)


def colourful() -> np.ndarray:
    """(H, W, 3) a picture whose red and blue differ from place to place."""
    x = np.arange(WIDTH)[None, :, None] / WIDTH
    return np.asarray(40 + 150 * np.concatenate([x, 0.5 + 0 * x, 1 - x], axis=2).repeat(HEIGHT, axis=0))


def colour_folder(folder: Path, frame: np.ndarray) -> Path:
    save(folder / "expected.npy", colourful())
    names = save_frames(folder, "scene", frame[None].astype(np.uint8))
    entry = {"id": "scene", "kind": "scene", "real": names, "simulated": "expected.npy"}
    return describe(folder, entry, camera={"width_px": WIDTH, "height_px": HEIGHT, "channels": 3})


def test_darks_without_a_single_code(tmp_path):
    names = save_frames(tmp_path, "dark", np.zeros((2, HEIGHT, WIDTH), np.uint8))
    folder = describe(tmp_path, {"id": "dark", "kind": "dark", "real": names, "exposure_ms": 10})
    assert "dark: every pixel is 0" in said(folder)


def test_darks_that_are_brighter_than_flats(tmp_path):
    dark, flat = (save_frames(tmp_path, name, noisy(level)) for name, level in (("d", 150), ("f", 60)))
    entries = (
        {"id": "d", "kind": "dark", "real": dark, "exposure_ms": 10},
        {"id": "f", "kind": "flat", "real": flat, "exposure_ms": 10},
    )
    sentence = "d: it is a dark, and brighter (150 DN) than the flat f (60 DN), which had no less time"
    assert sentence in said(describe(tmp_path, *entries))
    entries[0]["exposure_ms"] = 4000  # dark current alone may reach that
    assert sentence not in said(describe(tmp_path, *entries))


def test_files_that_stop_below_the_believed_full_scale(tmp_path):
    frames = np.where(noisy(100) > 98, 255, noisy(100)).astype(np.uint16)
    entry = {"id": "flat", "kind": "flat", "real": save_frames(tmp_path, "flat", frames), "simulated": 400}
    camera = {"width_px": WIDTH, "height_px": HEIGHT, "bit_depth": 10}
    assert "pile up at 255 DN, where more light is expected, below the believed full scale of 1023" in said(
        describe(tmp_path, entry, camera=camera)
    )


def test_red_and_blue_that_were_swapped(tmp_path):
    assert "red is bright where blue is expected" in said(colour_folder(tmp_path, colourful()[..., ::-1]))


def test_mono_stored_as_colour(tmp_path):
    assert "set camera.channels to 1" in said(colour_folder(tmp_path, colourful()[..., :1].repeat(3, axis=2)))


def test_frames_of_two_lights_in_one_capture(tmp_path):
    frames = np.concatenate([noisy(100, frames=2), noisy(180, frames=1)])
    entry = {"id": "flat", "kind": "flat", "real": save_frames(tmp_path, "flat", frames), "simulated": 100}
    assert "flat: frame 3 is brighter (180 DN above the black level) than frame " in said(
        describe(tmp_path, entry)
    )
    assert "is brighter" not in said(describe(tmp_path, {**entry, "kind": "sequence"}))
    expected = save_frames(tmp_path, "expected", frames.astype(np.float32), ".npy")
    assert "is brighter" not in said(describe(tmp_path, {**entry, "simulated": expected}))


def moving_folder(folder: Path, **changes) -> Path:
    return flat_folder(folder, kind="sequence", exposure_ms=20, velocity_px_s=[90, 120], **changes)


def test_motion_while_the_shutter_is_open(tmp_path):
    sharp = said(moving_folder(tmp_path))
    assert "flat: by velocity_px_s and exposure_ms the picture moves by 3 px" in sharp
    assert "effect.motion-blur is to be expected" in sharp
    blurred = said(moving_folder(tmp_path, motion_blurred=True))
    assert (
        "`simulated` holds that blur (motion_blurred): effect.motion-blur is what is there beyond it"
        in blurred
    )
    assert "moves by" not in said(flat_folder(tmp_path, velocity_px_s=[90, 120]))
    assert "moves by" not in said(flat_folder(tmp_path, velocity_px_s=[9, 12], exposure_ms=20))


def test_a_board_is_not_compared_with_what_is_simulated_of_it(tmp_path):
    board = {"inner_corners": [9, 6], "square_mm": 25}
    assert "flat: `simulated` is not used" in said(flat_folder(tmp_path, kind="board", board=board))


def test_lossy_files(tmp_path):
    assert cv2.imwrite(str(tmp_path / "flat.jpg"), noisy(frames=1)[0])
    entry = {"id": "flat", "kind": "flat", "real": "flat.jpg", "simulated": 100}
    assert "its files are lossy (.jpg)" in said(describe(tmp_path, entry))


def test_portrait_frames(tmp_path):
    frames = np.swapaxes(noisy(), 1, 2)
    entry = {"id": "flat", "kind": "flat", "real": save_frames(tmp_path, "flat", frames), "simulated": 100}
    camera = {"width_px": HEIGHT, "height_px": WIDTH}
    assert "camera: all files are higher than wide" in said(describe(tmp_path, entry, camera=camera))


def test_a_bracket_whose_levels_contradict_its_exposure_times(tmp_path):
    entries = [
        {
            "id": f"at_{ms}",
            "kind": "bracket",
            "real": save_frames(tmp_path, f"{ms}", noisy(level, sigma=1.0)),
            "simulated": level,
            "exposure_ms": ms,
            "group": "lamp",
        }
        for ms, level in [(10, 30), (20, 61), (40, 70)]
    ]
    sentences = said(describe(tmp_path, *entries))
    assert "at_40: it is 1.15 times as bright as at_20 at 2 times its exposure" in sentences
    assert "at_20: it is" not in sentences


def test_a_wrong_time_is_doubted_by_the_lit_part_of_a_dark_view(tmp_path):
    """Of a lamp in a dark room the middle value is dark at every time."""
    view = np.full((HEIGHT, WIDTH), 0.1)
    view[: HEIGHT // 3, : WIDTH // 2] = 1.0
    entries = [
        {
            "id": f"at_{ms}",
            "kind": "bracket",
            "real": save_frames(
                tmp_path, f"{ms}", np.rint(ms_true * view * 1.2)[np.newaxis].astype(np.uint8)
            ),
            "simulated": 50,
            "exposure_ms": ms,
            "group": "lamp",
        }
        for ms, ms_true in [(25, 25), (50, 50), (200, 100), (250, 175)]
    ]
    sentences = said(describe(tmp_path, *entries))
    assert "at_200: it is 2 times as bright as at_50 at 4 times its exposure" in sentences
    assert "at_50: it is" not in sentences


def test_a_sound_folder_raises_no_doubt(tmp_path):
    estimated = "`noise` is unknown, so it is estimated from the files and not compared."
    assert said(flat_folder(tmp_path)).endswith(f"flat: {estimated}")
    assert said(colour_folder(tmp_path, colourful())).endswith(f"scene: {estimated}")
