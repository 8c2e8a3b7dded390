"""Frames of one static scene from files of a camera: grey, colour, or a Bayer mosaic."""

from __future__ import annotations

import glob
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tacos_files.camera_images import PICTURE_SUFFIXES, check_bit_depth, read_frame
from tacos_framework import Fault, UserError

Mosaic = Literal["none", "RGGB", "BGGR", "GRBG", "GBRG"]
"""The colours of the 2 x 2 photosites at the top left of a file, row by row; none where it is no mosaic."""

_COLOURS = {1: ("mono",), 3: ("R", "G", "B")}


@dataclass(frozen=True, eq=False)
class FrameStack:
    """Frames of one scene, taken apart by channel."""

    planes: Mapping[str, Sequence[NDArray[Any]]]
    """For each channel its (F, H, W) uint8 or uint16 arrays; two for the green of a mosaic [DN]."""
    source: str
    """Origin of the frames, for messages."""

    @property
    def frames(self) -> int:
        return len(next(iter(self.planes.values()))[0])

    @property
    def picture(self) -> NDArray[Any]:
        """The first frame, (H, W, C); of a mosaic at half its size [DN]."""
        return np.stack([planes[0][0] for planes in self.planes.values()], axis=-1)


def stack_of(frames: NDArray[Any], source: str, mosaic: Mosaic = "none") -> FrameStack:
    """Take (F, H, W) or (F, H, W, C) frames apart by channel."""
    if mosaic != "none":
        if frames.ndim != 3:
            raise UserError(
                Fault(
                    source, f"cfa is {mosaic}, but the frames have {frames.shape[-1]} channels", "one channel"
                )
            )
        planes: dict[str, list[NDArray[Any]]] = {"R": [], "G": [], "B": []}
        for place, colour in enumerate(mosaic):
            planes[colour].append(frames[:, place // 2 :: 2, place % 2 :: 2])
        even = [of_colour[0].shape[1:] for of_colour in planes.values()]
        height, width = np.min(even, axis=0)
        return FrameStack(
            {colour: [p[:, :height, :width] for p in of_colour] for colour, of_colour in planes.items()},
            source,
        )
    if frames.ndim == 3:
        frames = frames[..., None]
    if frames.shape[-1] not in _COLOURS:
        raise UserError(Fault(source, f"the frames have {frames.shape[-1]} channels", "1 or 3"))
    return FrameStack({name: [frames[..., i]] for i, name in enumerate(_COLOURS[frames.shape[-1]])}, source)


def read_stack(pattern: str, mosaic: Mosaic = "none", bit_depth: int = 8) -> FrameStack:
    """Read the frames of a folder, or those that a glob finds, in the order of their names.

    Raises `UserError` when there are none, or with every file that cannot be read or does not match the
    first.
    """
    folder = Path(pattern)
    found = sorted(folder.iterdir()) if folder.is_dir() else sorted(map(Path, glob.glob(pattern)))
    paths = [path for path in found if path.suffix.lower() in PICTURE_SUFFIXES]
    if not paths:
        raise UserError(
            Fault(
                pattern, "there are no frames here", "a folder or a glob of PNG, TIFF, npy, PGM or RAW files"
            )
        )
    images: list[NDArray[Any]] = []
    faults: list[Fault] = []
    for path in paths:
        try:
            image = read_frame(path, str(path))
            check_bit_depth(image, bit_depth, str(path), path.name)
        except UserError as error:
            faults += error.faults
            continue
        if images and (image.shape, image.dtype) != (images[0].shape, images[0].dtype):
            what = f"this frame is {_form(image)}"
            faults.append(Fault(str(path), what, f"{_form(images[0])}, as {paths[0].name}"))
        else:
            images.append(image)
    if faults:
        raise UserError(faults)
    frames = np.stack(images)
    return stack_of(frames[..., 0] if frames.shape[-1] == 1 else frames, pattern, mosaic)


def _form(image: NDArray[Any]) -> str:
    return f"{image.dtype} {' x '.join(map(str, image.shape))}"
