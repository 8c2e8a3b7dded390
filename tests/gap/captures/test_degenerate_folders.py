"""Folders that a diagnosis can do little with: it says what it cannot measure, and never breaks."""

from __future__ import annotations

import contextlib
import time
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from tacos_framework.errors import UserError
from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.answer.gathering import gather
from tacos_gap.answer.undiagnosed import NothingMeasured
from tacos_gap.captures import CaptureFolder, read_captures
from tacos_gap.evidence import ImageEvidence
from tacos_gap.inference.location import locate
from tacos_gap.inference.problem import Problem
from tacos_gap.inference.unknown import unexplained
from tacos_gap.statistics import Sample, measure
from tests.gap.captures.folders import describe, save, save_frames
from tests.gap.captures.random_folders import random_folder
from tests.gap.small_captures import effects_named

WIDTH, HEIGHT = 64, 48
KNOWN = {"photon_dn": 0.24, "thermal_dn2": 1.8}


def even(level: float, frames: int = 2, sigma: float = 3.0, shape: tuple[int, ...] = ()) -> np.ndarray:
    """Frames of an even field with noise [DN]."""
    noise = np.random.default_rng(4).normal(0, sigma, (frames, *(shape or (HEIGHT, WIDTH))))
    return np.clip(np.rint(level + noise), 0, 255).astype(np.uint8)


def squares(shape: tuple[int, int] = (HEIGHT, WIDTH)) -> np.ndarray:
    """(H, W) dark and bright squares [DN]."""
    rows, columns = np.mgrid[: shape[0], : shape[1]]
    return np.asarray(40.0 + 150 * ((rows // 12 + columns // 12) % 2), np.float32)


def folder_of(
    folder: Path,
    kind: str,
    frames: np.ndarray,
    simulated: Any,
    camera: dict[str, Any] | None = None,
    noise: Any = KNOWN,
    **entry: Any,
) -> Path:
    if isinstance(simulated, np.ndarray):
        save(folder / "expected.npy", simulated)
        simulated = "expected.npy"
    height, width = frames.shape[1:3]
    entry |= {"id": "it", "kind": kind, "real": save_frames(folder, "it", frames), "exposure_ms": 10}
    if simulated is not None:
        entry["simulated"] = simulated
    camera = {"width_px": width, "height_px": height, **(camera or {})}
    return describe(folder, entry, camera=camera, noise=noise)


def look_at(folder: CaptureFolder) -> list[str]:
    """Measure and locate, as a diagnosis does before it tries effects; what it says it cannot measure."""
    evidence, limitations = gather(folder, seed=0)
    if any(each.labels for each in evidence):
        problem = Problem(evidence)
        assert np.isfinite(problem.null).all()
        assert np.isfinite(problem.null_replicates).all()
        locate(problem, problem.null)
        left = unexplained(problem, problem.replicate_residuals(()))
        assert np.isfinite([left.gap, left.share, left.p_value, problem.weight]).all()
    else:
        assert limitations or folder.limitations
    return [*folder.limitations, *limitations]


COLOUR = {"channels": 3}
TINY = (32, 32)
DEGENERATE: dict[str, dict[str, Any]] = {
    "no pedestal": {"kind": "dark", "frames": even(0, sigma=1.3), "simulated": None},
    "all zero": {
        "kind": "dark",
        "frames": np.zeros((2, HEIGHT, WIDTH), np.uint8),
        "simulated": None,
        "noise": {"photon_dn": 0, "thermal_dn2": 4e-6},
    },
    "constant": {"kind": "flat", "frames": even(90, sigma=0), "simulated": 90, "noise": "unknown"},
    "one frame": {"kind": "flat", "frames": even(90, frames=1), "simulated": 90},
    "all saturated": {"kind": "bracket", "frames": even(400), "simulated": 900},
    "off-axis crop": {
        "kind": "scene",
        "frames": squares((96, 128))[None].astype(np.uint8),
        "simulated": squares((96, 128)),
        "camera": {"principal_point_px": [-400.5, -340.5], "cfa": "GBRG"},
    },
    "portrait": {
        "kind": "scene",
        "frames": squares((150, 40))[None].astype(np.uint8),
        "simulated": squares((150, 40)),
    },
    "very wide": {
        "kind": "edge",
        "frames": squares((17, 400))[None].astype(np.uint8),
        "simulated": squares((17, 400)),
    },
    "tiny": {"kind": "scene", "frames": squares(TINY)[None].astype(np.uint8), "simulated": squares(TINY)},
    "a few pixels": {"kind": "flat", "frames": even(90, shape=(3, 5)), "simulated": 90},
    "16 bit": {
        "kind": "flat",
        "frames": even(90).astype(np.uint16) * 200,
        "simulated": 18_000,
        "camera": {"bit_depth": 16},
    },
    "uncertain colours": {
        "kind": "scene",
        "frames": np.repeat(squares()[None, ..., None], 3, axis=3).astype(np.uint8),
        "simulated": np.repeat(squares()[..., None], 3, axis=2),
        "camera": COLOUR,
        "level_uncertainty": 0.1,
        "simulated_frames": 2,
    },
}


@pytest.mark.parametrize("name", DEGENERATE)
def test_a_degenerate_folder_is_measured_or_said_to_be_beyond_it(tmp_path, name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a division by 0 is a statistic that should not have been taken
        look_at(read_captures(folder_of(tmp_path, **DEGENERATE[name])))


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("a few pixels", "it: 5 x 3 pixels are too few to measure anything in"),
        ("very wide", "it: no tile of 24 x 24 pixels has detail; sharpness cannot be measured."),
        ("one frame", "it: a single frame has no real-against-real noise floor"),
        ("all saturated", "it: nearly all pixels are saturated"),
    ],
)
def test_what_cannot_be_measured_is_named_with_its_capture(tmp_path, name, said):
    limitations = look_at(read_captures(folder_of(tmp_path, **DEGENERATE[name])))
    assert any(text.startswith(said) for text in limitations), limitations


def test_lossy_files_and_a_mask_of_few_pixels(tmp_path):
    quality = [cv2.IMWRITE_JPEG_QUALITY, 40]
    coded = cv2.imencode(".jpg", squares().astype(np.uint8), quality)[1]
    frame = cv2.imdecode(coded, cv2.IMREAD_GRAYSCALE)
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    mask[20:22, 30:33] = 255
    save(tmp_path / "mask.png", mask)
    look_at(read_captures(folder_of(tmp_path, "scene", frame[None], squares(), mask="mask.png")))


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("a few pixels", "too few"),
        ("all zero", "every pixel is 0"),
        ("all saturated", "are saturated"),
    ],
)
def test_a_folder_that_tells_nothing_is_refused_with_the_reasons(tmp_path, name, why):
    """Files that stand at one end of their range differ from no simulation that ends there too."""
    folder = read_captures(folder_of(tmp_path, **DEGENERATE[name]))
    with pytest.raises(NothingMeasured, match="nothing can be measured") as raised:
        diagnose(folder, {})
    assert any(why in text for text in raised.value.limitations)


