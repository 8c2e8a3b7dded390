"""Poses of cameras without times: COLMAP and NeRF.

Source: Schoenberger and Frahm 2016, COLMAP, ``images.txt``: ``id qw qx qy qz tx ty tz camera name``, world to
camera, each before a line of its points. Mildenhall et al. 2020, NeRF, ``transforms.json``: camera to world,
x right, y up, z back.
"""

from __future__ import annotations

import json
import re
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tacos_worlds.imported.formats.file_bytes import Unreadable

_COLMAP = re.compile(r"^\s*\d+(\s+[-+\d.eE]+){7}\s+\d+\s+\S*[A-Za-z]")
_POINTS = re.compile(r"[-+\d.eE\s]*")
"""Of an image, in the line behind it; blank without points, which some programs leave out."""


def colmap_poses(lines: list[str]) -> NDArray[np.float64] | None:
    """(K, 4, 4) from cameras (x right, y down, z ahead) to the world, by number; None for other files."""
    data = [line for line in lines if not line.startswith("#")]
    first = next((index for index, line in enumerate(data) if line.strip()), 0)
    data = data[first:]
    if not data or not _COLMAP.match(data[0]):
        return None
    others = [(line, before) for before, line in pairwise(data) if not _COLMAP.match(line)]
    wrong = next(
        (
            line
            for line, before in others
            if not _POINTS.fullmatch(line) or (line.strip() and not _COLMAP.match(before))
        ),
        None,
    )
    if wrong is not None:
        raise Unreadable(f"it is COLMAP's images.txt, but has the line {wrong[:60]!r} where a pose belongs")
    numbers = sorted([float(word) for word in row.split()[:8]] for row in data if _COLMAP.match(row))
    table = np.array(numbers)
    poses = np.tile(np.eye(4), (len(table), 1, 1))
    turned = Rotation.from_quat(table[:, [2, 3, 4, 1]]).as_matrix().transpose(0, 2, 1)
    poses[:, :3, :3] = turned
    poses[:, :3, 3] = -np.einsum("nij,nj->ni", turned, table[:, 5:8])
    return poses


def nerf_poses(text: str) -> NDArray[np.float64]:
    """(K, 4, 4) from cameras (x right, y down, z ahead) to the world, by number; else as in the file."""
    try:
        data = json.loads(text)
        poses = np.array([frame["transform_matrix"] for frame in _by_number(data["frames"])], np.float64)
        origin_m = np.array(data.get("origin_m", (0, 0, 0)), np.float64).reshape(3)  # as our export has it
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
        raise Unreadable(f"it is JSON, but no transforms.json of NeRF ({error})") from error
    if poses.ndim != 3 or poses.shape[1:] not in ((4, 4), (3, 4)) or not np.isfinite(poses).all():
        raise Unreadable("its transform_matrix are not of 4 x 4 finite numbers")
    full = np.tile(np.eye(4), (len(poses), 1, 1))
    full[:, :3] = poses[:, :3]
    full[:, :3, 3] += origin_m
    return np.asarray(full @ np.diag([1.0, -1, -1, 1]))


def _by_number(frames: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Frames by the last number in their names; as they are where a name has none, or two the same."""
    numbers = [re.findall(r"\d+", str(frame.get("file_path", "")).rpartition("/")[2]) for frame in frames]
    order = {int(found[-1]): frame for found, frame in zip(numbers, frames, strict=True) if found}
    return [order[number] for number in sorted(order)] if len(order) == len(frames) else frames
