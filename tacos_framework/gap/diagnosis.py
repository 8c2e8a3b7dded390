"""The whole diagnosis, from captures to causes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tacos_framework.gap.ambiguity import NextCapture, confused_with
from tacos_framework.gap.attribution import Attribution, Search
from tacos_framework.gap.boards import BoardEvidence, find_corners
from tacos_framework.gap.captures import Capture, CaptureFolder
from tacos_framework.gap.captures.sharp_edges import with_sharp_edges
from tacos_framework.gap.closure import bootstrap_interval, closure, shapley
from tacos_framework.gap.evidence import Evidence, ImageEvidence
from tacos_framework.gap.fit import Fitted
from tacos_framework.gap.locate import Place, locate
from tacos_framework.gap.next_capture import best_capture
from tacos_framework.gap.parameters import Term, unit_of
from tacos_framework.gap.problem import Problem, bent
from tacos_framework.gap.unknown import Unexplained, block_index, unexplained
from tacos_framework.randomness import generator

CONFIDENCE = 0.9
"""Probability a set of causes is to hold the truth with."""

_LARGEST_PROBABILITY = 0.99
_Z90 = 1.645
ENOUGH_PIXELS = 500_000
"""Repeated frames beyond so many pixels in all tell little that others do not, and cost as much."""

LEAST_BESIDE_UNKNOWN = 0.1
"""Share of the gap that an effect must remove to be named where something unknown is at work."""

_NO_GAP = 1.5
"""Gap up to which captures and simulator count as equal, whatever its significance [floor]."""

Notify = Callable[[str], None]


@dataclass(frozen=True)
class Parameter:
    """A fitted parameter with its 90 % interval; `interval` is None for one that was chosen, not fitted."""

    value: Any
    interval: tuple[float, float] | None
    unit: str


@dataclass(frozen=True)
class Cause:
    """An effect that the captures support."""

    effect: str
    probability: float
    parameters: Mapping[str, Parameter]
    closure: float
    closure_interval: tuple[float, float]
    closure_alone: float
    shapley: float
    confused_with: tuple[str, ...]
    evidence: str
    settings: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What was found; `as_data` gives ``diagnosis.json``.

    `problem` and `attribution` hold all numbers behind it, for the report.
    """

    verdict: str
    gap_before: float
    gap_after: float
    gap_interval: tuple[float, float]
    where: Sequence[Place]
    causes: Sequence[Cause]
    cause_set: tuple[str, ...]
    unknown: Unexplained
    next_capture: NextCapture | None
    below_floor: tuple[str, ...]
    placebo: tuple[str, float] | None
    limitations: tuple[str, ...]
    problem: Problem
    attribution: Attribution
    task: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    def as_data(self) -> dict[str, Any]:
        """``diagnosis.json`` as plain data."""
        return {
            "verdict": self.verdict,
            "gap": {
                "before": _round(self.gap_before),
                "after": _round(self.gap_after),
                "floor": 1.0,
                "unit": "floor",
                "ci": [_round(end) for end in self.gap_interval],
            },
            "where": [
                {
                    "stage": place.stage,
                    "statistic": place.statistic,
                    "z": _round(place.z),
                    "share": _round(place.share),
                    "at": place.at,
                    "captures": list(place.captures),
                }
                for place in self.where
            ],
            "causes": [_cause_as_data(cause) for cause in self.causes],
            "cause_set": list(self.cause_set),
            "unknown": {"probability": self.unknown.probability, "where": self.unknown.where},
            "next_capture": self.next_capture
            and {"kind": self.next_capture.kind, "why": self.next_capture.why},
            "below_floor": list(self.below_floor),
            "placebo": self.placebo and {"effect": self.placebo[0], "closure": _round(self.placebo[1])},
            "task": {name: dict(values) for name, values in self.task.items()},
            "limitations": list(self.limitations),
        }

    @property
    def closure(self) -> float:
        """Share of the gap that all causes together remove, held out."""
        return closure(self.gap_before, self.gap_after)

    @property
    def patch(self) -> list[dict[str, Any]]:
        """The causes as effects of a recipe."""
        return [{"use": f"effect.{cause.effect}", **cause.settings} for cause in self.causes]


