"""Findings of a validation of cameras."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from tacos_validation.cameras_validated.noise_curves import NoiseCurve
from tacos_validation.cameras_validated.patches import CameraPatch
from tacos_validation.cameras_validated.ranking import (
    STACKS,
    CameraScores,
    RankFinding,
    agreement_with_reality,
    as_data,
    level,
)


@dataclass(frozen=True, eq=False)
class CamerasFindings:
    patches: Mapping[str, CameraPatch]
    scores: tuple[CameraScores, ...]  # every score that all cameras have; those that a fitness counts first
    noise: Mapping[str, NoiseCurve]
    left_out: tuple[str, ...]
    seed: int

    @cached_property
    def agreements(self) -> dict[str, dict[str, RankFinding]]:
        """Of each score how far every stack ranks as reality does; ``real`` is reality under other noise."""
        return {
            scores.score: {stack: agreement_with_reality(scores, stack, self.seed) for stack in STACKS}
            for scores in self.scores
        }

    def as_data(self) -> dict[str, Any]:
        return {
            "cameras": {
                name: {"verdict": patch.verdict, "causes": list(patch.names)}
                for name, patch in self.patches.items()
            },
            "tasks": {
                scores.score: {
                    "scenes": list(scores.scenes),
                    "order": {stack: scores.order(stack) for stack in STACKS},
                    "agreement": {
                        stack: found.as_data() for stack, found in self.agreements[scores.score].items()
                    },
                    "levels": {
                        camera: {stack: as_data(level(scores, stack, i, self.seed)) for stack in STACKS}
                        for i, camera in enumerate(scores.cameras)
                    },
                }
                for scores in self.scores
            },
            "noise": {name: curve.as_data() for name, curve in self.noise.items()},
            "left_out": list(self.left_out),
        }
