"""From the best explanation to causes: with scores, intervals and evidence, and as a set."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tacos_framework import generator, includes_pedestal, unit_of
from tacos_gap.answer.findings import Cause, Parameter, as_fine_as, short
from tacos_gap.answer.pictures import share_of_pictures
from tacos_gap.answer.transfer import Photographed, of_specimen
from tacos_gap.attribution import Attribution
from tacos_gap.attribution.held_out import HeldOut
from tacos_gap.captures import RealCapture
from tacos_gap.hypotheses.ambiguity import NextCapture, confused_with
from tacos_gap.hypotheses.by_capture import of_capture, own_values
from tacos_gap.hypotheses.effect_names import effect_words
from tacos_gap.hypotheses.parameters import HypothesisTerm
from tacos_gap.inference.closure import closures_of
from tacos_gap.inference.fit import Fitted
from tacos_gap.inference.intervals import half_widths
from tacos_gap.inference.presence import BY_PICTURES, BY_STATISTICS, share_explained
from tacos_gap.inference.problem import Hypothesis, Problem, without
from tacos_gap.inference.unknown import Unexplained, doubt_beside
from tacos_gap.statistics.views import view_of

CONFIDENCE = 0.9
"""Probability with which a set of causes is to hold the truth, and an interval its parameter."""

LEAST_CERTAIN = 0.5
"""Probability against rivals up to which pictures are not asked: they could not make the effect likely."""

_LARGEST_PROBABILITY = 0.99

HALF_A_CODE_DN = 0.5
"""How far a level may lie from the code that files round it to: where all ends there, no noise tells."""


def causes_of(
    problem: Problem,
    attribution: Attribution,
    left: Unexplained,
    held_out: HeldOut,
    captures: Sequence[RealCapture],
    effects: Mapping[str, type[Any]],
    seed: int,
) -> list[Cause]:
    """The effects of the best explanation, those with the largest share first."""
    best = attribution.best
    if not best.hypothesis:
        return []
    half_width = half_widths(problem, best, CONFIDENCE)
    closures = closures_of(problem, best, generator(seed, "closure"))
    camera = Photographed.of(captures)
    causes, start = [], 0
    for term in best.hypothesis:
        stop = start + len(term.free)
        probabilities = attribution.probabilities(term.name)
        rivals = sorted(
            (n for n in probabilities if n not in ("", term.name)), key=lambda n: -probabilities[n]
        )
        confused = list(confused_with(term.name, effects, captures))
        alike = tuple(name for name in confused if name not in best.names)
        group = {term.name, *alike}
        certainty = min(sum(probabilities.get(name, 0.0) for name in group), _LARGEST_PROBABILITY)
        rest = problem.residual(without(best.hypothesis, term.name))
        if rest is not None:
            rest = rest / problem.own_units([name for name in best.names if name != term.name])
        share = 0.0 if rest is None else share_explained(problem, best.z, rest)
        near = [name for name in rivals if probabilities[name] > 0.05]
        doubt = left.score if rest is None else max(left.score, doubt_beside(problem, best.z, rest))
        sure = max(BY_STATISTICS.by(share), 1 - doubt)
        if sure < 1 and certainty > LEAST_CERTAIN:
            rivals_of_it = _in_place_of(attribution, term, group)
            in_pictures = share_of_pictures(problem, best.hypothesis, term, rivals_of_it, seed)
            sure = max(sure, BY_PICTURES.by(in_pictures))
        causes.append(
            Cause(
                effect=term.name,
                present=certainty * sure,
                parameters=_parameters(term, half_width[start:stop], camera),
                closure=closures.alone[term.name].value,
                closure_interval=closures.alone[term.name].interval,
                not_held_out=held_out.why_not(term.name),
                shapley=closures.fair[term.name].value,
                confused_with=tuple(dict.fromkeys([*confused, *near])),
                evidence=_evidence(problem, best, term, attribution),
                settings=_settings(term),
                specimen=tuple(n for n in term.settings if of_specimen(term.cls.Config, n)),
                alike=alike,
            )
        )
        start = stop
    # a codec shows in every number and is seldom what one asks about: it comes last
    return sorted(causes, key=lambda cause: (effects[cause.effect].stage == "codec", -cause.shapley))


def _in_place_of(attribution: Attribution, term: HypothesisTerm, group: set[str]) -> list[Hypothesis]:
    """The best explanation with each effect fitted in the place of one of its own, but those of a group."""
    rest = {name for name in attribution.best.names if name != term.name}
    return [
        fitted.hypothesis
        for names, fitted in attribution.fits.items()
        if len(names) == len(rest) + 1 and rest < set(names) and not group & (set(names) - rest)
    ]


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
        unit = unit_of(term.cls.Config, name)
        own = own_values(term.values, name)
        if len(set(own.values())) == 1:  # all captures alike, as a codec's
            found[name] = Parameter(value, None, unit)
        elif own:
            each = {
                capture: _fitted(v, reach.get(of_capture(name, capture)), unit) for capture, v in own.items()
            }
            physical = {
                capture: camera.in_physical_units(term.cls.Config, parameter, name)
                for capture, parameter in each.items()
            }
            middle = short(value) if isinstance(value, float) else value
            found[name] = Parameter(middle, None, unit, by_capture=physical)
        elif name in reach:
            least = HALF_A_CODE_DN if includes_pedestal(term.cls.Config, name) else 0.0
            found[name] = _within(value, max(float(reach[name]), least), unit)
        elif isinstance(value, tuple):
            rows = [[short(v) for v in row] for row in value]
            found[name] = Parameter(rows, None, unit)
        else:
            found[name] = Parameter(value, None, unit)
    return {
        name: camera.in_physical_units(term.cls.Config, parameter, name) for name, parameter in found.items()
    }


def _fitted(value: float, half: float | None, unit: str) -> Parameter:
    """A parameter with its interval; without one where it was not fitted, as a quality that a file states."""
    return Parameter(value, None, unit) if half is None else _within(value, float(half), unit)


def _within(value: float, half: float, unit: str) -> Parameter:
    """A fitted parameter, as fine as half its interval."""
    ends = (as_fine_as(half, value - half), as_fine_as(half, value + half))
    return Parameter(as_fine_as(half, value), ends, unit)


def _settings(term: HypothesisTerm) -> dict[str, Any]:
    plain: dict[str, Any] = {}
    for name, value in term.settings.items():
        if isinstance(value, tuple):
            plain[name] = [[short(v) for v in row] for row in value]
        else:
            plain[name] = short(value) if isinstance(value, float) else value
    return plain


def _evidence(problem: Problem, best: Fitted, term: HypothesisTerm, attribution: Attribution) -> str:
    """The statistic that the effect explains most of, in a sentence."""
    rest = problem.residual(without(best.hypothesis, term.name))
    scores = attribution.slots[term.name]
    rivals = {name: score for name, score in scores.items() if name not in ("", term.name)}
    second = max(rivals, key=lambda name: rivals[name]) if rivals else None
    lead = ""
    if second:
        ahead = scores[term.name] - rivals[second]
        lead = f"; captures held out are {_times(ahead)} likelier with it than with {effect_words(second)}"
    if rest is None:
        return f"The other causes cannot be simulated without it{lead}."
    gain: dict[str, float] = {}
    size: dict[str, tuple[float, float, int]] = {}
    for label, a, b in zip(problem.labels, rest, best.z, strict=True):
        gain[label.statistic] = gain.get(label.statistic, 0.0) + float(a**2 - b**2)
        x, y, n = size.get(label.statistic, (0.0, 0.0, 0))
        size[label.statistic] = (x + float(a) ** 2, y + float(b) ** 2, n + 1)
    top = max(gain, key=lambda name: gain[name])
    x, y, n = size[top]
    without_it, with_it = np.sqrt(x / n), np.sqrt(y / n)
    return (
        f"{view_of(top).title}: {without_it:.1f} times the noise floor without it, "
        f"{with_it:.1f} with it{lead}."
    )


# sets -----------------------------------------------------------------------------------------------------


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
        probabilities = attribution.probabilities(cause.effect)
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