def _cause_as_data(cause: Cause) -> dict[str, Any]:
    return {
        "effect": cause.effect,
        "probability": _round(cause.probability),
        "parameters": {
            name: {
                "value": parameter.value,
                **({"ci": [_short(end) for end in parameter.interval]} if parameter.interval else {}),
                "unit": parameter.unit,
            }
            for name, parameter in cause.parameters.items()
        },
        "closure": {
            "value": _round(cause.closure),
            "ci": [_round(end) for end in cause.closure_interval],
            "held_out": True,
        },
        "closure_if_added_alone": _round(cause.closure_alone),
        "shapley": _round(cause.shapley),
        "confused_with": list(cause.confused_with),
        "evidence": cause.evidence,
    }


def _round(value: float) -> float:
    return round(float(value), 3)


def _short(value: float) -> float:
    """Five significant digits."""
    return float(f"{value:.5g}")


def diagnose(
    folder: CaptureFolder,
    effects: Mapping[str, type[Any]],
    *,
    seed: int = 0,
    workers: int = 2,
    notify: Notify | None = None,
) -> Diagnosis:
    """Find what parts a simulation from a real camera.

    Parameters
    ----------
    folder
        The captures.
    effects
        Candidate causes: name (without ``effect.``) and class.
    seed
        Seeds the simulations.
    workers
        Threads.
    notify
        Told what is being done.
    """
    tell = notify or (lambda text: None)
    tell("measuring the captures")
    evidence, limitations = gather(folder, seed, workers)
    problem = Problem(evidence)
    tell("trying effects")
    attribution = Search(problem, effects, workers, tell).run()
    best, problem = attribution.best, attribution.problem
    left = unexplained(problem, problem.judged(best.hypothesis))
    tell("how far the gap shrinks")
    causes = _causes(problem, attribution, left, folder.captures, seed)
    if left.probability >= 0.5:  # a little of everything fits what nothing explains
        causes = [cause for cause in causes if cause.shapley >= LEAST_BESIDE_UNKNOWN]
    before, after = problem.gap(problem.null), problem.gap(best.held_out)
    cause_set, wanted = _cause_set(causes, attribution, folder.captures)
    if wanted is None and (len(cause_set) > max(len(causes), 1) or left.probability > 0.5):
        wanted = best_capture(folder.captures, _rival_hypotheses(attribution, cause_set), seed)
    return Diagnosis(
        verdict=_verdict(causes, before, after, left),
        gap_before=before,
        gap_after=after,
        gap_interval=_gap_interval(problem, best, seed),
        where=locate(problem, problem.null),
        causes=causes,
        cause_set=cause_set,
        unknown=left,
        next_capture=wanted,
        below_floor=_below_floor(attribution, causes),
        placebo=_placebo(problem, attribution),
        limitations=(*folder.limitations, *limitations),
        problem=problem,
        attribution=attribution,
    )


def gather(folder: CaptureFolder, seed: int, workers: int = 1) -> tuple[list[Evidence], list[str]]:
    """Evidence of every capture that bears on anything, and why others do not."""
    with ThreadPoolExecutor(workers) as pool:
        found = list(pool.map(lambda capture: _evidence_of(capture, seed), folder.captures))
    evidence = [each for each in found if not isinstance(each, str)]
    return evidence, [text for text in found if isinstance(text, str) and text]


