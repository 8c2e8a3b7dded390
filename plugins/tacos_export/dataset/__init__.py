"""Rendered frames as data sets: one writer a format, all fed the same frames.

Every data set has a ``frames.json`` with intrinsics, lens, poses and times of all frames, whatever else its
format can say; `tacos_export.conventions` states the units and axes.
"""

from __future__ import annotations

from tacos_export.dataset.export import FORMATS, export_dataset

__all__ = ["FORMATS", "export_dataset"]
