"""Geometry and circumstances of an image, for effects on plain arrays."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.values.camera import Camera
from tacos_framework.values.lens import PINHOLE, Lens

Velocity = NDArray[np.floating]
"""(2,), (H, W, 2) or (N, H, W, 2) motion of what each pixel shows, x right, y down [px/s]."""


@dataclass(frozen=True)
class ImageGeometry:
    """Geometry of an image's pixels on the sensor and behind the lens.

    The image may be a crop of the sensor: radii still run over the *full* sensor's half diagonal, and rows
    are read out where they lie on the sensor.

    >>> full = ImageGeometry(640, 480, focal_length_px=1000, centre_px=(319.5, 239.5), pixel_um=3)
    >>> full.half_diagonal_px
    400.0
    >>> quarter = full.crop(x=320, y=240, width_px=320, height_px=240)
    >>> quarter.half_diagonal_px, quarter.centre_px
    (400.0, (-0.5, -0.5))
    """

    width_px: int
    height_px: int
    """Size of the image [px]."""
    focal_length_px: float
    """Focal length in pixels of the image [px]."""
    centre_px: tuple[float, float]
    """Principal point (x, y), in pixels of the image; may lie outside a crop [px]."""
    pixel_um: float
    """Pitch of the image's pixels, binning included [um]."""
    offset_px: tuple[int, int] = (0, 0)
    """Place of pixel (0, 0) of the image on the full sensor (x, y) [px]."""
    full_width_px: int = 0
    full_height_px: int = 0
    """Size of the full sensor; that of the image when 0 [px]."""
    camera: str = ""
    """Name of the camera, which tells the fixed patterns of a rig's sensors apart."""
    binning: float = 1.0
    """Linear factor of photosites averaged into one pixel of the image [1]."""
    lens: Lens = PINHOLE
    simulated_binning: float = 1.0
    """Linear factor of the camera's own pixels averaged into it, as `Camera.simulated_binning` [1]."""

    def __post_init__(self) -> None:
        if self.width_px < 1 or self.height_px < 1:
            raise ValueError(f"an image of {self.width_px} x {self.height_px} has no pixels")
        for name in ("focal_length_px", "pixel_um", "binning"):
            if not (math.isfinite(value := getattr(self, name)) and value > 0):
                raise ValueError(f"{name} must be above 0, not {value}")
        object.__setattr__(self, "full_width_px", self.full_width_px or self.width_px)
        object.__setattr__(self, "full_height_px", self.full_height_px or self.height_px)
        x, y = self.offset_px
        if not (0 <= x <= self.full_width_px - self.width_px):
            raise ValueError(
                f"columns {x} .. {x + self.width_px} are not on a sensor of {self.full_width_px} columns"
            )
        if not (0 <= y <= self.full_height_px - self.height_px):
            raise ValueError(
                f"rows {y} .. {y + self.height_px} are not on a sensor of {self.full_height_px} rows"
            )

    @classmethod
    def of_camera(cls, camera: Camera) -> ImageGeometry:
        """The geometry of a simulated camera, whose image is its whole sensor."""
        return cls(
            width_px=camera.width_px,
            height_px=camera.height_px,
            focal_length_px=camera.focal_length_px,
            centre_px=camera.centre_px,
            pixel_um=camera.pixel_um * camera.binning,
            camera=camera.name,
            binning=camera.binning,
            lens=camera.lens,
            simulated_binning=camera.simulated_binning,
        )

    def crop(self, *, x: int, y: int, width_px: int, height_px: int) -> ImageGeometry:
        """The geometry of a part of this image that begins at its pixel (x, y)."""
        return ImageGeometry(
            width_px=width_px,
            height_px=height_px,
            focal_length_px=self.focal_length_px,
            centre_px=(self.centre_px[0] - x, self.centre_px[1] - y),
            pixel_um=self.pixel_um,
            offset_px=(self.offset_px[0] + x, self.offset_px[1] + y),
            full_width_px=self.full_width_px,
            full_height_px=self.full_height_px,
            camera=self.camera,
            binning=self.binning,
            lens=self.lens,
            simulated_binning=self.simulated_binning,
        )

    @property
    def half_diagonal_px(self) -> float:
        """Half the diagonal of the full sensor: where r is 1 [px]."""
        return math.hypot(self.full_width_px, self.full_height_px) / 2

    @cached_property
    def x_px(self) -> NDArray[np.float64]:
        """(1, W) columns from the principal point, rising to the right [px]."""
        return np.arange(self.width_px, dtype=np.float64)[None, :] - self.centre_px[0]

    @cached_property
    def y_px(self) -> NDArray[np.float64]:
        """(H, 1) rows from the principal point, rising downwards [px]."""
        return np.arange(self.height_px, dtype=np.float64)[:, None] - self.centre_px[1]

    @cached_property
    def radius(self) -> NDArray[np.float64]:
        """(H, W) distance from the principal point over `half_diagonal_px` [1]."""
        return np.asarray(np.hypot(self.x_px, self.y_px) / self.half_diagonal_px)

    @cached_property
    def sensor_row(self) -> NDArray[np.float64]:
        """(H, 1) rows of the full sensor [px]."""
        return np.arange(self.height_px, dtype=np.float64)[:, None] + self.offset_px[1]


