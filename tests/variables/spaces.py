"""Spaces of sensors and settings that tests of the design space share."""

from __future__ import annotations

from typing import Any

from tacos_framework.catalog import Catalog, CatalogColumn, CatalogPart
from tacos_framework.variables.design_space import (
    CatalogChoice,
    Categorical,
    Continuous,
    DesignSpace,
    Integer,
)

COLUMNS = ("width_mm", "height_mm", "pixel_um")


def sensor(name: str, width_mm: float, height_mm: float, pixel_um: float) -> CatalogPart:
    return CatalogPart(
        name, {"width_mm": width_mm, "height_mm": height_mm, "pixel_um": pixel_um, "maker": None}
    )


SENSORS = (
    sensor("huge", 16.1, 12.0, 7.0),
    sensor("fine", 6.0, 4.5, 1.5),
    sensor("coarse", 6.2, 4.6, 9.0),
    sensor("tiny", 3.0, 2.3, 4.8),
)


UNKNOWN_PIXEL = CatalogPart(
    "unknown pixel", {"width_mm": 4.0, "height_mm": 3.0, "pixel_um": None, "maker": "x"}
)


def catalog(*rows: CatalogPart) -> Catalog:
    columns = (
        *(CatalogColumn(name, name[-2:], "Size.") for name in COLUMNS),
        CatalogColumn("maker", "1", "Maker.", "text"),
    )
    return Catalog("sensors", "Sensors", columns, rows, source="tests", design_columns=COLUMNS)


def sensor_choice(*rows: CatalogPart, **options: Any) -> CatalogChoice:
    return CatalogChoice("sensor", catalog(*(rows or SENSORS)), **options)


def full_space(**options: Any) -> DesignSpace:
    return DesignSpace(
        [
            Continuous("pitch_deg", -30, 30, "deg"),
            sensor_choice(**options),
            Integer("cameras", 1, 4),
            Categorical("lens", ("wide", "tele", 1, True, None)),
        ]
    )
