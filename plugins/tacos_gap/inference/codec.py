"""A codec that files went through, which is modelled before anything else is judged."""

from __future__ import annotations

import numpy as np

from tacos_gap.hypotheses.by_capture import captures_with_values
from tacos_gap.inference.discrete import searched
from tacos_gap.inference.problem import Hypothesis, Problem, robust
from tacos_gap.inference.screening import ScreeningDirections

SEEN = 4.0
"""Mean square of the traces of a codec above which there is one [squared noise floor]."""

EXPLAINED = 0.7
"""Share of these traces that a codec must explain."""


def codec_of_files(problem: Problem, directions: ScreeningDirections) -> Hypothesis:
    """The effect of the stage codec that the traces of codecs show; none where they show none.

    What leaves such traces is no rival of what happens before it: a gain map does not end at borders of
    blocks.
    """
    traces = np.array([label.stage == "codec" for label in problem.labels], bool)
    if not traces.any() or np.mean(robust(problem.null[traces]) ** 2) < SEEN:
        return ()
    best: Hypothesis = ()
    least = (1 - EXPLAINED) * _cost(problem.null[traces])
    for of_effect in directions.values():
        if of_effect[0].term.cls.stage != "codec":
            continue
        # Where all captures are coded alike, what their files say goes before a guess that may be searched.
        nearest = min(
            of_effect,
            key=lambda d: (_cost((problem.null + d.change)[traces]), not captures_with_values(d.term.values)),
        )
        found = searched(problem, (nearest.term,), traces)
        z = problem.residual(found)
        if z is not None and (left := _cost(z[traces])) < least:
            best, least = found, left
    return best


def _cost(z: np.ndarray) -> float:
    return float(np.sum(robust(z) ** 2))
