"""Real captures with known truth, as folders that the diagnosis reads; see the data's own README."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from tacos_files.images import read_samples
from tacos_validation.blind.generators.specifications import CAPTURES
from tacos_validation.blind.judgement import KnownTruth
from tacos_validation.blind.real_folders import RealCase

FLEA3 = {
    "width_px": 408,
    "height_px": 344,
    "pixel_um": 3.45,
    "focal_length_mm": 8.0,
    "f_number": 4.0,
    "bit_depth": 8,
    "black_level_dn": 0,
    "channels": 1,
    "cfa": "GRBG",
}

OPENCV = {
    "camera": {"focal_length_mm": 0.5359, "principal_point_px": [342.28, 235.57]},
    "board": {"inner_corners": [9, 6], "square_mm": 25},
}
HX5V = {
    "camera": {"focal_length_mm": 0.7, "principal_point_px": [308.5, 246.8], "channels": 3},
    "board": {"inner_corners": [6, 4], "square_mm": 30},
}
"""Boards and who saw them, with pixels of a micrometre: focal lengths are given in pixels."""

BRACKET_5D2_MS = {"IMG_2600": 125, "IMG_2601": 1000, "IMG_2602": 8000}
"""Exposure times by their EXIF."""

LINEAR_MS = 250
"""Exposure time up to which the signal of the Flea3 is linear where it does not clip."""

UNCLIPPED_DN = 240
"""Values below are far enough from clipping."""


SMALL = KnownTruth(("quantisation",), expect_verdict=("no_gap",))
"""Half a code lost to rounding down, at most."""

BENT = KnownTruth(("lens-distortion",), ("focal-length-error", "pose-error", "jpeg"))

PROCESSED = KnownTruth(("tone-curve",), ("jpeg", "sharpening", "denoise", "saturation", "colour-matrix"))
"""What a camera does to the files that it finishes."""

UNMIXED = KnownTruth(
    ("colour-matrix",),
    ("white-balance", "black-level", "veiling-glare", "dark-current", "crosstalk", "tone-curve", "jpeg"),
)
"""Colours as the filters of a sensor gave them, and what light and the editing of a picture add."""

SEEN_BESIDE_BLUR = ("jpeg", "sharpening", "tone-curve", "denoise")
"""What pictures from finished files may have beside their blur."""


def real_cases(data: Path) -> Iterator[RealCase]:
    """All cases for which the data are there. `data`: the folder ``real`` of the shared data."""
    if (boards := data / "opencv_boards").is_dir():
        files = sorted(boards.glob("left*.jpg"))
        for name, chosen in (("all", files), ("first half", files[:7]), ("second half", files[6:])):
            yield RealCase(f"chessboards, {name}", BENT, partial(_boards, files=chosen, seen_by=OPENCV))
    if (boards := data / "boards_hx5v").is_dir():
        files = sorted(boards.glob("frame*.jpg"))
        yield RealCase("chessboards by a compact", BENT, partial(_boards, files=files, seen_by=HX5V))
    if (bracket := data / "bracket_5d2").is_dir():
        yield RealCase("processed bracket", PROCESSED, partial(_bracket, folder=bracket))
    if (chart := data / "chart_asi533" / "color_target_sun.tif").is_file():
        yield RealCase("chart in the sun", UNMIXED, partial(_chart, file=chart))
    if (flea := data / "flea3_raw").is_dir():
        yield from _flea3(flea)
    if (blur := data / "opencv_blur").is_dir():
        for file, effects in (("motion", ["motion-blur"]), ("defocus", ["defocus", "lens-blur"])):
            image = blur / f"text_{file}.jpg"
            known = KnownTruth(tuple(effects), SEEN_BESIDE_BLUR)
            yield RealCase(f"text, {file}", known, partial(_edges, file=image))
    if (slanted := data / "slanted_edge" / "Test_edge1_mono.tif").is_file():
        known = KnownTruth(("lens-blur", "defocus"), SEEN_BESIDE_BLUR)
        yield RealCase("slanted edge", known, partial(_edges, file=slanted))
    if (stack := data / "focus_stack").is_dir():
        magnified = ("focal-length-error", "pose-error", "exposure-error")
        known = KnownTruth(("defocus", "lens-blur"), (*SEEN_BESIDE_BLUR, *magnified))
        for step in (1, 4, 7):
            yield RealCase(f"focus stack, step {step}", known, partial(_focus, stack=stack, step=step))


def _flea3(folder: Path) -> Iterator[RealCase]:
    darks = {time: sorted(folder.glob(f"d1_dark_{time}ms_*.tif")) for time in _times(folder, "dark")}
    lit = {time: sorted(folder.glob(f"d1_disks*_{time}ms_*.tif")) for time in _times(folder, "disks")}
    warm = KnownTruth(("dark-current",), ("dsnu", "read-noise"))
    full = KnownTruth(
        ("saturation",), ("exposure-error", "black-level", "nonlinearity", "veiling-glare", "quantisation")
    )
    for name, times, known in (
        ("short darks, 25 and 50 ms", (25, 50), SMALL),
        ("short darks, 50 and 100 ms", (50, 100), SMALL),
        ("short darks, 25 to 100 ms", (25, 50, 100), SMALL),
        ("long darks, 500 and 2000 ms", (500, 2000), warm),
        ("long darks, 2000 and 3916 ms", (2000, 3916), warm),
        ("darks of all times", tuple(darks), warm),
    ):
        yield RealCase(name, known, partial(_darks, frames={k: darks[k] for k in times}))
    # Series of shorter times than these have no known truth: from 50 ms on green clips, and dim red beside it
    # gains half its light, more the longer it takes.
    for name, times in (
        ("series to 500 ms, believed wider", (25, 50, 100, 250, 500)),
        ("series to 2000 ms, believed wider", (50, 100, 250, 500, 2000)),
    ):
        yield RealCase(name, full, partial(_series, chosen={k: lit[k] for k in times}, lit=lit))


def _times(folder: Path, what: str) -> list[int]:
    found = {
        int(match[1])
        for file in folder.glob("*.tif")
        if what in file.name and (match := re.search(r"_(\d+)ms_", file.name))
    }
    return sorted(found)


def _write(out: Path, camera: Mapping[str, Any], captures: Sequence[Mapping[str, Any]]) -> None:
    inside = [{key: _copied(out, value) for key, value in each.items()} for each in captures]
    data = {"tacos_captures": 1, "camera": dict(camera), "noise": "unknown", "captures": inside}
    (out / "captures.yaml").write_text(yaml.safe_dump(data, sort_keys=False), "utf-8")


def _copied(out: Path, value: Any) -> Any:
    """Value of a capture, with files from elsewhere copied beside it: captures stay within their folder."""
    if isinstance(value, list):
        return [_copied(out, each) for each in value]
    if isinstance(value, str) and Path(value).is_absolute():
        return Path(shutil.copy(value, out)).name
    return value


def _folder(out: Path) -> Path:
    folder = out / CAPTURES
    folder.mkdir(parents=True)
    return folder


def _boards(out: Path, files: Sequence[Path], seen_by: Mapping[str, Any]) -> None:
    camera = {"width_px": 640, "height_px": 480, "pixel_um": 1.0, "bit_depth": 8, **seen_by["camera"]}
    captures = [
        {"id": file.stem, "kind": "board", "real": str(file.resolve()), "board": seen_by["board"]}
        for file in files
    ]
    _write(_folder(out), camera, captures)


def _bracket(out: Path, folder: Path) -> None:
    """Three times, of which the pictures are all that is known."""
    captures = [
        {
            "id": name,
            "kind": "bracket",
            "real": [str((folder / f"{name}.jpg").resolve())],
            "exposure_ms": time,
            "group": "view",
        }
        for name, time in BRACKET_5D2_MS.items()
    ]
    _write(_folder(out), {"width_px": 640, "height_px": 426, "bit_depth": 8, "channels": 3}, captures)


def _chart(out: Path, file: Path) -> None:
    """One picture of a ColorChecker, of which nothing is said."""
    image = read_samples(file)
    camera = {"width_px": image.shape[1], "height_px": image.shape[0], "bit_depth": 8, "channels": 3}
    _write(_folder(out), camera, [{"id": file.stem, "kind": "chart", "real": [str(file.resolve())]}])


def _darks(out: Path, frames: Mapping[int, Sequence[Path]]) -> None:
    captures = [
        {"id": f"dark_{time}", "kind": "dark", "real": [str(f.resolve()) for f in files], "exposure_ms": time}
        for time, files in frames.items()
    ]
    _write(_folder(out), FLEA3, captures)


def _series(out: Path, chosen: Mapping[int, Sequence[Path]], lit: Mapping[int, Sequence[Path]]) -> None:
    """Expectation of each exposure: the light of the *others*, with the half code back that each had lost."""
    folder = _folder(out)
    frames = {time: _read(files[0]) for time, files in lit.items() if time <= LINEAR_MS}
    captures = []
    for time, files in chosen.items():
        others = {t: image for t, image in frames.items() if t != time}
        exposed = sum(t * (image < UNCLIPPED_DN) for t, image in others.items())
        collected = sum((image + 0.5) * (image < UNCLIPPED_DN) for image in others.values())
        brightest = np.full_like(exposed, 256 / min(others), dtype=float)  # where all others clip
        light = np.where(exposed > 0, collected / np.maximum(exposed, 1), brightest) * time
        np.save(folder / f"expected_{time}.npy", light.astype(np.float32))
        cv2.imwrite(str(folder / f"mask_{time}.png"), np.where(exposed > 0, 255, 0).astype(np.uint8))
        captures.append(
            {
                "id": f"disks_{time}",
                "kind": "bracket",
                "real": [_in_16_bits(folder, file) for file in files],
                "simulated": f"expected_{time}.npy",
                "simulated_frames": max(1, round(float(np.median(exposed)) / time)),
                "mask": f"mask_{time}.png",
                "exposure_ms": time,
                "group": "disks",
                "level_uncertainty": 0.03,
            }
        )
    _write(folder, {**FLEA3, "bit_depth": 12}, captures)


def _in_16_bits(folder: Path, file: Path) -> str:
    """Name of a copy with the same values in 16 bits, as a camera of 12 bits saves them."""
    name = f"{file.stem}.png"
    cv2.imwrite(str(folder / name), read_samples(file).astype(np.uint16))
    return name


def _edges(out: Path, file: Path) -> None:
    """One picture, of which nothing is known but that its edges are sharp in the world."""
    image = _read(file)
    folder = _folder(out)
    np.save(folder / "real.npy", np.clip(np.round(image), 0, 255).astype(np.uint8))
    camera = {"width_px": image.shape[1], "height_px": image.shape[0], "bit_depth": 8}
    _write(folder, camera, [{"id": file.stem, "kind": "edge", "real": "real.npy"}])


def _focus(out: Path, stack: Path, step: int) -> None:
    """One step of a focus stack against the composite that is sharp everywhere."""
    folder = _folder(out)
    sharp, real = (_half(_read(stack / name)) for name in ("expected.jpg", f"pcb_{step:03d}.jpg"))
    height, width = min(sharp.shape[0], real.shape[0], 480), min(sharp.shape[1], real.shape[1], 640)
    np.save(folder / "real.npy", np.clip(np.round(real[:height, :width]), 0, 255).astype(np.uint8))
    np.save(folder / "expected.npy", sharp[:height, :width].astype(np.float32))
    camera = {"width_px": width, "height_px": height, "bit_depth": 8}
    scene = {"id": "board", "kind": "scene", "real": "real.npy", "simulated": "expected.npy"}
    _write(folder, camera, [scene])


def _half(image: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA), np.float64)


def _read(file: Path) -> NDArray[np.float64]:
    """An image as one channel of whole numbers' size, float64."""
    image = read_samples(file)
    scale = 257.0 if image.dtype == np.uint16 else 1.0
    return np.asarray(image if image.ndim == 2 else image.mean(axis=-1), np.float64) / scale
