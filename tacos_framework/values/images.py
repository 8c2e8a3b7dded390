"""Output of cameras: linear light, then digital frames."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.values.arrays import read_only
from tacos_framework.values.camera import Camera, Exposure
from tacos_framework.values.episode import Episode


@dataclass(frozen=True, eq=False)
class View:
    """Light and truth before one camera, frame by frame."""

    camera: Camera
    world_from_camera: NDArray[np.float64]
    """(N, 4, 4) float64 poses in the middle of the exposure [m]."""
    luminance_cd_m2: NDArray[np.float32]
    """(N, H, W, 3) float32 luminance that reaches each pixel, averaged over the pixel and the exposure, per
    linear sRGB channel, scaled so that an achromatic surface has equal channels [cd/m2].
    """
    depth_m: NDArray[np.float32]
    """(N, H, W) float32 depth at the pixel centre, in the middle of the exposure [m]: the distance along the
    optical axis of a rectilinear camera, along the ray of any other, as to the side of a fisheye the axis
    measures nothing. Infinite where nothing is. A point lies at depth times `camera.pixel_rays`.
    """
    object_id: NDArray[np.int32]
    """(N, H, W) int32 index into `World.objects` at the pixel centre; 0 for the background."""
    noise_cd2_m4: NDArray[np.float32] | None = None
    """(N, H, W, C) float32 variance of the noise in the light, where that was itself recorded: C = 3 for
    noise of each channel, 1 for noise that all share. Sensors add what theirs exceeds it by [(cd/m2)^2].
    """

    def __post_init__(self) -> None:
        count = len(self.world_from_camera)
        size = (count, self.camera.height_px, self.camera.width_px)
        read_only(self, "world_from_camera", np.float64, (count, 4, 4))
        read_only(self, "luminance_cd_m2", np.float32, (*size, 3))
        read_only(self, "depth_m", np.float32, size)
        read_only(self, "object_id", np.int32, size)
        if self.noise_cd2_m4 is not None:
            read_only(self, "noise_cd2_m4", np.float32, (*size, None))

    def frame(self, index: int) -> View:
        """One frame of it, without copying."""
        run = slice(index, index + 1)
        return View(
            self.camera,
            self.world_from_camera[run],
            self.luminance_cd_m2[run],
            self.depth_m[run],
            self.object_id[run],
            None if self.noise_cd2_m4 is None else self.noise_cd2_m4[run],
        )


@dataclass(frozen=True, eq=False)
class Capture:
    """Output of a renderer for a batch: one view per camera of the rig, in the rig's order."""

    episode: Episode
    views: tuple[View, ...]
    pending: tuple[Any, ...] = ()
    """Effects of the stages pixel and readout that stand in the graph between renderer and sensor: the sensor
    that comes next applies them at their place (`tacos_framework.formation.PlacedEffect`).
    """


@dataclass(frozen=True, eq=False)
class FrameBatch:
    """Digital images of a batch of consecutive frames, with the capture they were made from."""

    capture: Capture
    """Truth: poses, depth, ids."""
    images: tuple[NDArray[np.uint8] | NDArray[np.uint16], ...]
    """For each camera (N, H, W, C) uint8 or uint16, RGB (C = 3) or mono (C = 1), linear unless `coded`
    [DN].
    """
    black_level_dn: float = 0.0
    white_level_dn: float = 255.0
    """Pedestal and full scale [DN]."""
    exposures: tuple[tuple[Exposure, ...], ...] = ()
    """For each camera what its N frames were taken with, where that is controlled; empty where it is
    fixed.
    """
    dn_per_electron: tuple[tuple[float | None, ...], ...] = ()
    """For each camera what an electron of a photosite added to the samples of its N frames, None where its
    sensor does not know; empty where nobody said it of any [DN/e-].
    """
    coded: bool = False
    """True if the files are coded for a display, by a gamma or another tone curve."""

    def __post_init__(self) -> None:
        if len(self.images) != len(self.capture.views):
            raise ValueError(f"{len(self.images)} images for {len(self.capture.views)} cameras")
        frames = len(self.capture.episode)
        for name in ("exposures", "dn_per_electron"):
            stated = getattr(self, name)
            if stated and [len(of_camera) for of_camera in stated] != [frames] * len(self.images):
                raise ValueError(f"{name} must be {frames} for each of {len(self.images)} cameras, or none")
        frozen = []
        for image, view in zip(self.images, self.capture.views, strict=True):
            size = (frames, view.camera.height_px, view.camera.width_px)
            if image.shape[:3] != size or image.dtype not in (np.uint8, np.uint16):
                raise ValueError(
                    f"images of camera {view.camera.name!r} are {image.dtype} {image.shape}, "
                    f"expected uint8 or uint16 {size} and channels"
                )
            image = image.view()
            image.flags.writeable = False
            frozen.append(image)
        object.__setattr__(self, "images", tuple(frozen))

    @property
    def episode(self) -> Episode:
        """The batch's frames in the world."""
        return self.capture.episode

    @property
    def nbytes(self) -> int:
        """Memory of the images and of the truth behind them [bytes]."""
        truth = ("luminance_cd_m2", "depth_m", "object_id")
        arrays = [getattr(view, name) for view in self.capture.views for name in truth]
        return sum(array.nbytes for array in (*self.images, *arrays))
