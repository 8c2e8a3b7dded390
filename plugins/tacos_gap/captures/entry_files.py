"""The files of one capture, and what ``captures.yaml`` says of it."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.capture import RealCapture
from tacos_gap.captures.files import PATCH_COLUMNS


def written_entry(folder: Path, name: str, capture: RealCapture, camera: Mapping[str, Any]) -> dict[str, Any]:
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
