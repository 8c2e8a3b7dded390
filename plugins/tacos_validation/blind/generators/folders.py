"""Writes captures as a folder, in the format of ``captures.yaml``; by itself, as another simulator would."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from PIL import Image as Pillow

from tacos_validation.blind.generators.acquisitions import FRAME_INTERVAL_MS, Acquisition
from tacos_validation.blind.generators.camera import IdealCamera, Image
from tacos_validation.blind.generators.capture_nuisance import AS_BELIEVED, CaptureNuisance
from tacos_validation.blind.generators.flat_scenes import Chart, Even
from tacos_validation.blind.generators.image_formation import expected, take
from tacos_validation.blind.generators.injected_effect import InjectedEffect


def write_folder(
    folder: Path,
    camera: IdealCamera,
    acquisitions: Sequence[Acquisition],
    effects: Sequence[InjectedEffect],
    rng: np.random.Generator,
    sensor_seed: int,
    off: Mapping[str, CaptureNuisance] | None = None,
) -> None:
    folder.mkdir(parents=True)
    captures = [
        _capture(
            folder,
            camera,
            acquisition,
            effects,
            rng,
            sensor_seed,
            (off or {}).get(acquisition.id, AS_BELIEVED),
        )
        for acquisition in acquisitions
    ]
    data = {
        "tacos_captures": 1,
        "camera": {
            "width_px": camera.width_px,
            "height_px": camera.height_px,
            "pixel_um": camera.pixel_um,
            "focal_length_mm": camera.focal_px * camera.pixel_um * 1e-3,
            "principal_point_px": list(camera.centre_px),
            "f_number": 2.8,
            "bit_depth": 8,
            "white_level_dn": camera.white_dn,
            "black_level_dn": camera.black_dn,
            "channels": camera.channels,
        },
        "noise": [
            {
                "gain_db": shot.gain_db,
                "photon_dn": camera.photon_dn * shot.gain,
                "thermal_dn2": camera.thermal_dn2 * shot.gain**2,
            }
            for shot in {each.shots[0].gain_db: each.shots[0] for each in acquisitions}.values()
        ],
        "captures": captures,
    }
    (folder / "captures.yaml").write_text(yaml.safe_dump(data, sort_keys=False), "utf-8")


def _capture(
    folder: Path,
    camera: IdealCamera,
    acquisition: Acquisition,
    effects: Sequence[InjectedEffect],
    rng: np.random.Generator,
    sensor_seed: int,
    off: CaptureNuisance,
) -> dict[str, Any]:
    names: list[str] = []
    for shot in acquisition.shots:
        taken = take(off.real(shot), [*effects, *off.effects], acquisition.frames, rng, sensor_seed)
        for frame in taken:
            names.append(f"{acquisition.id}_{len(names)}.{'jpg' if off.file_quality else 'png'}")
            _write_frame(folder / names[-1], frame, off.file_quality)
    shot = acquisition.shots[0]
    entry: dict[str, Any] = {
        "id": acquisition.id,
        "kind": acquisition.kind,
        "real": names,
        "exposure_ms": shot.exposure_ms,
        **({"gain_db": shot.gain_db} if shot.gain_db else {}),
        **off.declared,
    }
    if acquisition.kind not in ("dark", "board"):
        entry["simulated"] = _simulated(folder, acquisition, off.expected_frames, rng)
    if acquisition.group:
        entry["group"] = acquisition.group
    if acquisition.board:
        board = acquisition.board
        entry["board"] = {"inner_corners": [board.columns, board.rows], "square_mm": board.square_mm}
    if acquisition.chart:
        entry["chart"] = {"patches": _write_patches(folder, camera, acquisition.id, acquisition.chart)}
    if acquisition.kind in ("scene", "bracket", "sequence"):
        entry["depth"] = f"{acquisition.id}_depth.npy"
        depth = np.full((camera.height_px, camera.width_px), shot.depth_m, np.float32)
        np.save(folder / entry["depth"], depth)
    if acquisition.kind == "sequence":
        entry["velocity_px_s"] = [float(v) for v in shot.velocity_px_s]
        entry["frame_interval_ms"] = FRAME_INTERVAL_MS
    return entry


def _simulated(
    folder: Path, acquisition: Acquisition, frames: int, rng: np.random.Generator
) -> float | str | list[str]:
    """A number for an even field of which no frames were averaged, else a file for each shot."""
    look = acquisition.shots[0].look
    if isinstance(look, Even) and not frames:
        return float(look.light_dn + acquisition.shots[0].camera.black_dn)
    names = []
    for i, shot in enumerate(acquisition.shots):
        names.append(f"{acquisition.id}_expected_{i}.npy")
        image = take(shot, (), frames, rng, 0).mean(axis=0) if frames else expected(shot)
        np.save(folder / names[-1], (image[..., 0] if image.shape[2] == 1 else image).astype(np.float32))
    return names[0] if len(names) == 1 else names


def _write_frame(path: Path, frame: Image, quality: int | None) -> None:
    pixels = frame.astype(np.uint8)
    image = Pillow.fromarray(pixels[..., 0] if pixels.shape[2] == 1 else pixels)
    if quality is None:
        image.save(path, compress_level=1)
    else:
        image.save(path, quality=quality)


def _write_patches(folder: Path, camera: IdealCamera, name: str, chart: Chart) -> str:
    file = f"{name}_patches.csv"
    with (folder / file).open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(["id", "x", "y", "width", "height", "r", "g", "b"])
        for i, (box, colour) in enumerate(zip(chart.boxes, chart.colours, strict=True)):
            writer.writerow([i, *box.tolist(), *(colour + camera.black_dn).tolist()])
    return file
