"""Writes captures as a folder that `read_captures` reads."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.settings.yaml_writer import to_yaml
from tacos_gap.captures.capture import Noise, RealCapture
from tacos_gap.captures.files import PATCH_COLUMNS
from tacos_gap.captures.reader import FILE


def write_captures(folder: str | Path, captures: Iterable[RealCapture]) -> Path:
    """Write images and ``captures.yaml``; returns its path.

    Frames of whole numbers become PNG, of 8 bits where the white level allows it and of 16 where not; other
    frames, expectations, depth and motion become ``.npy``. An expectation that is the same everywhere is
    written as a number.

    Parameters
    ----------
    folder
        Where to; made if it is not there.
    captures
        Taken one after another, all of one camera: equal focal length, pitch, sensor size, principal point,
        levels and filters.

    Raises
    ------
    ValueError
        When the captures are not of one camera, or ids would share a folder.
    """
    folder = Path(folder)
    camera: dict[str, Any] = {}
    first: dict[str, Any] = {}
    noise: dict[float, Noise] = {}
    entries: list[dict[str, Any]] = []
    taken: set[str] = set()
    for capture in captures:
        described = _camera_of(capture)
        if not first:
            first, camera = described, _camera_entry(capture, described)
        if differing := [key for key, value in described.items() if not _alike(value, first[key])]:
            raise ValueError(
                f"captures {entries[0]['id']!r} and {capture.id!r} differ in {', '.join(differing)}: "
                f"those of a folder are of one camera"
            )
        if noise.setdefault(capture.context.gain_db, capture.noise) != capture.noise and capture.noise.known:
            raise ValueError(f"captures at {capture.context.gain_db:g} dB have different noise")
        name = _safe(capture.id)
        if name.lower() in taken:
            raise ValueError(f"captures need ids that differ as names of folders: {capture.id!r} does not")
        taken.add(name.lower())
        (folder / name).mkdir(parents=True, exist_ok=True)
        entries.append(_entry(folder, name, capture, camera))
    if not entries:
        raise ValueError("there are no captures to write")
    data = {"tacos_captures": 1, "camera": camera, "noise": _noise(noise), "captures": entries}
    text = to_yaml(data, flow_style=None)
    (folder / FILE).write_text(text, encoding="utf-8")
    return folder / FILE


def _safe(name: str) -> str:
    """A capture's id as the name of a folder."""
    return re.sub(r"[^\w.-]", "_", name).strip(".")[:60] or "_"


# camera and noise -----------------------------------------------------------------------------------------


def _camera_entry(capture: RealCapture, described: Mapping[str, Any]) -> dict[str, Any]:
    """The entry ``camera``, as files like those of this capture have it."""
    geometry = capture.geometry
    x, y = geometry.offset_px
    shared = {key: value for key, value in described.items() if key not in ("full", "centre")}
    return {
        "width_px": geometry.width_px,
        "height_px": geometry.height_px,
        "crop": {"x": x, "y": y, **described["full"]},
        **(
            {}
            if "principal_point" in capture.unstated
            else {"principal_point_px": [float(c) for c in geometry.centre_px]}
        ),
        **{key: value for key, value in shared.items() if value is not None},
    }


def _camera_of(capture: RealCapture) -> dict[str, Any]:
    """What all captures of a camera share; the centre on the full sensor."""
    geometry, context = capture.geometry, capture.context
    white = float(context.white_level_dn)
    bits = max(1, math.ceil(math.log2(white + 1)))
    return {
        "full": {"full_width_px": geometry.full_width_px, "full_height_px": geometry.full_height_px},
        "centre": [c + o for c, o in zip(geometry.centre_px, geometry.offset_px, strict=True)],
        "pixel_um": float(geometry.pixel_um),
        "focal_length_mm": (
            None if "focal_length" in capture.unstated else geometry.focal_length_px * geometry.pixel_um / 1e3
        ),
        "f_number": context.f_number,
        "bit_depth": bits,
        "white_level_dn": None if white == 2**bits - 1 else white,
        "black_level_dn": float(context.black_level_dn),
        "channels": capture.real_dn.shape[-1],
        "cfa": context.cfa,
    }


def _alike(first: Any, second: Any) -> bool:
    if isinstance(first, list):
        return bool(np.allclose(first, second))
    return bool(math.isclose(first, second)) if isinstance(first, float) else bool(first == second)


def _noise(by_gain: Mapping[float, Noise]) -> Any:
    if not all(noise.known for noise in by_gain.values()):
        return "unknown"
    return [
        {"gain_db": gain_db, "photon_dn": _numbers(n.photon_dn), "thermal_dn2": _numbers(n.thermal_dn2)}
        for gain_db, n in by_gain.items()
    ]


def _numbers(values: Sequence[float]) -> Any:
    return float(values[0]) if len(set(values)) == 1 else [float(value) for value in values]


# a capture ------------------------------------------------------------------------------------------------


