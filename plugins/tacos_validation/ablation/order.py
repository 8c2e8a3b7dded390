"""The order of cameras by a study, and which of them are as good as the best."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tacos_validation.rank_agreement.agreement import Agreement, FitnessOn


@dataclass(frozen=True)
class Order:
    """The order of the cameras by one variant of the study, beside that of the study as it stands."""

    variant: str
    agreement: Agreement
    best: str
    equal: tuple[str, ...]
    """Cameras that the scenes do not show to be worse than the best, itself among them."""
    moved: float
    """Largest change of a camera's place [1]."""
    moved_camera: str
    fitness: Mapping[str, float]


def is_worse(camera: str, best: str, fitness: FitnessOn, scenes: int, confidence: float) -> bool:
    """True if the interval of the difference of two cameras over the scenes lies below 0 (Student's t)."""
    from scipy.stats import t

    pairs = [(fitness(camera, [scene]), fitness(best, [scene])) for scene in range(scenes)]
    difference = np.array([one - other for one, other in pairs if one is not None and other is not None])
    count = len(difference)
    if camera == best or count < 2:
        return False
    margin = t.ppf((1 + confidence) / 2, count - 1) * difference.std(ddof=1) / count**0.5
    return bool(difference.mean() + margin < 0)
