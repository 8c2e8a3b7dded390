"""Rendered light: dimmed, repeated, or from nowhere; and the truth that comes with it."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, Capture, Episode, Object, Trajectory, View, World

FRAME_INTERVAL_S = 0.1
"""Between frames of what stands still [s]."""

PATCH_CLASS = "patch"
"""Objects of this class are the patches of a chart."""

PATCH_MARGIN = 0.2
"""Share of a patch's width and height that is left out at each side."""

Number = TypeVar("Number", bound=np.generic)


def without_world(camera: Camera, luminance_cd_m2: NDArray[np.float32]) -> Capture:
    """A capture of (N, H, W, 3) light that comes from 1 m ahead, and of nothing else [cd/m2]."""
    frames = len(luminance_cd_m2)
    size = luminance_cd_m2.shape[:3]
    pose = np.tile(np.eye(4), (frames, 1, 1))
    world = World("nothing", (), (), (Object("background", "background"),), ("background",))
    episode = Episode(
        world, Trajectory(np.zeros(1), pose[:1]), np.arange(frames, dtype=float), np.zeros(frames, np.int32)
    )
    view = View(camera, pose, luminance_cd_m2, np.ones(size, np.float32), np.zeros(size, np.int32))
    return Capture(episode, (view,))


def dimmed(light: Capture, factor: float) -> Capture:
    views = [replace(v, luminance_cd_m2=v.luminance_cd_m2 * np.float32(factor)) for v in light.views]
    return replace(light, views=tuple(views))


def repeated(light: Capture, frames: int) -> Capture:
    episode, view = light.episode, light.views[0]

    def again(array: NDArray[Number]) -> NDArray[Number]:
        return np.broadcast_to(array[:1], (frames, *array.shape[1:]))

    return Capture(
        Episode(
            episode.world,
            episode.trajectory,
            episode.time_s[0] + FRAME_INTERVAL_S * np.arange(frames),
            np.zeros(frames, np.int32),
        ),
        (
            replace(
                view,
                world_from_camera=again(view.world_from_camera),
                luminance_cd_m2=again(view.luminance_cd_m2),
                depth_m=again(view.depth_m),
                object_id=again(view.object_id),
            ),
        ),
    )


def velocity_of(velocity_px_s: NDArray[np.float32]) -> NDArray[np.float64]:
    middle = velocity_px_s.reshape(-1, 2).mean(axis=0, dtype=np.float64)
    alike = np.abs(velocity_px_s - middle).max() <= 1e-3 * max(float(np.abs(middle).max()), 1.0)
    return middle if alike else velocity_px_s[0].astype(np.float64)


def patches_of(
    light: Capture, expected_dn: NDArray[np.float32]
) -> tuple[NDArray[np.int64], NDArray[np.float64]] | None:
    """The inner part of each patch that is seen, and what is expected of it.

    - `expected_dn`: (1, H, W, C) expected values [DN].

    Returns: (P, 4) x, y, width, height [px] and (P, 3) mean of what is expected there [DN]; None without a
    patch.
    """
    seen = light.views[0].object_id[0]
    boxes, colours = [], []
    for number, thing in enumerate(light.episode.world.objects):
        rows, columns = np.nonzero(seen == number)
        if thing.class_name != PATCH_CLASS or not len(rows):
            continue
        left, right, top, bottom = columns.min(), columns.max() + 1, rows.min(), rows.max() + 1
        across, down = round(PATCH_MARGIN * (right - left)), round(PATCH_MARGIN * (bottom - top))
        x, y = left + across, top + down
        width, height = right - left - 2 * across, bottom - top - 2 * down
        if width < 1 or height < 1:
            continue
        inside = expected_dn[0, y : y + height, x : x + width]
        boxes.append((x, y, width, height))
        colours.append(np.broadcast_to(inside.mean(axis=(0, 1), dtype=np.float64), 3))
    return (np.array(boxes, np.int64), np.array(colours)) if boxes else None
