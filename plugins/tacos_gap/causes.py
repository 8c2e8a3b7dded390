"""From the best explanation to causes: with probabilities, intervals and evidence, and as a set."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tacos_framework.randomness import generator
from tacos_framework.settings import unit_of
from tacos_gap.ambiguity import NextCapture, confused_with
from tacos_gap.attribution import Attribution
from tacos_gap.captures import RealCapture
from tacos_gap.closure import bootstrap_interval, closure, shapley
from tacos_gap.findings import Cause, Parameter, as_fine_as, short
from tacos_gap.fit import Fitted
from tacos_gap.intervals import half_widths
from tacos_gap.parameters import HypothesisTerm
from tacos_gap.presence import completeness_where_it_shows, support
from tacos_gap.problem import Problem, robust
from tacos_gap.transfer import Photographed, of_specimen
from tacos_gap.unknown import Unexplained, block_index

CONFIDENCE = 0.9
"""Probability with which a set of causes is to hold the truth, and an interval its parameter."""

_LARGEST_PROBABILITY = 0.99


def causes_of(
    problem: Problem,
    attribution: Attribution,
    left: Unexplained,
    captures: Sequence[RealCapture],
    effects: Mapping[str, type[Any]],
    seed: int,
) -> list[Cause]:
    """The effects of the best explanation, those with the largest share first.

    Parameters
    ----------
    problem
        The evidence.
    attribution
        The best explanation and its rivals.
    left
        What it leaves.
    captures
        All captures.
    effects
        The classes of all candidates by name, which say what looks alike.
    seed
        Seeds the bootstrap.
    """
    best = attribution.best
    if not best.hypothesis:
        return []
    before = problem.gap(problem.null)
    groups = block_index(problem)
    half_width = half_widths(problem, best, CONFIDENCE)
    values = _subset_closures(problem, best, before)
    shares = shapley(best.names, lambda names: values[names])
    interval = bootstrap_interval(
        robust(problem.null) ** 2,
        robust(best.held_out) ** 2,
        problem.noise_floor_rms,
        groups,
        generator(seed, "closure"),
    )
    camera = Photographed.of(captures)
    causes, start = [], 0
    for term in best.hypothesis:
        stop = start + len(term.free)
        rest = tuple(name for name in best.names if name != term.name)
        alone = values[(term.name,)]
        own = values[best.names] - values[rest] if len(best.names) > 1 else values[best.names]
        probabilities = slot_probabilities(attribution.slots[term.name])
        rivals = sorted(
            (n for n in probabilities if n not in ("", term.name)), key=lambda n: -probabilities[n]
        )
        alike = list(confused_with(term.name, effects, captures))
        certainty = min(probabilities[term.name], _LARGEST_PROBABILITY)
        if alike:
            certainty = min(certainty, 1.0 / (1 + len(alike)))
        without = problem.residual(tuple(t for t in best.hypothesis if t.name != term.name))
        shown = 1 - left.probability
        if without is not None:
            shown = completeness_where_it_shows(problem, support(problem, best.z, without), left)
        near = [name for name in rivals if probabilities[name] > 0.05]
        causes.append(
            Cause(
                effect=term.name,
                probability=certainty * (1 - left.probability),
                parameters=_parameters(term, half_width[start:stop], camera),
                closure=values[best.names] if len(best.names) == 1 else own,
                closure_interval=interval,
                closure_alone=alone,
                shapley=shares[term.name],
                confused_with=tuple(dict.fromkeys([*alike, *near])),
                evidence=_evidence(problem, best, term, rest, attribution),
                settings=_settings(term),
                present=certainty * max(shown, 1 - left.probability),
                specimen=tuple(n for n in term.settings if of_specimen(term.cls.Config, n)),
            )
        )
        start = stop
    return sorted(causes, key=lambda cause: -cause.shapley)


def _subset_closures(problem: Problem, best: Fitted, before: float) -> dict[tuple[str, ...], float]:
    """Held-out closure of every subset of the effects, their parameters as fitted together."""
    from itertools import combinations

    values: dict[tuple[str, ...], float] = {(): 0.0}
    for size in range(1, len(best.hypothesis) + 1):
        for subset in combinations(best.hypothesis, size):
            names = tuple(term.name for term in subset)
            if names == best.names:
                values[names] = closure(before, problem.gap(best.held_out))
                continue
            z = problem.residual(subset)
            values[names] = 0.0 if z is None else closure(before, problem.gap(z))
    return values


def _times(nats: float) -> str:
    """A ratio of likelihoods, given by its logarithm [nat], in words.

    >>> _times(0.7), _times(5.0), _times(23.0)
    ('2.0 times', '148 times', 'more than a million times')
    """
    if nats > math.log(1e6):
        return "more than a million times"
    return f"{math.exp(nats):.{1 if nats < math.log(10) else 0}f} times"


def _parameters(term: HypothesisTerm, half_width: Any, camera: Photographed) -> dict[str, Parameter]:
    found: dict[str, Parameter] = {}
    settings = term.settings
    reach = dict(zip(term.free, half_width, strict=True))
    for name, value in settings.items():
        if name in reach:
            half = float(reach[name])
            ends = (as_fine_as(half, value - half), as_fine_as(half, value + half))
            found[name] = Parameter(as_fine_as(half, value), ends, unit_of(term.cls.Config, name))
        elif name == "matrix":
            rows = [[short(v) for v in row] for row in value]
            found[name] = Parameter(rows, None, unit_of(term.cls.Config, name))
        else:
            found[name] = Parameter(value, None, unit_of(term.cls.Config, name))
    return {
        name: camera.in_physical_units(term.cls.Config, parameter, name) for name, parameter in found.items()
    }


def _settings(term: HypothesisTerm) -> dict[str, Any]:
    """Settings for a recipe, in plain numbers."""
    plain: dict[str, Any] = {}
    for name, value in term.settings.items():
        if isinstance(value, tuple):
            plain[name] = [[short(v) for v in row] for row in value]
        else:
            plain[name] = short(value) if isinstance(value, float) else value
    return plain


def _evidence(
    problem: Problem, best: Fitted, term: HypothesisTerm, rest: tuple[str, ...], attribution: Attribution
) -> str:
    """The statistic that the effect explains most of, in a sentence."""
    without = problem.residual(tuple(t for t in best.hypothesis if t.name != term.name))
    scores = attribution.slots[term.name]
    rivals = {name: score for name, score in scores.items() if name not in ("", term.name)}
    second = max(rivals, key=lambda name: rivals[name]) if rivals else None
    lead = ""
    if second:
        ahead = scores[term.name] - rivals[second]
        lead = f"; captures held out are {_times(ahead)} likelier with it than with {second}"
    if without is None:
        return f"The captures ask for it{lead}."
    gain: dict[str, float] = {}
    size: dict[str, tuple[float, float, int]] = {}
    for label, a, b in zip(problem.labels, without, best.z, strict=True):
        gain[label.statistic] = gain.get(label.statistic, 0.0) + float(
            robust(np.array(a)) ** 2 - robust(np.array(b)) ** 2
        )
        x, y, n = size.get(label.statistic, (0.0, 0.0, 0))
        size[label.statistic] = (x + float(a) ** 2, y + float(b) ** 2, n + 1)
    top = max(gain, key=lambda name: gain[name])
    x, y, n = size[top]
    name = top.replace("_", " ").capitalize()
    without_it, with_it = np.sqrt(x / n), np.sqrt(y / n)
    return (
        f"{name} differs by {without_it:.1f} times the noise floor without it "
        f"and by {with_it:.1f} with it{lead}."
    )


# sets -----------------------------------------------------------------------------------------------------


def slot_probabilities(scores: Mapping[str, float]) -> dict[str, float]:
    """Probability of each effect in one place of the explanation, from log scores on held-out conditions."""
    names = list(scores)
    values = np.array([scores[name] for name in names])
    weights = np.exp(np.clip(values - values.max(), -700, 0))
    return dict(zip(names, (weights / weights.sum()).tolist(), strict=True))


def cause_set_of(
    causes: Sequence[Cause],
    attribution: Attribution,
    captures: Sequence[RealCapture],
    effects: Mapping[str, type[Any]],
) -> tuple[tuple[str, ...], NextCapture | None]:
    """The smallest set that holds the truth with `CONFIDENCE`, and a capture that would make it smaller."""
    chosen: list[str] = []
    wanted: NextCapture | None = None
    for cause in causes:
        probabilities = slot_probabilities(attribution.slots[cause.effect])
        held = 0.0
        for name in sorted(probabilities, key=lambda n: -probabilities[n]):
            if name and name not in chosen:
                chosen.append(name)
            held += probabilities[name]
            if held >= CONFIDENCE:
                break
        for other, capture in confused_with(cause.effect, effects, captures).items():
            wanted = wanted or capture
            if other not in chosen:
                chosen.append(other)
    return tuple(chosen), wanted
