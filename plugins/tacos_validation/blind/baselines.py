"""Simpler ways to name a cause, to be compared with on the same cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.formation import EpisodeDraws, PlacedEffect
from tacos_gap.answer.findings import Diagnosis
from tacos_gap.captures import RealCapture
from tacos_gap.evidence import PictureEvidence
from tacos_gap.hypotheses.parameters import HypothesisTerm, initial_guesses_of
from tacos_gap.inference.fit import Fitted
from tacos_gap.inference.problem import Problem, robust
from tacos_gap.simulation.formation import simulate

WAYS = ("pixel-MSE greedy", "BIC without held-out", "leave-one-out", "no nuisance refit")
LEAST_GAIN = 0.02
"""Relative fall of the pixel error below which the greedy way names nothing."""


def simpler_answers(found: Diagnosis, effects: Mapping[str, type[Any]]) -> dict[str, list[str]]:
    """Effects named by each simpler method, best first; an empty list for nothing."""
    fits = list(found.attribution.fits.values())
    return {
        "pixel-MSE greedy": by_pixels(found.problem, effects),
        "BIC without held-out": by_bic(found.problem, fits),
        "leave-one-out": by_leaving_one_out(found.problem, fits),
        "no nuisance refit": by_starts(found.problem, effects),
    }


def by_pixels(problem: Problem, effects: Mapping[str, type[Any]]) -> list[str]:
    """The effect whose simulation comes nearest in mean squared pixel error, on one capture of each kind."""
    captures: dict[str, RealCapture] = {}
    for evidence in problem.evidence:
        if isinstance(evidence, PictureEvidence):
            captures.setdefault(evidence.capture.kind, evidence.capture)
    chosen = list(captures.values())
    if not chosen:
        return []
    plain = _pixel_error(chosen, ())
    best: tuple[float, str] = (plain * (1 - LEAST_GAIN), "")
    for name, cls in effects.items():
        for guess in initial_guesses_of(name, cls):
            effect = guess.placed()
            if effect is None:
                continue
            error = _pixel_error(chosen, (effect,))
            best = min(best, (error, name))
    return [best[1]] if best[1] else []


def _pixel_error(captures: Sequence[RealCapture], effects: Sequence[PlacedEffect]) -> float:
    total = 0.0
    for capture in captures:
        frames = simulate(capture, effects, EpisodeDraws(0, ("pixels", capture.id)), frames=1)
        total += float(np.mean((capture.real_dn[0] - frames[0]) ** 2))
    return total


def by_bic(problem: Problem, fits: Sequence[Fitted]) -> list[str]:
    """The fitted set of effects with the best Bayesian information criterion, on what it was fitted to."""
    count = max(len(problem.labels), 2)

    def criterion(fitted: Fitted) -> float:
        parameters = sum(len(term.free) for term in fitted.hypothesis)
        return float(np.sum(robust(fitted.z) ** 2)) + parameters * float(np.log(count))

    return list(min(fits, key=criterion).names)


def by_leaving_one_out(problem: Problem, fits: Sequence[Fitted]) -> list[str]:
    """The effect that best predicts each capture from the fit to all others; no sets, no penalty."""
    singles = [fitted for fitted in fits if len(fitted.hypothesis) <= 1]
    return list(min(singles, key=lambda fitted: _left_out(problem, fitted)).names)


def _left_out(problem: Problem, fitted: Fitted) -> float:
    straight, jacobian = robust(fitted.z), fitted.jacobian
    if not jacobian.shape[1]:
        return float(np.sum(straight**2))
    total = 0.0
    for slot in problem.slots:
        held = np.zeros(len(straight), bool)
        held[slot.start : slot.stop] = True
        own = jacobian[~held]
        move = -np.linalg.solve(own.T @ own + np.eye(own.shape[1]), own.T @ straight[~held])
        total += float(np.sum((straight[held] + jacobian[held] @ np.clip(move, -2, 2)) ** 2))
    return total


def by_starts(problem: Problem, effects: Mapping[str, type[Any]]) -> list[str]:
    """The effect that leaves least at one of the severities its search begins with, nothing fitted."""
    best: tuple[float, str] = (_cost(problem.null), "")
    for name, cls in effects.items():
        for guess in initial_guesses_of(name, cls):
            best = min([best, *_scaled_costs(problem, guess)])
    return [best[1]] if best[1] else []


def _scaled_costs(problem: Problem, guess: HypothesisTerm) -> list[tuple[float, str]]:
    z = problem.residual((guess,))
    if z is None:
        return []
    change: NDArray[np.float64] = z - problem.null
    return [(_cost(problem.null + scale * change), guess.name) for scale in (0.3, 1.0, 2.0)]


def _cost(z: NDArray[np.float64]) -> float:
    return float(np.sum(robust(z) ** 2))
