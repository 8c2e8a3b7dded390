"""Effects that views of boards cannot show, since their poses are unknown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tacos_gap.evidence import Evidence
from tacos_gap.evidence.boards.evidence import BoardEvidence
from tacos_gap.hypotheses.ambiguity import NextCapture, confused_with
from tacos_gap.hypotheses.parameters import initial_guesses_of

POSE = "pose-error"

UNSEEN = 0.05
"""Mean square of what an effect changes in views, up to which poses hide it [noise floor^2]."""


def hidden_by_pose(
    evidence: Sequence[Evidence], effects: Mapping[str, type[Any]]
) -> tuple[tuple[str, ...], NextCapture | None]:
    """Effects that only boards could show and that their poses hide: no gap is no proof of none.

    Returns: those that declare a pose as their look-alike here, with it; and the capture that would tell.
    Empty where all of them would have shown.
    """
    boards = [each for each in evidence if isinstance(each, BoardEvidence)]
    if not boards or len(boards) < len(evidence) or POSE not in effects:
        return (), None
    alike = confused_with(POSE, effects, [board.capture for board in boards])
    found = {name: wanted for name, wanted in alike.items() if not _shows(name, effects[name], boards)}
    return ((*found, POSE) if found else (), next(iter(found.values()), None))


def _shows(name: str, cls: type[Any], boards: Sequence[BoardEvidence]) -> bool:
    """True if an effect at some initial guess changes the views, or at none moves what a pose could hide."""
    moves = False
    for term in initial_guesses_of(name, cls):
        placed = term.placed()
        if placed is None:
            continue
        changes = np.concatenate([board.residual([placed]) - board.residual(()) for board in boards])
        if np.mean(changes**2) > UNSEEN:
            return True
        moves = moves or any(board.moves(placed) for board in boards)
    return not moves
