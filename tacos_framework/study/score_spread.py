"""Spread of each score between cameras, against its spread between scenes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework.contracts import Scores

FULL = 0.1
"""Below this share of the variance it takes some 70 scenes to tell two usual cameras apart at 95 %."""


@dataclass(frozen=True)
class ScoreSpread:
    """Spread of a score between cameras."""

    share_of_variance: float
    """Variance between cameras, over it and what a scene does to one camera and not to the others, 0..1."""
    value: float
    """Mean over the cameras, in the score's unit."""

    @property
    def full(self) -> bool:
        """True if it decides nothing: it is at its end, or scatters from scene to scene."""
        return self.share_of_variance < FULL


def share_between(scores: NDArray[np.float64]) -> float:
    """Share of the variance that is between cameras, of (C, S) scores of C cameras on the same S scenes.

    Scenes count as random and their mean is taken out, as comparisons are paired: a two-way analysis of
    variance without repetition, with the moments of its mean squares.

    Source: Searle, Casella, McCulloch 1992, "Variance components", Sec. 4.3.

    A scene that is harder for both leaves the difference of two cameras as clear as it was:

    >>> share_between(np.array([[0.9, 0.5, 0.7], [0.8, 0.4, 0.6]]))
    1.0
    """
    cameras, scenes = scores.shape
    of_cameras = scores.mean(axis=1, keepdims=True)
    left = scores - of_cameras - scores.mean(axis=0) + scores.mean()
    scatter = float(np.sum(left**2)) / ((cameras - 1) * (scenes - 1))
    between = max(0.0, float(of_cameras.var(ddof=1)) - scatter / scenes)
    rounding = 1e-12 * float(np.abs(scores).max()) ** 2
    return between / (between + scatter) if between > rounding else 0.0


def score_spreads(names: Iterable[str], blocks: Sequence[Sequence[Scores]]) -> dict[str, ScoreSpread]:
    """The spread of each score that all cameras have in at least two scenes.

    `blocks`: for each camera its scores on the same scenes.
    """
    found = {}
    for name in names:
        shared = [scene for scene in zip(*blocks, strict=True) if all(name in scores for scores in scene)]
        if len(blocks) > 1 and len(shared) > 1:
            table = np.array([[scores[name] for scores in scene] for scene in shared], np.float64).T
            found[name] = ScoreSpread(share_between(table), float(table.mean()))
    return found


def full_scores(spreads: Mapping[str, ScoreSpread]) -> str | None:
    """Those that decide nothing, in a sentence that says what to change; None where all do."""
    full = {name: spread for name, spread in spreads.items() if spread.full}
    if not full:
        return None
    each = ", ".join(
        f"{name} (at {spread.value:.3g}, {spread.share_of_variance:.0%} of its variance)".replace("%", " %")
        for name, spread in full.items()
    )
    all_full = len(full) == len(spreads)
    which = "No score of the fitness separates" if all_full else "These scores do not separate"
    return (
        f"{which} the cameras of the test: {each}. Choose scenes, light or motion in which cameras "
        "differ, or a graded score; removing them changes little."
    )
