"""Cameras: where they sit, what they see, how long they look."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tacos_framework.values.arrays import read_only
from tacos_framework.values.camera_table import cameras_as_html
from tacos_framework.values.lens import PINHOLE, Lens

Colour = Literal["colour", "mono"]
SHUTTERS = ("global", "rolling", None)
"""Exposure of rows: all at once, one after the other, or unknown."""


@dataclass(frozen=True)
class Electrons:
    """Known figures of a photosite in electrons; None is unknown, and no model may invent it."""

    sensor: str = ""
    """Name of the image sensor, for messages."""
    quantum_efficiency: float | None = None
    """Electrons per photon [1]."""
    full_well_e: float | None = None
    """Electrons a photosite holds before it saturates [e-]."""
    read_noise_e: float | None = None
    """Standard deviation of the noise without light [e-]."""
    dark_current_e_s: float | None = None
    """Electrons per second without light [e-/s]."""
    high_gain_from_db: float | None = None
    high_gain_read_noise_e: float | None = None
    """Gain from which on a second, higher conversion gain is used [dB], and the read noise there [e-]."""
    converter_bits: int | None = None
    """Bits of the converter that reads it [bit]."""
    black_level_share: float | None = None
    """Its digital number without light over full scale [1]."""
    red_over_green: float | None = None
    blue_over_green: float | None = None
    """Signal of its red and blue photosites over that of the green ones, of grey in daylight [1]."""


@dataclass(frozen=True, eq=False)
class Camera:
    """One camera on the agent: a pinhole, unless its lens says otherwise.

    The camera frame is OpenCV's: x right, y down, z forward. Pixel (0, 0) has its centre at (0.0, 0.0),
    so the image spans -0.5 .. width - 0.5. The agent frame is x forward, y left, z up.
    """

    name: str
    """Unique in its rig."""
    width_px: int
    height_px: int
    """Size of the image that is simulated [px]."""
    pixel_um: float
    """Pitch of the photosites as manufactured [um]."""
    focal_length_mm: float
    """Focal length on the optical axis [mm]."""
    agent_from_camera: NDArray[np.float64] = field(default_factory=lambda: np.eye(4))
    """(4, 4) float64 rigid transform [m]."""
    binning: float = 1.0
    """Linear factor of photosites averaged into one simulated pixel [1]; 1 simulates every photosite. The
    pitch of a simulated pixel is ``pixel_um * binning``.
    """
    principal_point_px: tuple[float, float] | None = None
    """(x, y) [px]; the image centre when None."""
    electrons: Electrons = Electrons()
    """Known figures of its photosites in electrons."""
    sensor_binning: float = 1
    """The part of it that the camera does itself: its own images have a pixel for so many photosites along
    each side [1].
    """
    lens: Lens = PINHOLE
    """Its projection; `tacos_framework.camera.rays_of_pixels` takes pixels to directions."""
    colour: Colour | None = None
    """``colour`` under a mosaic of filters, ``mono`` without; None where it is not known."""
    shutter: str | None = None
    """``global``: all rows are exposed at once; ``rolling``: one after the other; None is unknown."""
    row_time_us: float | None = None
    """From one row of photosites read out to the next, where the shutter is rolling; None is unknown [us]."""
    row_time_at_most_us: float | None = None
    """What its frame rate leaves for a row; None is unknown [us]."""

    def __post_init__(self) -> None:
        if self.width_px < 1 or self.height_px < 1:
            raise ValueError(f"camera {self.name!r} has no pixels: {self.width_px} x {self.height_px}")
        for name in ("pixel_um", "focal_length_mm", "binning", "sensor_binning"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise ValueError(f"camera {self.name!r}: {name} must be above 0, not {value}")
        if self.shutter not in SHUTTERS:
            raise ValueError(
                f"camera {self.name!r}: shutter is global, rolling or None, not {self.shutter!r}"
            )
        if self.row_time_us is not None and not (math.isfinite(self.row_time_us) and self.row_time_us >= 0):
            raise ValueError(f"camera {self.name!r}: row_time_us must be 0 or more, not {self.row_time_us}")
        read_only(self, "agent_from_camera", np.float64, (4, 4))

    @property
    def simulated_binning(self) -> float:
        """Linear factor of the camera's own pixels averaged into one that is simulated [1]."""
        return self.binning / self.sensor_binning

    @property
    def focal_length_px(self) -> float:
        """Focal length in simulated pixels [px]."""
        return self.focal_length_mm * 1e3 / (self.pixel_um * self.binning)

    @property
    def centre_px(self) -> tuple[float, float]:
        """Principal point (x, y) [px]."""
        return self.principal_point_px or ((self.width_px - 1) / 2, (self.height_px - 1) / 2)

    @property
    def intrinsics(self) -> NDArray[np.float64]:
        """(3, 3) matrix K [px], as `projectPoints` of OpenCV and of its `fisheye` take it."""
        cx, cy = self.centre_px
        f = self.focal_length_px
        return np.array([[f, 0, cx], [0, f, cy], [0, 0, 1]], dtype=np.float64)

    @property
    def hfov_deg(self) -> float:
        """Horizontal field of view from edge to edge, within the image circle [deg]."""
        return self.lens.field_of_view_deg(self.width_px / self.focal_length_px)

    @property
    def vfov_deg(self) -> float:
        """Vertical field of view, likewise [deg]."""
        return self.lens.field_of_view_deg(self.height_px / self.focal_length_px)

    def _repr_html_(self) -> str:
        """In a notebook: its figures with their units."""
        return cameras_as_html([self])


@dataclass(frozen=True)
class Rig:
    """One or more cameras mounted on the agent, in a fixed order."""

    cameras: tuple[Camera, ...]

    def __post_init__(self) -> None:
        names = [camera.name for camera in self.cameras]
        if not names:
            raise ValueError("a rig needs at least one camera")
        if len(set(names)) != len(names):
            raise ValueError(f"cameras of a rig need different names, not {', '.join(names)}")

    def _repr_html_(self) -> str:
        """In a notebook: its cameras side by side."""
        return cameras_as_html(self.cameras)


@dataclass(frozen=True)
class Exposure:
    """Exposure of the scene: time [s], f-number [1], gain [dB]."""

    time_s: float = 0.030
    f_number: float = 2.0
    gain_db: float = 0.0

    def __post_init__(self) -> None:
        for name in ("time_s", "f_number"):
            if not (math.isfinite(value := getattr(self, name)) and value > 0):
                raise ValueError(f"exposure {name} must be above 0, not {value}")
        if not math.isfinite(self.gain_db):
            raise ValueError(f"exposure gain_db must be a finite number, not {self.gain_db}")

    @property
    def gain(self) -> float:
        """Gain as a factor on the signal [1]: 20 dB is a factor of 10."""
        return 10 ** (self.gain_db / 20)
