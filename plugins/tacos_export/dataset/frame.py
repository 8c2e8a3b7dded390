"""A frame on its way into files."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Literal, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_export.camera.lens import LensModel
from tacos_framework import Fault, FrameBatch, Rig, UserError, View, World
from tacos_framework.camera import display_image

Encoding = Literal["srgb", "camera"]
"""8-bit images as photographs are encoded, or the camera's own digital numbers."""


@dataclass(frozen=True)
class DatasetCamera:
    """The distortion that images of a camera have."""

    lens: LensModel
    distortion: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Dataset:
    """Facts that writers need before the first frame comes."""

    out: Path
    rig: Rig
    lenses: dict[str, DatasetCamera]  # their distortion, by name
    encoding: Encoding  # how 8-bit images are encoded


class DatasetWriter(Protocol):
    """Writes frames in one format, as they come."""

    eight_bits: ClassVar[bool]
    """Whether its images have 8 bits, as `Dataset.encoding` says, or 16 of the camera's own numbers."""

    def __init__(self, dataset: Dataset) -> None:
        """Write nothing yet; `UserError` where the format has no place for such a rig."""
        ...

    def add(self, index: int, frame: FrameBatch) -> None:
        """Write the frame of that number: a batch of one."""
        ...

    def close(self) -> None:
        """Write what stands once for the whole set."""
        ...


def photograph(frame: FrameBatch, camera: int, encoding: Encoding) -> NDArray[np.unsignedinteger]:
    """The image of one camera, (H, W, C) as it goes into a file [codes]."""
    image = frame.images[camera][0]
    if encoding == "camera":
        return image
    return display_image(image, frame.black_level_dn, frame.white_level_dn, coded=frame.coded)


def linear_16_bit(frame: FrameBatch, camera: int) -> NDArray[np.uint16]:
    """The image of one camera, (H, W, C): 0 is the black level, 65535 the white level."""
    span = frame.white_level_dn - frame.black_level_dn
    linear = (frame.images[camera][0].astype(np.float64) - frame.black_level_dn) / span
    return np.rint(np.clip(linear, 0.0, 1.0) * 65535).astype(np.uint16)


def write_image(path: Path, image: NDArray[np.unsignedinteger]) -> None:
    """Write an (H, W), (H, W, 1) or (H, W, 3) RGB image of 8 or 16 bits as PNG."""
    path.parent.mkdir(parents=True, exist_ok=True)
    ordered = image[..., ::-1] if image.ndim == 3 and image.shape[-1] == 3 else image
    if not cv2.imwrite(str(path), np.ascontiguousarray(ordered)):
        raise UserError(Fault(str(path), "the image could not be written", "a disk with room"))


def write_lines(path: Path, lines: Iterable[str]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")


def refuse_k3(dataset: Dataset, format: str) -> None:
    """`UserError` where a lens has a k3, for which a format has no place."""
    if unsaid := [n for n, lens in dataset.lenses.items() if lens.lens == "brown" and lens.distortion[4]]:
        what = f"the lens of {', '.join(unsaid)} has k3, which its lens model has not"
        raise UserError(Fault(f"--format {format}", what, "k1, k2, p1, p2", "Choose another format."))


def distortion_faults(dataset: Dataset, format: str) -> list[Fault]:
    """A fault where images are distorted, of which a format knows nothing."""
    distorted = [
        name for name, lens in dataset.lenses.items() if lens.lens == "fisheye" or any(lens.distortion)
    ]
    what = f"images of {', '.join(distorted)} are distorted"
    return [Fault(f"--format {format}", what, "rectified images")] if distorted else []


def visible_objects(view: View, world: World) -> list[tuple[int, NDArray[np.bool_]]]:
    """The labelled objects a frame shows, each with its (H, W) mask; the background is none."""
    ids = view.object_id[0]
    background = world.objects[0].class_name
    shown = [int(each) for each in np.unique(ids) if world.objects[each].class_name != background]
    return [(each, ids == each) for each in shown]


def labelled_classes(world: World) -> list[str]:
    return [name for name in world.class_names if name != world.objects[0].class_name]


def box_of(mask: NDArray[np.bool_]) -> tuple[int, int, int, int]:
    """First and last column and row of a mask with at least one pixel: left, top, right, bottom [px].

    >>> box_of(np.array([[0, 0, 0], [0, 1, 1]], bool))
    (1, 1, 2, 1)
    """
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return int(columns[0]), int(rows[0]), int(columns[-1]), int(rows[-1])
