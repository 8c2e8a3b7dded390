"""The folder of a recording, from frames that were found."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from tacos_files.camera_images import LOSSY_SUFFIXES
from tacos_framework import UserError
from tacos_framework.files import made_folder
from tacos_worlds.recorded.found_response import RESPONSE
from tacos_worlds.recorded.imports.found import FoundRecording
from tacos_worlds.recorded.reader import read_recording
from tacos_worlds.recorded.times import TIMES

_GREEN = 1


def write_recording(found: FoundRecording, out: Path, exposure_ms: float | None) -> list[str]:
    """Frames, ``times.csv``, ``camera.yaml`` and ``response.txt``; what to know about them, in sentences.

    `exposure_ms`: exposure of frames that do not state their own [ms]. Raises UserError when the folder
    exists and is not empty, or a frame cannot be read.
    """
    made_folder(out)
    lines, coloured, unknown = dict[int, str](), 0, 0
    digits = len(str(len(found.frames)))
    places = np.argsort(np.argsort([each.stamp_ns for each in found.frames], kind="stable"))
    for frame, number in zip(
        found.frames, places.tolist(), strict=True
    ):  # in their order, as videos are read
        image = np.squeeze(frame.read())
        if image.ndim == 3:
            image, coloured = image[..., _GREEN], coloured + 1
        own_ms = frame.exposure_ms if frame.exposure_ms is not None else exposure_ms
        unknown += own_ms is None
        name = f"{number:0{digits}d}.png"
        cv2.imwrite(str(out / name), image if image.dtype == np.uint8 else image.astype(np.uint16))
        lines[number] = f"{name},{frame.stamp_ns},{'' if own_ms is None else f'{own_ms:g}'}"
    rows = [lines[number] for number in sorted(lines)]
    (out / TIMES).write_text("\n".join(["file,taken_ns,exposure_ms", *rows]) + "\n", encoding="utf-8")
    if found.camera:
        (out / "camera.yaml").write_text(found.camera, encoding="utf-8")
    if found.response:
        (out / RESPONSE).write_text(found.response, encoding="utf-8")
    said = [f"{len(found.frames)} frames ({found.layout}) in {out}."]
    if coloured:
        said.append(f"{coloured} frames have colours: their green is taken, whose noise neighbours share.")
    lossy = sum(Path(frame.name).suffix.lower() in LOSSY_SUFFIXES for frame in found.frames)
    if lossy:
        said.append(
            f"{lossy} frames are coded with loss (JPEG, WebP): noise and response found from them are also "
            "those of the coding. Record raw frames for a diagnosis."
        )
    if unknown:
        said.append(
            f"The exposure of {unknown} frames is unknown: state it by --exposure-ms, or in {out / TIMES}."
        )
        return said
    try:
        several = len({frame.exposure_ms for frame in found.frames}) > 1
        read_recording(out, fewest=1, response="recorded" if found.response or several else "linear")
    except UserError as error:
        said += [
            f"{fault.where}: {fault.what} (expected {fault.expected}). {fault.remedy}"
            for fault in error.faults
        ]
    return said
