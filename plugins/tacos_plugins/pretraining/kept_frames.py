"""Frames kept on disk, to be trained on again and again: images, depth and ids, no light and geometry."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tacos_files.arrays import read_npz
from tacos_framework import (
    Capture,
    Episode,
    Fault,
    FrameBatch,
    Object,
    Rig,
    Trajectory,
    UserError,
    View,
    World,
)


def write_frames(path: Path, frames: FrameBatch) -> None:
    """Keep a batch, whole or not at all."""
    episode, world = frames.episode, frames.episode.world
    arrays: dict[str, Any] = {
        "objects": np.array([thing.name for thing in world.objects]),
        "classes_of_objects": np.array([thing.class_name for thing in world.objects]),
        "class_names": np.array(world.class_names),
        "time_s": episode.time_s,
        "walk": episode.walk,
        "levels_dn": np.array([frames.black_level_dn, frames.white_level_dn]),
    }
    for i, (image, view) in enumerate(zip(frames.images, frames.capture.views, strict=True)):
        arrays |= {
            f"image_{i}": image,
            f"pose_{i}": view.world_from_camera,
            f"depth_m_{i}": view.depth_m,
            f"object_id_{i}": view.object_id,
        }
    packed = io.BytesIO()
    np.savez_compressed(packed, **arrays)
    partial = path.with_name(f"{path.name}.partial")
    partial.write_bytes(packed.getvalue())
    partial.replace(path)


def read_frames(path: Path, rig: Rig) -> FrameBatch:
    """A batch kept by `write_frames`, taken by the cameras of `rig`.

    Its light is zero, and its world has objects and classes but no surfaces: tasks see images, depth and ids.
    """
    arrays = read_npz(path)
    world = World(
        key=path.stem,
        parts=(),
        materials=(),
        objects=tuple(
            Object(str(name), str(of))
            for name, of in zip(arrays["objects"], arrays["classes_of_objects"], strict=True)
        ),
        class_names=tuple(map(str, arrays["class_names"])),
    )
    still = Trajectory(np.zeros(1), np.eye(4)[None])
    episode = Episode(world, still, arrays["time_s"], arrays["walk"])
    views = tuple(
        View(
            camera,
            arrays[f"pose_{i}"],
            np.broadcast_to(np.float32(0), (*arrays[f"depth_m_{i}"].shape, 3)),
            arrays[f"depth_m_{i}"],
            arrays[f"object_id_{i}"],
        )
        for i, camera in enumerate(rig.cameras)
    )
    images = tuple(arrays[f"image_{i}"] for i in range(len(views)))
    black_dn, white_dn = map(float, arrays["levels_dn"])
    return FrameBatch(Capture(episode, views), images, black_dn, white_dn)


@dataclass(frozen=True)
class KeptFrames:
    """Frames on disk: each file and the rig that took it."""

    files: tuple[tuple[Path, Rig], ...]

    def __post_init__(self) -> None:
        if not self.files:
            raise UserError(Fault("frames", "no images could be rendered", "", "See log.txt for why."))

    def __iter__(self) -> Iterator[FrameBatch]:
        for file, rig in self.files:
            yield read_frames(file, rig)

    def shuffled(self, rng: np.random.Generator) -> KeptFrames:
        return KeptFrames(tuple(self.files[int(i)] for i in rng.permutation(len(self.files))))

    @property
    def images(self) -> int:
        return sum(len(batch.episode) * len(batch.images) for batch in self)
