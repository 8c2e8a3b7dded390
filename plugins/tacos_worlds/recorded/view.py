"""View of another camera at the place of a recording's own."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, ImageGeometry
from tacos_framework.camera import pixels_of_rays, rays_of_pixels

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_FINEST_PX = 0.97
"""A candidate's pixel is as fine as the recording's down to this share of it."""
_OUTSIDE_PX = 0.6
"""The middle of a pixel may lie so far beyond the outermost ones of the recording."""


def shown_of(camera: Camera, source: Camera, place_m: NDArray[np.float64]) -> dict[str, str]:
    """Reasons why an image of the source does not show what a camera sees: a word or two -> a sentence."""
    reasons = {}
    beside_m = float(np.linalg.norm(camera.agent_from_camera[:3, 3] - place_m))
    if beside_m > 1e-6:
        reasons["another place"] = (
            f"camera {camera.name} stands {beside_m:.3g} m beside the place of the recording"
        )
    border = _border(camera)
    rays = rays_of_pixels(border, camera)
    places = pixels_of_rays(rays[np.isfinite(rays[:, 0])] @ _turn(camera, source).T, source)
    limit = np.array([source.width_px - 1, source.height_px - 1])
    if not np.all((places > -_OUTSIDE_PX) & (places < limit + _OUTSIDE_PX)):  # NaN: behind the camera
        reasons["wider view"] = (
            f"{camera.hfov_deg:.4g} x {camera.vfov_deg:.4g} deg reach beyond the recorded "
            f"{source.hfov_deg:.4g} x {source.vfov_deg:.4g} deg"
        )
    step = float(source.focal_length_px / camera.focal_length_px)
    if step < _FINEST_PX:
        reasons["finer detail"] = (
            f"a pixel of {np.degrees(1 / camera.focal_length_px):.3g} deg is {step:.2f} of a recorded one"
        )
    return reasons


def _turn(camera: Camera, source: Camera) -> NDArray[np.float64]:
    """(3, 3) from the directions of a camera to those of the source."""
    return np.asarray(source.agent_from_camera[:3, :3].T @ camera.agent_from_camera[:3, :3])


def _border(camera: Camera) -> NDArray[np.float64]:
    x, y = np.linspace(0, camera.width_px - 1, 33), np.linspace(0, camera.height_px - 1, 33)
    grid = np.stack(np.meshgrid(x, y), axis=-1)
    return np.concatenate([grid[0], grid[-1], grid[:, 0], grid[:, -1]])


@dataclass(frozen=True, eq=False)
class Shares:
    """Weights of the source's pixels in those of a camera."""

    light: csr_array  # (camera's pixels, source's pixels) shares of light
    noise: csr_array  # the same of the variance of noise that is not shared by pixels


def shares_of(camera: Camera, source: Camera) -> Shares:
    """Each pixel of a camera as a mean over the area that it sees of the source's image.

    The image of the source is taken to be even over each of its pixels, so that a camera of equal pixels sees
    the very samples, and one of half as many their means.
    """
    turn = _turn(camera, source)
    return _shares(ImageGeometry.of_camera(camera), ImageGeometry.of_camera(source), turn.tobytes())


@lru_cache(maxsize=8)
def _shares(camera: ImageGeometry, source: ImageGeometry, turn: bytes) -> Shares:
    from scipy.sparse import csr_array  # late: checking a recipe makes no images

    rotation = np.frombuffer(turn).reshape(3, 3)
    middles = np.stack(np.meshgrid(np.arange(camera.width_px), np.arange(camera.height_px)), -1).reshape(
        -1, 2
    )
    around = [
        pixels_of_rays(rays_of_pixels(middles + by, camera) @ rotation.T, source)
        for by in ((0, 0), (0.5, 0), (-0.5, 0), (0, 0.5), (0, -0.5))
    ]
    centre, across, down = around[0], around[1] - around[2], around[3] - around[4]
    step = float(np.nanmedian(np.hypot(*across.T)))
    finer = 1 if abs(step - 1) < 0.01 else int(np.clip(np.ceil(4 * step), 4, 24))
    aside = (np.arange(finer) + 0.5) / finer - 0.5
    last = np.array([source.width_px - 1, source.height_px - 1])
    count, pixels = len(middles), (last + 1).prod()
    light = csr_array((count, pixels), dtype=np.float32)
    rows = np.arange(count)
    weight = np.full(count, 1 / finer**2, np.float32)
    for right in aside:
        column = [
            np.clip(np.rint(np.nan_to_num(centre + right * across + low * down)), 0, last) for low in aside
        ]
        index = np.concatenate([(x + y * source.width_px).astype(np.int64) for x, y in (c.T for c in column)])
        light = light + csr_array((np.tile(weight, finer), (np.tile(rows, finer), index)), shape=light.shape)
    noise = light.copy()
    noise.data = noise.data**2
    return Shares(light, noise)
