"""Folders of captures drawn at random: any kind, size, depth, pedestal and content, sensible or not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.gap.captures.folders import describe, save

KINDS = ("dark", "flat", "bracket", "edge", "board", "chart", "scene", "sequence")
CONTENTS = ("zero", "white", "even", "ramp", "edges", "bright", "hot", "line")
SIZES = ((32, 32), (40, 64), (300, 17), (9, 5), (1, 40), (96, 72), (64, 150))
"""Widths and heights [px]."""


def random_folder(folder: Path, seed: int) -> Path:
    """A folder of one to three captures; the same for the same seed."""
    rng = np.random.default_rng(seed)
    depth = int(rng.choice([8, 8, 10, 16]))
    white = 2.0**depth - 1
    camera: dict[str, Any] = {
        "bit_depth": depth,
        "black_level_dn": float(rng.choice([0.0, 0.0, round(white / 16)])),
        "channels": int(rng.choice([1, 1, 3])),
    }
    camera["width_px"], camera["height_px"] = SIZES[rng.integers(len(SIZES))]
    if camera["channels"] == 1 and rng.random() < 0.3:
        camera["cfa"] = str(rng.choice(["RGGB", "GBRG"]))
    if rng.random() < 0.3:
        camera["principal_point_px"] = (rng.uniform(-3, 4, 2) * camera["width_px"]).tolist()
    if rng.random() < 0.2:
        camera["crop"] = {"x": 30, "y": 7, "full_width_px": 400, "full_height_px": 300}
    noise: Any = "unknown"
    if rng.random() < 0.6:
        photon, thermal = rng.choice([0.0, 0.001, 0.2, 3.0]), rng.choice([0.0, 4e-6, 0.1, 2.0])
        noise = {"photon_dn": float(photon), "thermal_dn2": float(thermal)}
    captures = [_capture(folder, f"c{i}", camera, white, rng) for i in range(rng.integers(1, 4))]
    return describe(folder, *captures, camera=camera, noise=noise)


def _capture(
    folder: Path, name: str, camera: dict[str, Any], white: float, rng: np.random.Generator
) -> dict[str, Any]:
    """An entry of ``captures.yaml``, whose files are written."""
    kind, content = str(rng.choice(KINDS)), str(rng.choice(CONTENTS))
    expected = _picture(rng, content, camera, white)
    entry: dict[str, Any] = {
        "id": name,
        "kind": kind,
        "real": _frames(folder / name, expected, white, rng),
        "exposure_ms": float(rng.choice([1, 10, 1e5])),
    }
    if kind == "board":
        entry["board"] = {"inner_corners": rng.integers(3, 9, 2).tolist(), "square_mm": 20}
    elif kind != "edge" or rng.random() < 0.5:
        entry["simulated"] = f"{name}/expected.npy"
        save(folder / name / "expected.npy", expected)
    if kind == "chart":
        (folder / f"{name}.csv").write_text("id,x,y,width,height,r,g,b\na,0,0,1,1,10,10,10\n")
        entry["chart"] = {"patches": f"{name}.csv"}
    if kind == "sequence" and rng.random() < 0.5:
        entry |= {"velocity_px_s": [100.0, 0.0], "frame_interval_ms": 33.0}
    if rng.random() < 0.2:
        kept = rng.random(expected.shape[:2]) < rng.choice([0, 0.01, 0.2, 0.9])
        save(folder / name / "mask.png", np.uint8(255) * kept)
        entry["mask"] = f"{name}/mask.png"
    if rng.random() < 0.2:
        entry["level_uncertainty"] = float(rng.choice([0.02, 1.0]))
    if rng.random() < 0.2:
        entry["simulated_frames"] = int(rng.integers(1, 5))
    return entry


def _frames(folder: Path, expected: NDArray[Any], white: float, rng: np.random.Generator) -> list[str]:
    """Names of one to three frames: the expectation dimmed or brightened a little, with noise or without."""
    scale, sigma = rng.choice([0.5, 1.0, 1.0, 1.1]), rng.choice([0.0, 1.0, white * 0.02])
    names = []
    for i in range(rng.integers(1, 4)):
        frame = np.rint(expected * scale + rng.normal(0, sigma, expected.shape)).clip(0, white)
        stored = frame.astype(np.uint8 if white < 256 else np.uint16)
        names.append(f"{folder.name}/{i}{rng.choice(['.png', '.npy'])}")
        save(folder.parent / names[-1], stored)
    return names


def _picture(
    rng: np.random.Generator, content: str, camera: dict[str, Any], white: float
) -> NDArray[np.float32]:
    """(H, W, C) what is expected [DN]."""
    height, width, black = camera["height_px"], camera["width_px"], camera["black_level_dn"]
    y, x = np.mgrid[:height, :width]
    match content:
        case "zero":
            plane = np.zeros((height, width))
        case "white":
            plane = np.full((height, width), white)
        case "ramp":
            plane = 0.8 * white * x / width
        case "edges":
            plane = black + 0.5 * white * ((x + y // 5) // 9 % 2)
        case "bright":
            plane = rng.uniform(0.9, 1.2, (height, width)) * white
        case "hot":
            plane = np.where(rng.random((height, width)) < 0.01, white, black)
        case "line":
            plane = np.where(x == width // 2, 0.5 * white, black)
        case _:
            plane = np.full((height, width), 0.3 * white)
    return np.repeat(plane[..., None], camera["channels"], axis=2).astype(np.float32)
