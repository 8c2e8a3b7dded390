"""TUM RGB-D: colour and depth images with time stamps, and the camera's true path."""

from __future__ import annotations

from typing import ClassVar

from tacos_export.conventions import depth_codes, in_file_world, quaternion_xyzw, stamp_s
from tacos_export.dataset.frame import Dataset, photograph, write_image, write_lines
from tacos_framework import FrameBatch

DEPTH_CODES_PER_M = 5000.0
"""Depth in 16 bits, as the benchmark's own files have it: up to 13 m."""


class TumWriter:
    """``rgb/``, ``depth/``, ``rgb.txt``, ``depth.txt``, ``groundtruth.txt`` in a folder for each walk.

    The first camera is written. Lines of the ground truth are ``timestamp tx ty tz qx qy qz qw``: the pose of
    the camera in the world.

    Source: Sturm et al. 2012, "A benchmark for the evaluation of RGB-D SLAM systems", IROS, and its file
    formats.
    """

    eight_bits: ClassVar[bool] = True

    def __init__(self, dataset: Dataset) -> None:
        self._dataset = dataset
        self._lines: dict[str, dict[str, list[str]]] = {}

    def add(self, index: int, frame: FrameBatch) -> None:
        view = frame.capture.views[0]
        walk = walk_folder(frame)
        folder = self._dataset.out / walk
        lines = self._lines.setdefault(walk, {"rgb": [], "depth": [], "groundtruth": []})
        stamp = stamp_s(float(frame.episode.time_s[0]))
        write_image(folder / "rgb" / f"{stamp}.png", photograph(frame, 0, self._dataset.encoding))
        write_image(folder / "depth" / f"{stamp}.png", depth_codes(view.depth_m[0], DEPTH_CODES_PER_M))
        pose = in_file_world(view.world_from_camera[0], frame.episode.world)
        numbers = " ".join(f"{value:.9f}" for value in (*pose[:3, 3], *quaternion_xyzw(pose)))
        lines["rgb"].append(f"{stamp} rgb/{stamp}.png")
        lines["depth"].append(f"{stamp} depth/{stamp}.png")
        lines["groundtruth"].append(f"{stamp} {numbers}")

    def close(self) -> None:
        for walk, lists in self._lines.items():
            for name, lines in lists.items():
                head = "timestamp tx ty tz qx qy qz qw" if name == "groundtruth" else "timestamp filename"
                write_lines(self._dataset.out / walk / f"{name}.txt", [f"# {head}", *lines])


def walk_folder(frame: FrameBatch) -> str:
    """The folder of a frame's walk: between walks the agent jumps, which no sequence does."""
    return f"walk_{frame.episode.walk[0]:03d}"
