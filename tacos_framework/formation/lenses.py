"""Captures of any lens by a renderer of pinholes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera.geometry import world_from_camera
from tacos_framework.contracts import RendererBase, optional
from tacos_framework.values import Camera, Capture, ImageGeometry, Rig, View


def captured(renderer: Any, rig: Rig, take: Callable[..., Capture]) -> Capture:
    """The capture of a renderer for a rig, whatever its lenses: the way in which renderers are to be called.

    Cameras that are no pinholes are put together from pinhole pictures (`lens_faces`), all taken in one call,
    unless the renderer itself says that it draws lenses (`RendererBase.draws_lenses`).

    `take`: the renderer's `capture`, all given but the ``rig``.

    ::

        capture = captured(renderer, rig, partial(renderer.capture, episode, exposure=exposure))
    """
    if optional(renderer, RendererBase, "draws_lenses") or all(c.lens.is_pinhole for c in rig.cameras):
        return take(rig=rig)
    from tacos_framework.formation.lens_faces import faces_of  # scipy: only where a lens asks for it

    faces = {
        camera.name: None if camera.lens.is_pinhole else faces_of(ImageGeometry.of_camera(camera))
        for camera in rig.cameras
    }
    pinholes: list[Camera] = []
    for camera in rig.cameras:
        of_camera = faces[camera.name]
        pinholes += [camera] if of_camera is None else [side.camera(camera) for side in of_camera.sides]
    taken = take(rig=Rig(tuple(pinholes)))
    views = iter(taken.views)
    return Capture(
        taken.episode,
        tuple(_view(camera, faces[camera.name], views, taken) for camera in rig.cameras),
        taken.pending,
    )


def _view(camera: Camera, faces: Any, views: Iterator[View], taken: Capture) -> View:
    """The view of a camera, from the next ones of those taken."""
    if faces is None:
        return next(views)
    parts = [next(views) for _ in faces.sides]
    count, size = len(taken.episode), (camera.height_px, camera.width_px)
    luminance, depth = np.empty((count, *size, 3), np.float32), np.empty((count, *size), np.float32)
    object_id = np.empty((count, *size), np.int32)
    for i in range(count):
        luminance[i] = faces.luminance(_pixels([part.luminance_cd_m2[i] for part in parts])).reshape(*size, 3)
        depth[i] = faces.depth_m(_pixels([part.depth_m[i] for part in parts])).reshape(size)
        object_id[i] = faces.object_id(_pixels([part.object_id[i] for part in parts])).reshape(size)
    poses = world_from_camera(taken.episode.trajectory.at(taken.episode.time_s), camera.agent_from_camera)
    return View(camera, poses, luminance, depth, object_id)


def _pixels(images: list[NDArray[Any]]) -> NDArray[Any]:
    """(P,) or (P, C) pixels of images, one image after the other."""
    return np.concatenate([image.reshape(-1, *image.shape[2:]) for image in images])
