"""Is the designed camera better, and by how much: differences with their uncertainty."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from tacos_report.study_data import CameraResult

Outcome = Literal["better", "worse", "undecided"]

CONFIDENCE = 0.95
"""How sure the report must be before it calls one of two cameras better."""


MOST_SHARE = 2.0
"""Larger relative changes are told as differences: +200 % still reads as a change, +7842 % does not."""


@dataclass(frozen=True)
class CameraDifference:
    """Designed camera minus another, on the same test scenes.

    ``error`` is half the width of the interval of `CONFIDENCE` around the difference, None where it cannot
    be told. It is Student's, of the differences episode by episode, since all cameras see the same scenes.
    """

    designed: float
    other: float
    error: float | None
    higher_is_better: bool = True

    @property
    def value(self) -> float:
        """The difference; above 0 means that the designed camera's number is larger."""
        return self.designed - self.other

    @property
    def share(self) -> float | None:
        """The difference relative to the other camera's value; None where that says little.

        It says little where the other value is near zero, by its uncertainty or beside the difference.
        """
        if self.other <= max(1e-9, self.error or 0.0, abs(self.value) / MOST_SHARE):
            return None
        return self.value / self.other

    @property
    def outcome(self) -> Outcome:
        """``better`` or ``worse`` for the designed camera; ``undecided`` where the interval holds zero."""
        gain = self.value if self.higher_is_better else -self.value
        if abs(gain) <= (self.error or 0.0):
            return "undecided"
        return "better" if gain > 0 else "worse"


def difference(
    designed: CameraResult, other: CameraResult, score: str, *, higher_is_better: bool = True
) -> CameraDifference | None:
    """The difference in one score, or in ``fitness``; None where one of the cameras has no such number."""
    ours, theirs = _value(designed, score), _value(other, score)
    if ours is None or theirs is None:
        return None
    pairs = zip(designed.episodes, other.episodes, strict=False)
    differences = [a[score] - b[score] for a, b in pairs if score in a and score in b]
    return CameraDifference(ours, theirs, half_width(differences), higher_is_better)


def half_width(values: Sequence[float]) -> float | None:
    """Half the width of Student's interval of `CONFIDENCE` around the mean; None below two values."""
    if len(values) < 2:
        return None
    from scipy.special import stdtrit

    quantile = float(stdtrit(len(values) - 1, (1 + CONFIDENCE) / 2))
    return quantile * statistics.stdev(values) / math.sqrt(len(values))


def best_of(cameras: Sequence[CameraResult]) -> CameraResult | None:
    """The camera of highest fitness on the test scenes; None where none was tested."""
    tested = [camera for camera in cameras if camera.fitness is not None]
    return max(tested, key=lambda camera: camera.fitness or 0.0, default=None)


def score_names(cameras: Sequence[CameraResult], weights: Mapping[str, float]) -> list[str]:
    """Every score some camera has: those of the fitness first, in its order, then the others."""
    present = dict.fromkeys(score for camera in cameras for score in camera.scores)
    return [*(score for score in weights if score in present), *(s for s in present if s not in weights)]


def _value(camera: CameraResult, score: str) -> float | None:
    return camera.fitness if score == "fitness" else camera.scores.get(score)