class ContextMissing(ValueError):
    """An effect needs something of the `ImageContext` that is not known there; its text says what."""


@dataclass(frozen=True, eq=False)
class ImageContext:
    """Circumstances of an image; None where they are not known."""

    exposure_s: float = 0.030
    """Exposure time [s]."""
    gain_db: float = 0.0
    """Gain [dB]."""
    f_number: float | None = None
    """Focal length over aperture diameter [1]."""
    black_level_dn: float = 0.0
    white_level_dn: float = 255.0
    """Pedestal and full scale of samples in digital numbers; light (stages scene, optics, exposure) has no
    pedestal whatever stands here [DN].
    """
    depth_m: NDArray[np.floating] | None = None
    """(H, W) or (N, H, W) depth as `View.depth_m` has it, infinite where nothing is [m]."""
    velocity_px_s: Velocity | Callable[[], Velocity] | None = None
    """(2,), (H, W, 2) or (N, H, W, 2) motion of what each pixel shows, x to the right, y downwards, or what
    works it out when it is asked for [px/s].
    """
    motion: Any = None
    """Motion of each thing over the image about the frame's moment, where that is rendered
    (`tacos_framework.camera.FrameMotion`).
    """
    object_id: NDArray[np.integer] | None = None
    """(H, W) or (N, H, W) what each pixel shows, index into `World.objects`."""
    shutter: str | None = None
    """``global`` or ``rolling``."""
    row_time_us: float | None = None
    """From the read-out of one row of photosites to that of the next, where the shutter is rolling [us]."""
    row_time_at_most_us: float | None = None
    """What the camera's frame rate leaves for that [us]."""
    frame_interval_s: float | None = None
    """Time from frame to frame; None for frames that do not follow each other [s]."""
    reference_row: float = 0.0
    """Row of the image whose moment the image shows, where other rows are read out later [px]."""
    cfa: str | None = None
    """Colour filters of a mosaic from the top-left pixel on, ``"RGGB"``; None for full channels."""
    dn_per_electron: float | None = None
    """Samples per electron of a photosite [DN/e-]."""
    charges_at_db: float | None = None
    """Gain at which digital numbers in settings of effects stand for charges, which are other numbers at
    another gain. That of the image if None [dB].
    """
    memory: dict[str, Any] = field(default_factory=dict)
    """Memory of the effect from frame to frame of a sequence; empty at its first frame."""

    def known_f_number(self, effect: str) -> float:
        """The f-number, for an effect that cannot do without; `ContextMissing` where it is not known."""
        if self.f_number is None:
            raise ContextMissing(f"{effect} needs the f-number of the capture")
        return self.f_number

    def known_depth_m(self, effect: str) -> NDArray[np.floating]:
        """The depth, for an effect that cannot do without; `ContextMissing` where it is not known."""
        if self.depth_m is None:
            raise ContextMissing(f"{effect} needs the depth of the capture")
        return self.depth_m

    def known_velocity_px_s(self, effect: str) -> Velocity:
        """The motion, for an effect that cannot do without; `ContextMissing` where it is not known."""
        if self.velocity_px_s is None:
            raise ContextMissing(f"{effect} needs the velocity of the capture")
        return self.velocity_px_s() if callable(self.velocity_px_s) else self.velocity_px_s
