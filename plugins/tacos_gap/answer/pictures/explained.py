"""Share of the difference between pictures and expectation that an effect on light explains.

Statistics of detail are strict to a few hundredths, and so they should be: they find small effects. A real
picture out of focus never meets that: depth, glints and what its expectation was made of leave a rest. That a
disc takes nine tenths of the squared difference out of a picture, and nothing else does, shows the disc all
the same.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from tacos_framework import LIGHT_STAGES, generator
from tacos_gap.answer.pictures.misfit import TILES, tile_squares
from tacos_gap.captures import RealCapture
from tacos_gap.evidence import PictureEvidence
from tacos_gap.hypotheses.parameters import HypothesisTerm, initial_guesses_for
from tacos_gap.inference.presence import BY_PICTURES
from tacos_gap.inference.problem import Hypothesis, Problem, placed_in
from tacos_gap.nuisances import freedoms_of

RESAMPLES = 400
LOW = 5.0
"""Percentile of the share over resampled tiles that is believed."""


def share_of_pictures(
    problem: Problem, hypothesis: Hypothesis, term: HypothesisTerm, rivals: Sequence[Hypothesis], seed: int
) -> float:
    """Share of the squared difference of pictures that an effect explains, at the least (95 %).

    Noise is part of the difference: what hardly exceeds it is for the statistics to tell.

    - `rivals`: explanations with another effect in its place. Each also stands with that effect's initial
      guesses, as its fit may have gone astray.

    Returns: 0..1; 0 where it acts on no light, pictures show nothing to align, or a rival is not surely
    worse.
    """
    pictures = [e for e in problem.evidence if isinstance(e, PictureEvidence) and _can_be_aligned(e)]
    if term.cls.stage not in LIGHT_STAGES or not pictures:
        return 0.0
    without = tuple(each for each in hypothesis if each.name != term.name)
    drawn = _DrawnTiles(pictures, generator(seed, "picture", term.name))
    squares = drawn.squares_of([hypothesis, without])
    if squares is None:
        return 0.0
    with_it, before = squares
    share = 1 - with_it / np.maximum(before, 1e-9)
    least = float(np.clip(np.percentile(share, LOW), 0.0, 1.0))
    if BY_PICTURES.by(least) == 0.0:
        return least
    for rival in _with_guesses(without, rivals, [each.capture for each in pictures]):
        both = drawn.squares_of([hypothesis, rival])
        if both is None or np.percentile(both[1] - both[0], LOW) <= 0:
            return 0.0
    return least


class _DrawnTiles:
    """Sums of squares over resampled tiles of all pictures, the same for every hypothesis."""

    def __init__(self, pictures: Sequence[PictureEvidence], rng: np.random.Generator):
        self._pictures = pictures
        self._weights = [rng.multinomial(TILES, np.full(TILES, 1 / TILES), RESAMPLES) for _ in pictures]

    def squares_of(self, hypotheses: Sequence[Hypothesis]) -> NDArray[np.float64] | None:
        """(J, RESAMPLES) squares each hypothesis leaves over common pixels; None where one does not align."""
        total = np.zeros((len(hypotheses), RESAMPLES))
        for evidence, weights in zip(self._pictures, self._weights, strict=True):
            squares = tile_squares(evidence.capture, [placed_in(each, evidence) for each in hypotheses])
            if squares is None:
                return None
            total += squares @ weights.T
        return total


def _with_guesses(
    rest: Hypothesis, rivals: Sequence[Hypothesis], captures: Sequence[RealCapture]
) -> Iterator[Hypothesis]:
    """Rivals that act on light, as fitted and at their initial guesses; others change no expectation."""
    known = {each.name for each in rest}
    for rival in rivals:
        for term in rival:
            if term.name not in known and term.cls.stage in LIGHT_STAGES:
                yield rival
                for guess in initial_guesses_for(term.name, term.cls, captures):
                    yield (*rest, guess)


def _can_be_aligned(evidence: PictureEvidence) -> bool:
    return any(freedom.name == "shift_x_px" for freedom in freedoms_of(evidence.capture))