def _evidence_of(capture: Capture, seed: int) -> Evidence | str:
    """The evidence of a capture, or in a sentence why there is none; empty where that was said on reading."""
    if capture.kind == "board":
        corners = find_corners(capture)
        if corners is None:
            return f"{capture.id}: the board's corners were not found; it is left out."
        return BoardEvidence(capture, corners, seed)
    if capture.expected_dn is None:
        capture = with_sharp_edges(capture)
    if not capture.valid.any():
        return ""
    return ImageEvidence(capture.of_at_most(ENOUGH_PIXELS), seed)


def _verdict(causes: Sequence[Cause], before: float, after: float, left: Unexplained) -> str:
    if not causes:
        return "unknown" if left.probability >= 0.5 else "no_gap"
    if left.probability < 0.5:
        return "explained"
    return "partly_explained" if closure(before, after) >= 0.5 else "unknown"


# causes ---------------------------------------------------------------------------------------------------


def _causes(
    problem: Problem, attribution: Attribution, left: Unexplained, captures: Sequence[Capture], seed: int
) -> list[Cause]:
    best = attribution.best
    if not best.hypothesis:
        return []
    before = problem.gap(problem.null)
    groups = block_index(problem)
    spread = best.spread(problem)
    values = _subset_closures(problem, best, before)
    shares = shapley(best.names, lambda names: values[names])
    interval = bootstrap_interval(
        bent(problem.null) ** 2,
        bent(best.held_out) ** 2,
        problem.floor_size,
        groups,
        generator(seed, "closure"),
    )
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
        alike = [name for name, _ in confused_with(term.name, captures)]
        certainty = min(probabilities[term.name], _LARGEST_PROBABILITY)
        if alike:
            certainty = min(certainty, 1.0 / (1 + len(alike)))
        near = [name for name in rivals if probabilities[name] > 0.05]
        causes.append(
            Cause(
                effect=term.name,
                probability=certainty * (1 - left.probability),
                parameters=_parameters(term, spread[start:stop]),
                closure=values[best.names] if len(best.names) == 1 else own,
                closure_interval=interval,
                closure_alone=alone,
                shapley=shares[term.name],
                confused_with=tuple(dict.fromkeys([*alike, *near])),
                evidence=_evidence(problem, best, term, rest, attribution),
                settings=_settings(term),
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


def _parameters(term: Term, spread: Any) -> dict[str, Parameter]:
    found: dict[str, Parameter] = {}
    settings = term.settings
    errors = dict(zip(term.free, spread, strict=True))
    for name, value in settings.items():
        if name in errors:
            width = _Z90 * float(errors[name])
            interval = (float(value) - width, float(value) + width)
            found[name] = Parameter(_short(value), interval, unit_of(term.cls, name))
        elif name == "matrix":
            rows = [[_short(v) for v in row] for row in value]
            found[name] = Parameter(rows, None, unit_of(term.cls, name))
        else:
            found[name] = Parameter(value, None, unit_of(term.cls, name))
    return found


def _settings(term: Term) -> dict[str, Any]:
    """Settings for a recipe, in plain numbers."""
    plain: dict[str, Any] = {}
    for name, value in term.settings.items():
        if isinstance(value, tuple):
            plain[name] = [[_short(v) for v in row] for row in value]
        else:
            plain[name] = _short(value) if isinstance(value, float) else value
    return plain


def _evidence(
    problem: Problem, best: Fitted, term: Term, rest: tuple[str, ...], attribution: Attribution
) -> str:
    """The statistic that the effect explains most of, in a sentence."""
    without = problem.residual(tuple(t for t in best.hypothesis if t.name != term.name))
    scores = attribution.slots[term.name]
    rivals = {name: score for name, score in scores.items() if name not in ("", term.name)}
    second = max(rivals, key=lambda name: rivals[name]) if rivals else None
    lead = f"; held out it beats {second} by {scores[term.name] - rivals[second]:.0f} nat" if second else ""
    if without is None:
        return f"The captures ask for it{lead}."
    gain: dict[str, float] = {}
    size: dict[str, tuple[float, float, int]] = {}
    for label, a, b in zip(problem.labels, without, best.z, strict=True):
        gain[label.statistic] = gain.get(label.statistic, 0.0) + float(
            bent(np.array(a)) ** 2 - bent(np.array(b)) ** 2
        )
        x, y, n = size.get(label.statistic, (0.0, 0.0, 0))
        size[label.statistic] = (x + float(a) ** 2, y + float(b) ** 2, n + 1)
    top = max(gain, key=lambda name: gain[name])
    x, y, n = size[top]
    name = top.replace("_", " ").capitalize()
    without_it, with_it = np.sqrt(x / n), np.sqrt(y / n)
    return (
        f"{name} differs by {without_it:.1f} times the floor without it and by {with_it:.1f} with it{lead}."
    )


# sets -----------------------------------------------------------------------------------------------------


def slot_probabilities(scores: Mapping[str, float]) -> dict[str, float]:
    """Probability of each effect in one place of the explanation, from log scores on held-out conditions."""
    names = list(scores)
    values = np.array([scores[name] for name in names])
    weights = np.exp(np.clip(values - values.max(), -700, 0))
    return dict(zip(names, (weights / weights.sum()).tolist(), strict=True))


def _cause_set(
    causes: Sequence[Cause], attribution: Attribution, captures: Sequence[Capture]
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
        for other, capture in confused_with(cause.effect, captures):
            wanted = wanted or capture
            if other not in chosen:
                chosen.append(other)
    return tuple(chosen), wanted


def _rival_hypotheses(attribution: Attribution, cause_set: Sequence[str]) -> list[tuple[Term, ...]]:
    """The best explanation, and those with another member of the set in it."""
    best = attribution.best.hypothesis
    rivals = [best]
    for names, fitted in attribution.fits.items():
        differs = set(names) - {term.name for term in best}
        if len(names) == len(best) and len(differs) == 1 and differs <= set(cause_set):
            rivals.append(fitted.hypothesis)
    return rivals


def _below_floor(attribution: Attribution, causes: Sequence[Cause]) -> tuple[str, ...]:
    """Effects that fit a little better than nothing, but gain too little to be believed."""
    found = {cause.effect for cause in causes}
    base = attribution.best.score
    small = []
    for names, fitted in attribution.fits.items():
        added = set(names) - found
        if found <= set(names) and len(added) == 1 and fitted.score - base > 1.0:
            small += sorted(added)
    return tuple(dict.fromkeys(small))


def _placebo(problem: Problem, attribution: Attribution) -> tuple[str, float] | None:
    """The closure of a wrong effect as flexible as the best cause: what flexibility alone would buy."""
    if not attribution.best.hypothesis:
        return None
    first = attribution.best.hypothesis[0]
    before = problem.gap(problem.null)
    members = set(attribution.best.names)
    singles = [f for names, f in attribution.fits.items() if len(names) == 1 and not members & set(names)]
    singles = [f for f in singles if f.hypothesis[0].cls.stage != first.cls.stage]
    if not singles:
        return None
    alike = min(singles, key=lambda f: abs(len(f.hypothesis[0].free) - len(first.free)))
    return alike.names[0], closure(before, problem.gap(alike.held_out))


def _gap_interval(problem: Problem, best: Fitted, seed: int) -> tuple[float, float]:
    """90 % interval of the gap that is left, over resampled statistics."""
    groups = block_index(problem)
    if not len(groups):
        return 0.0, 0.0
    rng = generator(seed, "gap interval")
    count = int(groups.max()) + 1
    sums = np.bincount(groups, bent(best.held_out) ** 2, count)
    sizes = np.bincount(groups, minlength=count)
    drawn = rng.integers(count, size=(200, count))
    gaps = np.sqrt(sums[drawn].sum(axis=1) / sizes[drawn].sum(axis=1)) / problem.floor_size
    low, high = np.percentile(gaps, (5, 95))
    return float(low), float(high)
