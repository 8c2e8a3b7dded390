"""BOP: poses of objects, with their models."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_export.conventions import depth_codes, in_file_world
from tacos_export.dataset.frame import (
    Dataset,
    box_of,
    distortion_faults,
    photograph,
    visible_objects,
    write_image,
)
from tacos_export.dataset.solid import Solid
from tacos_framework import Camera, FrameBatch, UserError, World
from tacos_framework.camera import invert_pose

DEPTH_CODES_PER_M = 1000.0
"""Depth files are in millimetres: ``depth_scale`` 1."""
_MM = 1000.0
_NEAREST_M = 1e-3


class BopWriter:
    """``train/00000i/`` of the i-th camera, and ``models/``; lengths in millimetres.

    A folder has ``rgb/``, ``depth/``, ``mask/``, ``mask_visib/``, ``scene_camera.json``, ``scene_gt.json``
    and ``scene_gt_info.json``. ``obj_id`` is the object's place in the list ``objects`` of ``frames.json``;
    the origin of a model is the middle of its box, its axes are those of the world. Whole silhouettes are
    those of triangles in front of a pinhole: distorted images are refused.

    Source: Hodaň et al. 2018, "BOP: benchmark for 6D object pose estimation", ECCV, and its toolkit, "BOP
    format".
    """

    eight_bits: ClassVar[bool] = True

    def __init__(self, dataset: Dataset) -> None:
        if faults := distortion_faults(dataset, "bop"):
            raise UserError(faults)
        self._dataset = dataset
        self._solids: dict[int, Solid] = {}
        self._tables: list[dict[str, dict[str, Any]]] = [
            {"scene_camera": {}, "scene_gt": {}, "scene_gt_info": {}} for _ in dataset.rig.cameras
        ]

    def add(self, index: int, frame: FrameBatch) -> None:
        for i, view in enumerate(frame.capture.views):
            folder, name = self._scene(i), f"{index:06d}"
            depth = depth_codes(view.depth_m[0], DEPTH_CODES_PER_M)
            write_image(folder / "rgb" / f"{name}.png", photograph(frame, i, self._dataset.encoding))
            write_image(folder / "depth" / f"{name}.png", depth)
            camera_from_world = invert_pose(view.world_from_camera[0])
            poses: list[dict[str, Any]] = []
            infos: list[dict[str, Any]] = []
            for thing, visible in visible_objects(view, frame.episode.world):
                solid = self._solid(frame.episode.world, thing)
                pose = camera_from_world @ _moved(frame, thing) @ solid.world_from_model
                whole = silhouette(solid, pose, view.camera) | visible
                for kind, mask in (("mask", whole), ("mask_visib", visible)):
                    written = mask.astype(np.uint8) * np.uint8(255)
                    write_image(folder / kind / f"{name}_{len(poses):06d}.png", written)
                poses.append({"obj_id": thing, **_rigid(pose, "m2c")})
                infos.append(_info(whole, visible, depth > 0))
            matrix = view.camera.intrinsics.ravel().tolist()
            camera_from_file = invert_pose(in_file_world(view.world_from_camera[0], frame.episode.world))
            entry = {"cam_K": matrix, "depth_scale": 1.0, **_rigid(camera_from_file, "w2c")}
            for table, value in zip(self._tables[i].values(), (entry, poses, infos), strict=True):
                table[str(index)] = value

    def close(self) -> None:
        for i, tables in enumerate(self._tables):
            for name, table in tables.items():
                _write_json(self._scene(i) / f"{name}.json", table)
        models = self._dataset.out / "models"
        for thing, solid in self._solids.items():
            solid.write_ply(models / f"obj_{thing:06d}.ply", _MM)
        _write_json(models / "models_info.json", {str(n): s.info(_MM) for n, s in self._solids.items()})

    def _scene(self, camera: int) -> Path:
        return self._dataset.out / "train" / f"{camera:06d}"

    def _solid(self, world: World, thing: int) -> Solid:
        if thing not in self._solids:
            self._solids[thing] = Solid.of_object(world, thing)
        return self._solids[thing]


def silhouette(solid: Solid, camera_from_model: NDArray[np.float64], camera: Camera) -> NDArray[np.bool_]:
    """(H, W) where a model would be seen if nothing hid it, but for what reaches behind the camera."""
    points = solid.vertices_m @ camera_from_model[:3, :3].T + camera_from_model[:3, 3]
    corners = points[solid.triangles]
    corners = corners[(corners[..., 2] > _NEAREST_M).all(axis=1)]
    pixels = corners @ camera.intrinsics.T
    places = np.clip(pixels[..., :2] / pixels[..., 2:], -1e4, 1e4)
    mask = np.zeros((camera.height_px, camera.width_px), np.uint8)
    for triangle in np.rint(places * 16).astype(np.int32):
        cv2.fillConvexPoly(mask, triangle, 1, shift=4)
    return mask.astype(bool)


def _moved(frame: FrameBatch, thing: int) -> NDArray[np.float64]:
    """(4, 4) from where an object rests to where it is in the middle of the exposure."""
    for mover in frame.episode.movers:
        if mover.object_id == thing:
            return mover.trajectory.at(frame.episode.time_s)[0]
    return np.eye(4)


def _rigid(pose: NDArray[np.float64], name: str) -> dict[str, list[float]]:
    return {
        f"cam_R_{name}": pose[:3, :3].ravel().tolist(),
        f"cam_t_{name}": (pose[:3, 3] * _MM).tolist(),
    }


def _info(
    whole: NDArray[np.bool_], visible: NDArray[np.bool_], has_depth: NDArray[np.bool_]
) -> dict[str, Any]:
    counts = int(whole.sum()), int(visible.sum())
    return {
        "bbox_obj": _box(whole),
        "bbox_visib": _box(visible),
        "px_count_all": counts[0],
        "px_count_valid": int((whole & has_depth).sum()),
        "px_count_visib": counts[1],
        "visib_fract": counts[1] / counts[0],
    }


def _box(mask: NDArray[np.bool_]) -> list[int]:
    left, top, right, bottom = box_of(mask)
    return [left, top, right - left + 1, bottom - top + 1]


def _write_json(path: Path, data: object) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
