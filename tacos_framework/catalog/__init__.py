"""Catalogs: parts and cameras that can be bought, and measured noise, with units and provenance."""

from __future__ import annotations

from tacos_framework.catalog.cameras import OffTheShelf, camera_names, load_cameras
from tacos_framework.catalog.checks import CURRENCIES, in_words
from tacos_framework.catalog.parts import Catalog, CatalogColumn
from tacos_framework.catalog.reader import catalog_names, find_catalog, read_catalog
from tacos_framework.values.catalog_part import CatalogPart, Grade

__all__ = [
    "CURRENCIES",
    "Catalog",
    "CatalogColumn",
    "CatalogPart",
    "Grade",
    "OffTheShelf",
    "camera_names",
    "catalog_names",
    "find_catalog",
    "in_words",
    "load_cameras",
    "read_catalog",
]
