"""Files of catalogs, written for a test."""

from __future__ import annotations

from pathlib import Path

import pytest

from tacos_framework.catalog import Catalog, read_catalog
from tacos_framework.errors import UserError

HEAD = """\
title: Two sensors
source: me
columns:
  width_px:  {type: integer, required: true, help: Width.}
  height_px: {type: integer, help: Height.}
  pixel_um:  {help: Pitch.}
  width_mm:  {help: Width.}
  height_mm: {help: Height.}
  offset_mm: {positive: false, help: Offset.}
  maker:     {type: text, help: Maker.}
parts:
"""
FIRST = HEAD.count("\n") + 1
TABLE = """\
name,width_px,height_px,pixel_um,maker,weight,source,doubts
A,1000,800,2.5,"Maker, Inc.",-1.5,data sheet,
B,500,400,unknown,,,,Odd.

C,640,480,3e0,X,2,,
"""


def write(folder: Path, text: str, name: str = "sensors.yaml") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def read(folder: Path, parts: str) -> Catalog:
    return read_catalog(write(folder, HEAD + parts))


def faults_of(path: Path) -> list[tuple[str, str]]:
    with pytest.raises(UserError) as caught:
        read_catalog(path)
    return [(fault.where.removeprefix(f"{path}:"), fault.what) for fault in caught.value.faults]
