"""A camera built from a sensor and its optics, as the rigs share it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from tacos_framework import CURRENCIES, Camera, Lens, Projection, Settings, setting
from tacos_framework.camera import TYPICAL_ROW_TIME_US, agent_from_camera
from tacos_plugins.rigs.optics import Optics, optics_for
from tacos_plugins.rigs.sensor_part import SensorPart


def tilt_of(cameras: str) -> Any:
    """The setting of the pitch of one camera, or of several alike."""
    said = f"Tilt of {cameras}, positive is up."
    return setting(0.0, help=said, unit="deg", ge=-90, le=90, also=("tilt", "elevation"))


class MountSettings(Settings):
    binning: float = setting(
        1.0,
        help="Simulate blocks of binning x binning pixels as one, to run on a small machine.",
        ge=1,
        also=("downsample", "downscale"),
    )
    height_above_eye_m: float = setting(
        0.0, help="Height of the optical centres above the agent's eye.", unit="m"
    )
    bits_per_pixel: float | None = setting(
        None,
        help="Bits a pixel takes on the link, for the bandwidth, as of coded images; the part's bit depth if "
        "absent.",
        gt=0,
    )
    per_euro: dict[Literal[CURRENCIES], Annotated[float, Field(gt=0)]] = setting(  # type: ignore[valid-type]
        {}, help="Price of a euro in other currencies, so that prices can be added, as in {usd: 1.1}."
    )


class ReadOutVariables(Settings):
    """A sensor, and what is read out of it: how much, and in how large pixels."""

    sensor: SensorPart = setting(
        help="Image sensor: a row of a catalog, or its size and pitch.", also=("imager", "chip", "resolution")
    )
    roi_width: float = setting(
        1.0,
        help="Share of the sensor's width that is read out, about its middle.",
        gt=0,
        le=1,
        also=("roi", "crop", "window"),
    )
    roi_height: float = setting(
        1.0,
        help="Share of the sensor's height that is read out, about its middle.",
        gt=0,
        le=1,
        also=("roi", "crop", "window"),
    )
    sensor_binning: int = setting(
        1,
        help="Photosites along each side that the camera averages into one pixel of its images, each read "
        "by itself.",
        ge=1,
        le=16,
        also=("bin", "binning", "downsample", "downscale"),
    )

    projection: Projection = setting(
        "rectilinear",
        help="Projection of the lens: rectilinear up to 140 deg or so, a fisheye's beyond; coefficients come "
        "with a calibration or a lens.",
        also=("fisheye", "lens_model", "camera_model"),
    )
    image_circle_deg: float | None = setting(
        None,
        help="Field of view at which the image circle of the lens ends, and all is dark beyond; by default "
        "that of its projection.",
        unit="deg",
        gt=0,
        le=360,
    )

    @model_validator(mode="after")
    def _has_such_a_circle(self) -> Self:
        self.projected()
        return self

    def projected(self) -> Lens:
        """The lens of the projection.

        Raises `ValueError` where it has no such image circle.
        """
        half_deg = None if self.image_circle_deg is None else self.image_circle_deg / 2
        try:
            return Lens(self.projection, half_field_deg=half_deg)
        except ValueError as error:
            raise ValueError(f"image_circle_deg is {self.image_circle_deg:g}: {error}") from None

    def optics_for(self, variable: str, size_mm: float) -> Optics:
        """The optics with the field of view of a variable across a length of the sensor [mm].

        Raises `ValueError` where the projection has no such field of view.
        """
        try:
            return optics_for(size_mm, getattr(self, variable), self.projected())
        except ValueError as error:
            raise ValueError(f"{variable} is {error}") from None

    @property
    def read_out(self) -> SensorPart:
        """The pixels that leave the camera: those of the region of interest, as large as they are binned."""
        return self.sensor.region(self.roi_width, self.roi_height).binned(self.sensor_binning)


DERIVED_UNITS = {
    "hfov_deg": "deg",
    "vfov_deg": "deg",
    "dfov_deg": "deg",
    "megapixels": "Mpx",
    "sensor_width_mm": "mm",
    "sensor_height_mm": "mm",
    "pixels_per_deg": "px/deg",
}
"""Names and units of what :func:`derived_optics` gives."""


def derived_optics(sensor: SensorPart, optics: Optics) -> dict[str, float]:
    """The quantities of :data:`DERIVED_UNITS` of one camera, for the pixels that are read out of its sensor.

    Pixels per degree hold at the image centre; a rectilinear image has more of them towards its edges.
    """
    return {
        "hfov_deg": optics.field_of_view_deg(sensor.width_mm),
        "vfov_deg": optics.field_of_view_deg(sensor.height_mm),
        "dfov_deg": optics.field_of_view_deg(sensor.diagonal_mm),
        "megapixels": sensor.width_px * sensor.height_px * 1e-6,
        "sensor_width_mm": sensor.width_mm,
        "sensor_height_mm": sensor.height_mm,
        "pixels_per_deg": math.radians(optics.focal_length_mm * 1e3 / sensor.pixel_um),
    }


def image_coordinates(sensor: SensorPart, optics: Optics, pitch_deg: float) -> dict[str, float]:
    """Coordinates of images of a camera: numbers along which they change evenly, by the pixels read out.

    Angles say what is in view. Pixel counts and pitch count by their ratios: from 1 to 2 um changes noise as
    much as from 4 to 8 um. Shutter and filters are those that are simulated where nobody states them.

    >>> vga = SensorPart(width_px=640, height_px=480, pixel_um=4.0)
    >>> {name: round(value, 2) for name, value in image_coordinates(vga, Optics(2.0), -5.0).items()}
    ... # doctest: +NORMALIZE_WHITESPACE
    {'pitch_deg': -5.0, 'hfov_deg': 65.24, 'vfov_deg': 51.28,
     'log2_width_px': 9.32, 'log2_height_px': 8.91, 'log2_pixel_um': 2.0,
     'line_time_us': 0.0, 'mono': 0.0}
    """
    return {
        "pitch_deg": pitch_deg,
        "hfov_deg": optics.field_of_view_deg(sensor.width_mm),
        "vfov_deg": optics.field_of_view_deg(sensor.height_mm),
        "log2_width_px": math.log2(sensor.width_px),
        "log2_height_px": math.log2(sensor.height_px),
        "log2_pixel_um": math.log2(sensor.pixel_um),
        "line_time_us": _line_time_us(sensor),
        "mono": float(sensor.colour == "mono"),
    }


def _line_time_us(sensor: SensorPart) -> float:
    """Time from row to row of a rolling shutter; 0 of any other [us]."""
    if sensor.exposes != "rolling":
        return 0.0
    row_time_us = TYPICAL_ROW_TIME_US if sensor.row_time_us is None else sensor.row_time_us
    return min(row_time_us, sensor.row_time_at_most_us or math.inf)


def mounted_camera(
    name: str,
    variables: ReadOutVariables,
    optics: Optics,
    *,
    position_m: Sequence[float],
    pitch_deg: float,
    yaw_deg: float = 0.0,
    binning: float,
) -> Camera:
    """A camera on the agent that simulates blocks of ``binning`` x ``binning`` of its pixels as one.

    - `variables`: the sensor, and what is read out of it.
    - `optics`: the lens before it.
    - `position_m`: optical centre in the agent frame: forward, left, up [m].
    - `pitch_deg`: tilt of the optical axis, positive is up [deg].
    - `yaw_deg`: turn of the optical axis, positive is left [deg].
    - `binning`: linear factor; the image size is rounded to whole pixels, at least one [1].
    """
    centre = optics.principal_point_px
    return Camera(
        name=name,
        width_px=max(1, round(variables.read_out.width_px / binning)),
        height_px=max(1, round(variables.read_out.height_px / binning)),
        pixel_um=variables.sensor.pixel_um,
        focal_length_mm=optics.focal_length_mm,
        agent_from_camera=agent_from_camera(position_m, pitch_deg, yaw_deg),
        binning=binning * variables.sensor_binning,
        principal_point_px=centre and ((centre[0] + 0.5) / binning - 0.5, (centre[1] + 0.5) / binning - 0.5),
        lens=optics.lens,
        sensor_binning=variables.sensor_binning,
        electrons=variables.sensor.electrons,
        colour=variables.sensor.colour,
        shutter=variables.sensor.exposes,
        row_time_us=variables.sensor.row_time_us if variables.sensor.exposes == "rolling" else None,
        row_time_at_most_us=variables.sensor.row_time_at_most_us,
    )
