"""Frozen values that cross ports, with shapes, dtypes and units. Their arrays are read-only."""

from __future__ import annotations

from tacos_framework.values.brown_conrady import BrownConrady
from tacos_framework.values.camera import Camera, Electrons, Exposure, Rig
from tacos_framework.values.candidate import Candidate
from tacos_framework.values.catalog_part import CatalogPart
from tacos_framework.values.episode import TRUTHS, Crossing, Episode, Mover, Trajectory
from tacos_framework.values.image_geometry import ContextMissing, ImageContext, ImageGeometry
from tacos_framework.values.images import Capture, FrameBatch, View
from tacos_framework.values.lens import PINHOLE, Lens, Projection
from tacos_framework.values.world import Light, Material, MeshPart, Object, World

__all__ = [
    "PINHOLE",
    "TRUTHS",
    "BrownConrady",
    "Camera",
    "Candidate",
    "Capture",
    "CatalogPart",
    "ContextMissing",
    "Crossing",
    "Electrons",
    "Episode",
    "Exposure",
    "FrameBatch",
    "ImageContext",
    "ImageGeometry",
    "Lens",
    "Light",
    "Material",
    "MeshPart",
    "Mover",
    "Object",
    "Projection",
    "Rig",
    "Trajectory",
    "View",
    "World",
]
