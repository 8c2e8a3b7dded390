"""A lens that can be bought, and whether it fits a sensor."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Literal

from pydantic import ConfigDict, model_validator

from tacos_framework import Constraint, Lens, Projection, setting
from tacos_plugins.rigs.lens_curve import lens_of_curve
from tacos_plugins.rigs.optics import Coefficients, Optics
from tacos_plugins.rigs.priced_part import PricedPart
from tacos_plugins.rigs.sensor_part import SensorPart

FITS = {"M12": ("M12",), "M8": ("M8",), "CS": ("CS",), "C": ("C", "CS")}
"""Mount of a lens -> mounts of cameras that take it. C and CS share their thread; a C lens sits 17.526 mm
before the sensor, a CS lens 12.526 mm, so that a ring of 5 mm brings a C lens to a CS camera."""

LENS_UNITS = {"f_number_min": "1", "image_circle_margin_mm": "mm", "mount_fits": "1"}
"""Names and units of what :func:`derived_fit` gives."""

COVERED = Constraint(
    "image_circle_margin_mm", min=0.0, because="the image circle of the lens must cover the sensor"
)
"""Without it, the corners of the image stay dark."""


class LensPart(PricedPart):
    """The columns of a lens catalog a rig needs; a row's other columns are ignored."""

    model_config = ConfigDict(extra="ignore")

    name: str = setting("custom", help="Name of the part, for reports.")
    focal_length_mm: float = setting(help="Focal length.", unit="mm", gt=0)
    f_number_min: float | None = setting(None, help="Smallest f-number, if known.", gt=0)
    image_circle_mm: float | None = setting(
        None, help="Diameter of the circle it fills with light, if known.", unit="mm", gt=0
    )
    mount: str | None = setting(None, help="Its mount (M12, C, CS), if known.")
    distortion_percent: float | None = setting(
        None, help="Radial distortion at the edge of its image, negative for a barrel, if known.", unit="%"
    )

    mass_g: float | None = setting(None, help="Mass, if known.", unit="g", gt=0)
    projection: Projection | Literal["fisheye"] = setting(
        "rectilinear",
        help="Its projection; fisheye, where it is not published, is taken as equidistant.",
    )
    coefficients: Coefficients = setting((), help="Coefficients of the projection, in OpenCV's order.")
    curve: str | None = setting(
        None, help="Distance from the image centre against the field angle, as in r/R = 0.64*t - 0.03*t^2."
    )

    @model_validator(mode="after")
    def _is_a_lens(self) -> LensPart:
        self.projected()
        return self

    def projected(self) -> Optics:
        """The lens with all that it images; that of a rectilinear one whether its circle is known or not."""
        if self.curve is not None:
            scale, lens = lens_of_curve(self.curve)
            return Optics(scale * self.focal_length_mm, lens)
        lens = Lens("equidistant" if self.projection == "fisheye" else self.projection, self.coefficients)
        if self.image_circle_mm is not None and not lens.is_rectilinear:
            half_rad = float(lens.angle(self.image_circle_mm / 2 / self.focal_length_mm))
            lens = replace(lens, half_field_deg=None if math.isnan(half_rad) else math.degrees(half_rad))
        return Optics(self.focal_length_mm, lens)

    def optics(self, sensor: SensorPart, image_circle_deg: float | None = None) -> Optics:
        """The lens before a sensor: where its image circle is smaller than that, all is dark beyond."""
        optics = self.projected()
        half_deg = None if image_circle_deg is None else image_circle_deg / 2
        if (
            half_deg is None
            and optics.lens.is_rectilinear
            and (self.image_circle_mm or math.inf) < sensor.diagonal_mm
        ):
            assert self.image_circle_mm is not None, "less than a diagonal"
            half_deg = math.degrees(float(optics.lens.angle(self.image_circle_mm / 2 / self.focal_length_mm)))
        return (
            optics
            if half_deg is None
            else replace(optics, lens=replace(optics.lens, half_field_deg=half_deg))
        )


def derived_fit(lens: LensPart, sensor: SensorPart) -> dict[str, float]:
    """The quantities of :data:`LENS_UNITS` that are known.

    ``image_circle_margin_mm`` is the diameter of the image circle less the diagonal of the sensor, but of
    fisheyes, whose circle may be seen whole; ``mount_fits`` 1 where cameras with this sensor are sold with a
    mount that takes the lens, else 0.

    >>> sensor = SensorPart(width_px=4000, height_px=3000, pixel_um=1.0, mounts="CS, M12")
    >>> derived_fit(LensPart(focal_length_mm=4, image_circle_mm=6, mount="C"), sensor)
    {'image_circle_margin_mm': 1.0, 'mount_fits': 1.0}
    """
    found = {}
    if lens.f_number_min is not None:
        found["f_number_min"] = lens.f_number_min
    if lens.image_circle_mm is not None and lens.projection == "rectilinear":
        found["image_circle_margin_mm"] = lens.image_circle_mm - sensor.diagonal_mm
    if lens.mount is not None and sensor.mounts is not None:
        offered = [mount.strip() for mount in sensor.mounts.split(",")]
        found["mount_fits"] = float(any(mount in offered for mount in FITS.get(lens.mount, (lens.mount,))))
    return found


def notes_on_fit(lens: LensPart, sensor: SensorPart) -> Iterator[str]:
    """Notes for buyers of the two."""
    if lens.projection == "fisheye" and lens.curve is None:
        yield f"Not published: the projection of {lens.name}; it is simulated as equidistant."
    if lens.image_circle_mm is None and lens.curve is None:
        yield (
            f"Not published: the image circle of {lens.name}; ask for one of at least "
            f"{sensor.diagonal_mm:.1f} mm, the diagonal of {sensor.name}."
        )
    if lens.f_number_min is None:
        yield f"Not published: the smallest f-number of {lens.name}."
    if lens.mount is None or sensor.mounts is None:
        unstated = [f"the mount of {lens.name}"] if lens.mount is None else []
        unstated += [f"the mounts of cameras with {sensor.name}"] if sensor.mounts is None else []
        yield f"Not published: {' and '.join(unstated)}; check that they fit."
    elif not derived_fit(lens, sensor)["mount_fits"]:
        yield f"{lens.name} has mount {lens.mount}; cameras with {sensor.name} are sold for {sensor.mounts}."
    elif lens.mount == "C" and "C" not in [mount.strip() for mount in sensor.mounts.split(",")]:
        yield f"{lens.name} needs a ring of 5 mm on a CS camera."
    if lens.projection != "rectilinear":
        return
    if lens.distortion_percent is None:
        yield f"Not published: the distortion of {lens.name}; images are simulated without it."
    else:
        yield (
            f"{lens.name} distorts by {lens.distortion_percent:g} %; images are simulated without it, unless "
            f"the recipe has an effect of lens distortion."
        )