def _entry(folder: Path, name: str, capture: RealCapture, camera: Mapping[str, Any]) -> dict[str, Any]:
    geometry, context = capture.geometry, capture.context
    entry: dict[str, Any] = {"id": capture.id, "kind": capture.kind, "real": _frames(folder, name, capture)}
    if capture.expected_dn is not None:
        entry["simulated"] = _expected(folder, name, capture.expected_dn)
    if capture.exposure_stated:
        entry["exposure_ms"] = context.exposure_s * 1e3
    if context.gain_db:
        entry["gain_db"] = float(context.gain_db)
    if capture.group is not None:
        entry["group"] = capture.group
    if capture.level_uncertainty:
        entry["level_uncertainty"] = capture.level_uncertainty
    if not capture.valid.all():
        entry["mask"] = _image(folder, f"{name}/mask.png", capture.valid.astype(np.uint8) * 255)
    if capture.expected_frames:
        entry["simulated_frames"] = capture.expected_frames
    if (geometry.width_px, geometry.height_px) != (camera["width_px"], camera["height_px"]):
        entry |= {"width_px": geometry.width_px, "height_px": geometry.height_px}
    crop = {
        "x": geometry.offset_px[0],
        "y": geometry.offset_px[1],
        "full_width_px": geometry.full_width_px,
        "full_height_px": geometry.full_height_px,
    }
    if crop != camera["crop"]:
        entry["crop"] = crop
    if capture.board is not None:
        board = capture.board
        entry["board"] = {"inner_corners": list(board.inner_corners), "square_mm": board.square_mm}
        if board.pattern != "chessboard":
            entry["board"]["pattern"] = board.pattern
        if board.pattern == "charuco":
            entry["board"] |= {"marker_mm": board.marker_mm, "dictionary": board.dictionary}
    if capture.edge_angle_deg is not None:
        entry["edge"] = {"angle_deg": capture.edge_angle_deg}
    if capture.patches is not None:
        entry["chart"] = {"patches": _patches(folder, name, *capture.patches)}
    if capture.objects is not None:
        ids = _array(folder, f"{name}/objects.npy", capture.objects.ids)
        entry["objects"] = {"ids": ids, "classes": list(capture.objects.classes[1:])}
    return entry | _scene_of(folder, name, capture)


def _scene_of(folder: Path, name: str, capture: RealCapture) -> dict[str, Any]:
    """Depth, motion, readout and time."""
    context = capture.context
    entry: dict[str, Any] = {}
    if context.depth_m is not None:
        entry["depth"] = _array(folder, f"{name}/depth.npy", np.asarray(context.depth_m, np.float32))
    if context.velocity_px_s is not None:
        velocity = np.asarray(context.velocity_px_s)
        entry["velocity_px_s"] = (
            velocity.tolist()
            if velocity.ndim == 1
            else _array(folder, f"{name}/velocity.npy", velocity.astype(np.float32))
        )
    if context.frame_interval_s is not None:
        entry["frame_interval_ms"] = context.frame_interval_s * 1e3
    if capture.row_time_us:
        entry["row_time_us"] = capture.row_time_us
    if context.reference_row:
        entry["row_time_reference"] = context.reference_row
    if capture.motion_blurred:
        entry["motion_blurred"] = True
    if capture.taken_s is not None:
        entry["taken_s"] = float(capture.taken_s)
    return entry


def _frames(folder: Path, name: str, capture: RealCapture) -> list[str]:
    real = capture.real_dn
    whole = (
        bool((real == np.rint(real)).all()) and real.min() >= 0 and capture.context.white_level_dn <= 65535
    )
    if not whole:
        return [_array(folder, f"{name}/{i:03}.npy", frame) for i, frame in enumerate(real)]
    dtype = np.uint8 if capture.context.white_level_dn <= 255 else np.uint16
    return [_image(folder, f"{name}/{i:03}.png", frame.astype(dtype)) for i, frame in enumerate(real)]


def _expected(folder: Path, name: str, expected_dn: NDArray[np.float32]) -> Any:
    if expected_dn.min() == expected_dn.max() and len(expected_dn) == 1:
        return float(expected_dn.flat[0])
    if len(expected_dn) == 1:
        return _array(folder, f"{name}/expected.npy", expected_dn[0])
    return [_array(folder, f"{name}/expected_{i:03}.npy", image) for i, image in enumerate(expected_dn)]


def _patches(
    folder: Path,
    name: str,
    boxes: NDArray[np.int64],
    colours: NDArray[np.float64],
) -> str:
    path = f"{name}/patches.csv"
    with (folder / path).open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(("id", *PATCH_COLUMNS))
        for i, (box, colour) in enumerate(zip(boxes.tolist(), colours.tolist(), strict=True)):
            table.writerow((i + 1, *box, *colour))
    return path


def _array(folder: Path, path: str, array: NDArray[Any]) -> str:
    np.save(folder / path, array)
    return path


def _image(folder: Path, path: str, image: NDArray[Any]) -> str:
    import cv2

    if image.ndim == 3 and image.shape[-1] == 3:
        image = np.ascontiguousarray(image[..., ::-1])
    if not cv2.imwrite(str(folder / path), image, [cv2.IMWRITE_PNG_COMPRESSION, 1]):
        raise OSError(f"{folder / path} cannot be written")
    return path
