"""Folders of captures, made for a test."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from tacos_framework.errors import UserError
from tacos_gap.captures import read_captures

WIDTH, HEIGHT = 20, 12
CAMERA = {"width_px": WIDTH, "height_px": HEIGHT}


def noisy(
    level: float | np.ndarray = 100.0, frames: int = 2, channels: int = 1, sigma: float = 3.0, seed: int = 0
) -> np.ndarray:
    """(N, H, W[, 3]) uint8 frames of an even field with noise [DN]."""
    shape = (frames, HEIGHT, WIDTH, 3) if channels == 3 else (frames, HEIGHT, WIDTH)
    noise = np.random.default_rng(seed).normal(scale=sigma, size=shape)
    return np.clip(np.rint(level + noise), 0, 255).astype(np.uint8)


def save(path: Path, image: np.ndarray) -> None:
    """Write an image or array, colour in the order R, G, B."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".npy":
        np.save(path, image)
    else:
        assert cv2.imwrite(str(path), image[..., ::-1] if image.ndim == 3 else image)


def save_frames(folder: Path, name: str, frames: np.ndarray, suffix: str = ".png") -> list[str]:
    """Write frames as ``name/000.png``...; returns their names."""
    names = [f"{name}/{i:03}{suffix}" for i in range(len(frames))]
    for each, frame in zip(names, frames, strict=True):
        save(folder / each, frame)
    return names


def describe(folder: Path, *captures: Mapping[str, Any], **changes: Any) -> Path:
    """Write ``captures.yaml`` (JSON is YAML); `changes` replace what stands beside the captures."""
    data = {"tacos_captures": 1, "camera": CAMERA, "captures": [dict(c) for c in captures], **changes}
    (folder / "captures.yaml").write_text(json.dumps(data, indent=1))
    return folder


def flat_folder(folder: Path, level: float = 100.0, frames: int = 2, **changes: Any) -> Path:
    """A folder with one flat, `changes` to its entry."""
    names = save_frames(folder, "flat", noisy(level, frames))
    entry = {"id": "flat", "kind": "flat", "real": names, "simulated": float(level), **changes}
    return describe(folder, {key: value for key, value in entry.items() if value is not None})


def faults(folder: Path, **options: Any) -> list[str]:
    """What the reader says is wrong with a folder."""
    try:
        read_captures(folder, **options)
    except UserError as error:
        return [str(fault) for fault in error.faults]
    return []


def only(found: list[str]) -> str:
    assert len(found) == 1, found
    return found[0]
