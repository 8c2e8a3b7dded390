"""Catalogs: parts that can be bought, with units, provenance and honest unknowns."""

from __future__ import annotations

from tacos_framework.catalog.parts import Catalog, Column, Part

__all__ = ["Catalog", "Column", "Part"]
