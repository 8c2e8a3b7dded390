"""A lens of spherical surfaces: read from a table, to first order, and traced ray by ray."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from tacos_framework import Fault, UserError
from tacos_framework.files import read_csv

Floats = NDArray[np.float64]

TRIPLET = Path(__file__).parent / "lenses" / "cooke_triplet.csv"
COLUMNS = ["radius_mm", "thickness_mm", "index", "semi_diameter_mm", "stop"]


@dataclass(frozen=True)
class Surface:
    """A sphere, and what lies behind it up to the next surface, or up to the image."""

    radius_mm: float
    thickness_mm: float
    index: float
    semi_diameter_mm: float
    is_stop: bool


@dataclass(frozen=True)
class Rays:
    """Where rays cross the stop and the image, (N, 2) [mm], their directions there, and which get there."""

    stop_mm: Floats
    image_mm: Floats
    direction: Floats
    passed: NDArray[np.bool_]


@dataclass(frozen=True)
class Prescription:
    """Surfaces in the order in which light meets them, for an object at infinity."""

    surfaces: tuple[Surface, ...]

    @property
    def focal_length_mm(self) -> float:
        """The effective focal length: height of a paraxial ray over the angle at which it leaves."""
        return -1.0 / self._paraxial()[1]

    def stop_radius_mm(self, f_number: float) -> float:
        """Radius to which the stop is opened for an f-number."""
        return self.focal_length_mm / (2 * f_number) * self._paraxial()[0]

    def _paraxial(self) -> tuple[float, float]:
        """Height at the stop and final slope of a paraxial ray that comes in at height 1, along the axis."""
        height, slope, index, at_stop = 1.0, 0.0, 1.0, math.nan
        for surface in self.surfaces:
            power = (surface.index - index) / surface.radius_mm
            slope, index = (index * slope - height * power) / surface.index, surface.index
            at_stop = height if surface.is_stop else at_stop
            height += surface.thickness_mm * slope
        return at_stop, slope

    def trace(self, start_mm: Floats, field_rad: float, stop_radius_mm: float = math.inf) -> Rays:
        """Rays of one field angle through the lens, by Snell's law in three dimensions.

        Parameters
        ----------
        start_mm
            (N, 2) where they cross the plane through the first vertex [mm].
        field_rad
            Angle in the plane x = 0 [rad].
        stop_radius_mm
            What the stop lets through; by default rays pass whatever is opaque [mm].
        """
        place = np.column_stack([start_mm, np.zeros(len(start_mm))])
        direction = np.tile([0.0, math.sin(field_rad), math.cos(field_rad)], (len(place), 1))
        passed, stop_mm, index = np.ones(len(place), bool), np.full(start_mm.shape, np.nan), 1.0
        with np.errstate(invalid="ignore"):  # a ray that misses a sphere, or is reflected, is not a number
            for surface in self.surfaces:
                place, direction = _refracted(place, direction, 1 / surface.radius_mm, index / surface.index)
                index, height = surface.index, np.hypot(place[:, 0], place[:, 1])
                opening = surface.semi_diameter_mm
                if surface.is_stop:
                    stop_mm, opening = place[:, :2], min(opening, stop_radius_mm)
                passed &= (height <= opening) if math.isfinite(stop_radius_mm) else np.isfinite(height)
                place = place - [0.0, 0.0, surface.thickness_mm]
            image_mm = place[:, :2] - place[:, 2:] * direction[:, :2] / direction[:, 2:]
        return Rays(stop_mm, image_mm, direction, passed & np.isfinite(image_mm).all(axis=1))


def _refracted(place: Floats, direction: Floats, curvature: float, ratio: float) -> tuple[Floats, Floats]:
    """Places on a sphere through the origin, and directions behind it; `ratio` is of indices, n / n'."""
    place = place - direction * (
        place[:, 2:] / direction[:, 2:]
    )  # to the vertex: the near side of the sphere
    along = direction[:, 2] - curvature * np.sum(place * direction, axis=1)
    off = curvature * np.sum(place**2, axis=1)
    place = place + direction * (off / (along + np.sqrt(along**2 - curvature * off)))[:, None]
    normal = np.array([0.0, 0.0, 1.0]) - curvature * place
    cosine = np.sum(direction * normal, axis=1)
    behind = np.sqrt(1 - ratio**2 * (1 - cosine**2))
    return place, ratio * direction + (behind - ratio * cosine)[:, None] * normal


def read_prescription(path: Path) -> Prescription:
    """A lens from a table with the columns `COLUMNS`; lines that begin with # are comments.

    Raises
    ------
    UserError
        With all that is wrong in it.
    """
    lines = [(at, cells) for at, cells in read_csv(path) if cells and not cells[0].startswith("#")]
    if not lines or lines[0][1] != COLUMNS:
        raise UserError(Fault(str(path), "the first line is not that of a lens", ",".join(COLUMNS)))
    surfaces, faults = [], []
    for at, cells in lines[1:]:
        try:
            radius, thickness, index, semi_diameter = map(float, cells[:4])
            if not (radius and thickness >= 0 and index >= 1 and semi_diameter > 0 and len(cells) == 5):
                raise ValueError
            surfaces.append(Surface(radius, thickness, index, semi_diameter, cells[4] == "stop"))
        except ValueError:
            expected = (
                "a radius (inf of a plane), thickness >= 0, index >= 1, semi-diameter > 0, stop or nothing"
            )
            faults.append(Fault(f"{path}:{at}", f"no surface: {','.join(cells)}", expected))
    if not faults and sum(surface.is_stop for surface in surfaces) != 1:
        faults.append(Fault(str(path), "a lens has one stop", "the word stop in the last column of one line"))
    lens = Prescription(tuple(surfaces))
    if not faults and not 0 < lens.focal_length_mm < math.inf:
        faults.append(Fault(str(path), "the lens makes no image of far things", "a focal length above 0"))
    if faults:
        raise UserError(faults)
    return lens
