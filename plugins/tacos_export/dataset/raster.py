"""All that is known of every pixel, in 16-bit PNG or in EXR."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from tacos_export.conventions import depth_codes
from tacos_export.dataset.frame import Dataset, linear_16_bit, write_image
from tacos_framework import Fault, FrameBatch, UserError

DEPTH_CODES_PER_M = 1000.0
"""Depth files are in millimetres."""

MOST_OBJECTS = 1 << 16
"""As many ids as 16 bits tell apart, that of the background among them."""


class Png16Writer:
    """``CAMERA/image/``, ``CAMERA/depth/``, ``CAMERA/object_id/``, all of 16 bits.

    Images are linear from the black level (0) to the white level (65535), depth is in millimetres, ids are
    places in the list ``objects`` of ``frames.json``.
    """

    eight_bits: ClassVar[bool] = False

    def __init__(self, dataset: Dataset) -> None:
        self._out = dataset.out

    def add(self, index: int, frame: FrameBatch) -> None:
        """Write the images of a frame; `UserError` where its world has more objects than 16 bits number."""
        if (count := len(frame.episode.world.objects)) > MOST_OBJECTS:
            raise UserError(
                Fault(
                    "--format png16",
                    f"the scene has {count} objects",
                    f"{MOST_OBJECTS} at most, as ids have 16 bits",
                    "Choose --format exr, whose ids have 32.",
                )
            )
        for i, view in enumerate(frame.capture.views):
            folder, name = self._out / view.camera.name, f"{index:06d}.png"
            write_image(folder / "image" / name, linear_16_bit(frame, i))
            write_image(folder / "depth" / name, depth_codes(view.depth_m[0], DEPTH_CODES_PER_M))
            write_image(folder / "object_id" / name, view.object_id[0].astype(np.uint16))

    def close(self) -> None:
        """``frames.json`` says the rest."""


class ExrWriter:
    """``CAMERA/000000.exr`` with what 16 bits do not hold, beside the frames as ``CAMERA/image/`` (PNG).

    Channels ``R``, ``G``, ``B``: light before the sensor, linear sRGB primaries [cd/m2]; ``Z``: depth along
    the optical axis, infinite where nothing is [m]; ``id``: the object. Needs the package OpenEXR (extra
    ``export``).
    """

    eight_bits: ClassVar[bool] = False

    def __init__(self, dataset: Dataset) -> None:
        self._out = dataset.out
        self._openexr = _openexr()

    def add(self, index: int, frame: FrameBatch) -> None:
        for i, view in enumerate(frame.capture.views):
            folder = self._out / view.camera.name
            write_image(folder / "image" / f"{index:06d}.png", linear_16_bit(frame, i))
            light = view.luminance_cd_m2[0]
            channels = {name: np.ascontiguousarray(light[..., c]) for c, name in enumerate("RGB")}
            channels["Z"] = np.ascontiguousarray(view.depth_m[0])
            channels["id"] = np.ascontiguousarray(view.object_id[0].astype(np.uint32))
            header = {"compression": self._openexr.ZIP_COMPRESSION, "type": self._openexr.scanlineimage}
            with self._openexr.File(header, channels) as file:
                file.write(str(folder / f"{index:06d}.exr"))

    def close(self) -> None:
        """``frames.json`` says the rest."""


def _openexr() -> Any:
    try:
        import OpenEXR
    except ImportError as error:
        remedy = "Install it: pip install tacos-framework[export]; or choose --format png16."
        raise UserError(
            Fault("--format exr", "OpenEXR is not installed", "the extra export", remedy)
        ) from error
    return OpenEXR
