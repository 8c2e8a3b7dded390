"""Names of the classes of objects."""

from __future__ import annotations

CLASS_NAMES = (
    "background",
    "sofa",
    "bed",
    "table",
    "chair",
    "bathtub",
    "basin",
    "computer_tv",
    "plant",
    "lamp",
    "toy",
    "threshold",
    "person",
    "book",
    "bottle",
    "bowl",
    "clock",
    "cup",
    "kettle",
    "paper",
    "plate",
    "remote",
    "vase",
)
"""Classes of objects indoors: furniture, what the agent steps over, people, small things."""
FURNITURE_CLASSES = CLASS_NAMES[1 : CLASS_NAMES.index("threshold")]
"""The ten that detectors look for, and that models of a user's own may replace."""