def test_a_dark_at_zero_counts_beside_captures_that_show_something(tmp_path):
    dark = read_captures(folder_of(tmp_path / "dark", **DEGENERATE["all zero"])).captures[0]
    flat = read_captures(folder_of(tmp_path / "flat", **DEGENERATE["one frame"])).captures[0]
    found = diagnose(CaptureFolder(tmp_path, (replace(dark, id="dark"), flat)), {}, workers=1)
    assert {label.capture for label in found.problem.labels} == {"dark", "it"}


@pytest.mark.parametrize("name", ["no pedestal", "constant", "tiny", "uncertain colours"])
def test_a_degenerate_folder_is_diagnosed(tmp_path, name):
    effects = effects_named("black-level", "read-noise", "saturation")
    found = diagnose(read_captures(folder_of(tmp_path, **DEGENERATE[name])), effects, workers=1)
    assert np.isfinite([found.gap_before, found.gap_after, *found.gap_interval]).all()


def test_what_is_measured_does_not_depend_on_the_frames(tmp_path):
    """Nor on the draw of a noisy expectation: else draws could not be compared."""
    (capture,) = read_captures(folder_of(tmp_path, **DEGENERATE["uncertain colours"])).captures
    assert capture.expected_dn is not None
    named = []
    for frames in (capture.real_dn, np.zeros_like(capture.real_dn), np.full_like(capture.real_dn, 255)):
        for expected in (capture.expected_dn, capture.expected_dn + 20):
            named.append([(b.statistic, list(b.at)) for b in measure(Sample(capture, frames, expected))])
    assert all(each == named[0] for each in named)


def test_what_is_raised_while_measuring_names_the_capture(tmp_path, monkeypatch):
    def broken(*_: Any) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr("tacos_gap.answer.gathering.ImageEvidence", broken)
    with pytest.raises(ZeroDivisionError) as raised:
        gather(read_captures(folder_of(tmp_path, **DEGENERATE["constant"])), seed=0)
    assert raised.value.__notes__ == ["while measuring the capture 'it'"]


@pytest.mark.parametrize(
    "seed", [pytest.param(seed, marks=[pytest.mark.slow] if seed >= 12 else []) for seed in range(40)]
)
def test_a_random_folder_is_measured_or_refused_in_words(tmp_path, monkeypatch, seed):
    monkeypatch.setattr(ImageEvidence.__init__, "__defaults__", (4,))  # replicates
    began = time.process_time()
    with contextlib.suppress(UserError):
        look_at(read_captures(random_folder(tmp_path, seed)))
    assert time.process_time() - began < 30
