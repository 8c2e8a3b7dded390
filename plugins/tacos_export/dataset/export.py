"""A data set, frame by frame, in one format."""

from __future__ import annotations

import importlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tacos_export.camera.description import lens_of
from tacos_export.conventions import in_file_world, stamp_ns
from tacos_export.dataset.frame import Dataset, DatasetCamera, DatasetWriter, Encoding
from tacos_framework import Fault, FrameBatch, UserError, World, __version__, did_you_mean
from tacos_framework.camera import Exposed, exposed, mean_exposed
from tacos_framework.files import made_folder
from tacos_plugins.effects.tone_curve import ToneCurve
from tacos_view.setup import RenderSetup

FORMATS = {
    "coco": "tacos_export.dataset.coco:CocoWriter",
    "kitti": "tacos_export.dataset.kitti:KittiWriter",
    "euroc": "tacos_export.dataset.euroc:EurocWriter",
    "tum": "tacos_export.dataset.tum:TumWriter",
    "yolo": "tacos_export.dataset.yolo:YoloWriter",
    "bop": "tacos_export.dataset.bop:BopWriter",
    "nerf": "tacos_export.dataset.nerf:NerfWriter",
    "colmap": "tacos_export.dataset.colmap:ColmapWriter",
    "png16": "tacos_export.dataset.raster:Png16Writer",
    "exr": "tacos_export.dataset.raster:ExrWriter",
}
"""The formats, and what writes them."""


def export_dataset(
    setup: RenderSetup,
    out: Path,
    format: str,
    *,
    frames: int,
    seed: int | None = None,
    encoding: Encoding | None = None,
    progress: Callable[[int], None] | None = None,
) -> list[str]:
    """Render frames and write them as a data set.

    - `out`: the folder: new or empty.
    - `format`: one of `FORMATS`.
    - `frames`: how many consecutive frames of one trip, which may be over before.
    - `seed`: which world; the recipe's if None.
    - `encoding`: how 8-bit images are encoded; None is ``srgb`` unless the recipe has a tone curve of its
      own.
    - `progress`: told the number of frames written.

    Returns: in a sentence each, what a user of the data should know.

    Raises UserError when there is no such format, it has no place for the rig or the encoding, or the folder
    is not empty.
    """
    writer_class = _writer(format)
    if out.is_dir() and any(out.iterdir()):
        raise UserError(Fault(str(out), "the folder is not empty", "a new folder", "Name another by --out."))
    lenses, notes = {}, []
    for camera in setup.rig.cameras:
        lens, distortion, said = lens_of(setup.effects, camera)
        lenses[camera.name] = DatasetCamera(lens, distortion)
        notes += [f"{camera.name}: {each}" for each in said]
    curved = any(issubclass(effect.cls, ToneCurve) for effect in setup.effects)
    if encoding == "srgb" and not writer_class.eight_bits:
        what = f"images of {format} have 16 bits of the camera's own numbers"
        raise UserError(Fault("--encoding srgb", what, "a format of 8 bits", "Leave --encoding out."))
    encoding = encoding or ("camera" if curved else "srgb")
    dataset = Dataset(out, setup.rig, lenses, encoding)
    writer = writer_class(dataset)
    made_folder(out)  # nothing is left of a format that refuses the rig
    as_taken = "camera" if curved else "linear"
    manifest = Manifest(dataset, setup.camera.title, encoding if writer_class.eight_bits else as_taken)
    count = 0
    for index, frame in enumerate(setup.frames(frames, seed=seed)):
        writer.add(index, frame)
        manifest.add(frame)
        count = index + 1
        if progress:
            progress(count)
    notes += manifest.doubts
    if count < frames:
        notes.append(f"the trip ends after {count} of {frames} frames")
    writer.close()
    manifest.write(out / "frames.json")
    return notes


def _writer(format: str) -> type[DatasetWriter]:
    if format not in FORMATS:
        raise UserError(
            Fault("--format", f"there is no format {format!r}", "", did_you_mean(format, FORMATS))
        )
    module, _, name = FORMATS[format].partition(":")
    writer: type[DatasetWriter] = getattr(importlib.import_module(module), name)
    return writer


class Manifest:
    """``frames.json``: cameras, poses and objects, the same beside every format.

    `encoding`: what the numbers of images are: srgb, camera (the camera's own digital numbers), or linear.
    """

    def __init__(self, dataset: Dataset, title: str, encoding: str) -> None:
        self._data: dict[str, Any] = {
            "tacos": __version__,
            "camera": title,
            "encoding": encoding,
            "conventions": "x right, y down, z forward; metres; pixel (0, 0) has its centre at (0, 0); depth "
            "is along z, or along the ray where depth_along says so; poses take points of the camera to the "
            "world",
            "cameras": {
                camera.name: {
                    "width_px": camera.width_px,
                    "height_px": camera.height_px,
                    "intrinsics": camera.intrinsics.tolist(),
                    "lens": dataset.lenses[camera.name].lens,
                    "distortion": list(dataset.lenses[camera.name].distortion),
                    "depth_along": "axis" if camera.lens.is_rectilinear else "ray",
                    "body_from_camera": camera.agent_from_camera.tolist(),
                }
                for camera in dataset.rig.cameras
            },
            "frames": [],
        }
        self._world: World | None = None
        self._exposed: dict[str, list[Exposed]] = {camera.name: [] for camera in dataset.rig.cameras}

    @property
    def doubts(self) -> list[str]:
        """Advice where frames are over- or underexposed, in a sentence for each camera."""
        means = ((name, mean_exposed(frames)) for name, frames in self._exposed.items() if frames)
        return [f"{name}: {mean.doubt}" for name, mean in means if mean.doubt]

    def add(self, frame: FrameBatch) -> None:
        self._world = frame.episode.world
        for camera, image in zip(self._exposed.values(), frame.images, strict=True):
            camera.append(exposed(image, frame.black_level_dn, frame.white_level_dn))
        self._data["frames"].append(
            {
                "time_s": float(frame.episode.time_s[0]),
                "stamp_ns": stamp_ns(float(frame.episode.time_s[0])),
                "walk": int(frame.episode.walk[0]),
                "world_from_camera": {
                    view.camera.name: in_file_world(view.world_from_camera[0], self._world).tolist()
                    for view in frame.capture.views
                },
            }
        )

    def write(self, path: Path) -> None:
        objects = self._world.objects if self._world else ()
        for name, frames in self._exposed.items():
            if frames:
                self._data["cameras"][name] |= {"exposed": mean_exposed(frames)._asdict()}
        listed = [{"name": thing.name, "class": thing.class_name} for thing in objects]
        path.write_text(json.dumps({**self._data, "objects": listed}, indent=1) + "\n", encoding="utf-8")
