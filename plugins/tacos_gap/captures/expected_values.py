"""Expected values of each capture: files, a number, or a recipe that is rendered."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tacos_framework import UserError
from tacos_gap.captures.entries import CaptureEntry, FolderEntry
from tacos_gap.captures.files import MAX_FRAMES, CaptureFiles

Render = Callable[[Path, str], NDArray[np.float32]]
"""Renders the expected values of a capture, (1 or N, H, W, C) [DN], from a recipe and the capture's id."""


class ExpectedValues:
    def __init__(self, entry: FolderEntry, files: CaptureFiles, render: Render | None):
        self._entry = entry
        self._files = files
        self._render = render

    def of(
        self, i: int, entry: CaptureEntry, shape: tuple[int, int], frames: int, *, usable: bool
    ) -> NDArray[np.float32] | None:
        """(1 or N, H, W, C) what is expected of a capture [DN]; None where there is nothing, or a fault."""
        given, camera = entry.simulated, self._entry.camera
        if entry.kind == "board":
            return None
        if isinstance(given, float) or (given is None and entry.kind == "dark"):
            if not usable:  # nor may its size be taken at its word
                return None
            level = camera.black_level_dn if given is None else given
            return np.full((1, *shape, camera.channels), level, np.float32)
        if given is not None:
            paths = self._files.found(i, "simulated", given)
            if frames and self._one_or_one_per_frame(i, "simulated", len(paths), frames):
                return _once(self._files.stack(i, "simulated", paths[:MAX_FRAMES], shape))
            return None
        return self._rendered(i, entry, entry.scene, shape, frames) if entry.scene else None

    def _one_or_one_per_frame(self, i: int, key: str, expected: int, frames: int) -> bool:
        if expected > 1 and expected != frames:
            self._files.fault(
                ("captures", i, key),
                f"{self._entry.captures[i].id!r} expects {expected} images and has {frames} frames",
                "one, or one per frame",
            )
            return False
        return True

    def _rendered(
        self, i: int, entry: CaptureEntry, scene: str, shape: tuple[int, int], frames: int
    ) -> NDArray[np.float32] | None:
        files = self._files
        if self._render is None:
            files.fault(("captures", i, "scene"), "nothing renders recipes here", "simulated: FILE")
            return None
        before = len(files.faults)
        try:
            images = self._render(files.folder / scene, entry.id)
        except UserError as error:
            for fault in error.faults:
                files.fault(
                    ("captures", i, "scene"), f"{fault.where}: {fault.what}", fault.expected, fault.remedy
                )
            return None
        wanted = (*shape, self._entry.camera.channels)
        if images.shape[1:] != wanted:
            files.fault(
                ("captures", i, "scene"),
                f"{scene} renders images of {images.shape[1:]}",
                f"{wanted}: height, width, channels of the files",
                "Give the recipe the camera of the files.",
            )
        self._one_or_one_per_frame(i, "scene", len(images), frames)
        return images[:MAX_FRAMES] if len(files.faults) == before else None


def _once(images: NDArray[np.float32] | None) -> NDArray[np.float32] | None:
    """Images that are all the same as one: frames that repeat it tell noise from fixed patterns."""
    return images[:1] if images is not None and (images == images[:1]).all() else images
