"""Captures turned into standardised differences between the real camera and a simulation of it."""

from tacos_gap.evidence.contract import (
    N_NULL_REPLICATES,
    Evidence,
    Label,
    PictureEvidence,
    ReplicateResiduals,
)
from tacos_gap.evidence.image_evidence import SPREAD_OF_ONE, ImageEvidence

__all__ = [
    "N_NULL_REPLICATES",
    "SPREAD_OF_ONE",
    "Evidence",
    "ImageEvidence",
    "Label",
    "PictureEvidence",
    "ReplicateResiduals",
]
