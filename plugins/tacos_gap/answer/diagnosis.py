"""The whole diagnosis, from captures to causes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from tacos_framework import culprit_of, generator, in_one_thread
from tacos_gap.answer.causes import cause_set_of, causes_of
from tacos_gap.answer.detection_limits import detection_limits
from tacos_gap.answer.findings import LEAST_PRESENT, Cause, Diagnosis, SoFar
from tacos_gap.answer.gathering import gather, processes_for
from tacos_gap.answer.next_capture import best_capture
from tacos_gap.answer.transfer import of_each_capture, of_one_specimen
from tacos_gap.answer.undiagnosed import nothing_measured
from tacos_gap.attribution import Attribution, ForwardSelection, affordable_simulations
from tacos_gap.attribution.held_out import HeldOut, held_out
from tacos_gap.attribution.negative_control import negative_control
from tacos_gap.captures import CaptureFolder, RealCapture
from tacos_gap.captures.coverage import (
    beyond_even_fields,
    beyond_one_time,
    beyond_own_edges,
    beyond_own_levels,
)
from tacos_gap.evidence import PictureEvidence
from tacos_gap.evidence.boards import BoardEvidence, boards_found, hidden_by_pose
from tacos_gap.evidence.elsewhere import of_each, ready
from tacos_gap.hypotheses.candidates import Candidates
from tacos_gap.hypotheses.closed_forms import ClosedForm, closed_forms, excluded, seen_terms
from tacos_gap.hypotheses.kept import KeptTerm, kept_terms
from tacos_gap.hypotheses.parameters import HypothesisTerm
from tacos_gap.inference.closure import Share, closure, resampled_gaps
from tacos_gap.inference.fit import Fitted
from tacos_gap.inference.location import locate
from tacos_gap.inference.problem import Hypothesis, Problem, placed_in
from tacos_gap.inference.unknown import Unexplained, unexplained
from tacos_gap.nuisances import light_beyond_stated
from tacos_gap.statistics.unmeasured import is_cut_off

LEAST_BESIDE_UNKNOWN = 0.1
"""Share of the gap that an effect must remove, or it must be proven, to be named beside something unknown."""

EDGES_ALONE = "Pictures of nothing but edges"
EVEN_FIELDS_ALONE = "Captures of nothing but even fields"
OWN_LEVELS_ALONE = "Expectations of the brightness that the pictures themselves have"
ONE_TIME_ALONE = "Captures of one exposure time, or of none stated,"

_BEYOND = (
    (beyond_own_edges, EDGES_ALONE),
    (beyond_even_fields, EVEN_FIELDS_ALONE),
    (beyond_own_levels, OWN_LEVELS_ALONE),
    (beyond_one_time, ONE_TIME_ALONE),
)
"""Effects that captures cannot show, and in a few words, which captures these are."""

CLOSED_FORMS = "closed-form estimates"

Notify = Callable[[str], None]


@in_one_thread
def diagnose(
    folder: CaptureFolder,
    effects: Mapping[str, type[Any]] | Candidates,
    *,
    seed: int = 0,
    workers: int | None = 1,
    notify: Notify | None = None,
    simulations: int | None = None,
    keep: Callable[[SoFar], None] | None = None,
    begun: Sequence[KeptTerm] = (),
) -> Diagnosis:
    """Find what parts a simulation from a real camera.

    What captures tell by arithmetic alone comes first: effects that are surely there begin the search, and
    those that surely are not are not looked for. An effect that raises is left out, and named in the
    limitations.

    - `workers`: processes, each of which simulates captures of its own; None for one for each core, at most
      four. It is this one alone where effects cannot travel to others.
    - `simulations`: those of all captures after which no further effect is looked for; by default as many as
      take about a minute of two cores.
    - `keep`: given what is known so far, first what arithmetic tells, then each explanation that is found.
    - `begun`: an explanation that an earlier search had come to; this one goes on from there.

    Raises NothingMeasured when no capture can be measured.
    """
    tell = notify or (lambda text: None)
    considered = effects if isinstance(effects, Candidates) else Candidates(effects)
    installed = considered.effects
    for beyond, by in _BEYOND:
        considered = considered.without_these(beyond(folder.captures, considered.effects), by)
    others = processes_for(folder, installed, workers)
    folder = boards_found(folder)
    tell(CLOSED_FORMS)
    told = _told(considered, folder.captures)

    def kept(hypothesis: Hypothesis) -> None:
        if keep is not None:
            keep(SoFar(told, hypothesis, folder.limitations))

    kept(())
    tell("measuring the captures")
    evidence, limitations = gather(folder, seed, ready(others))
    if not any(each.labels for each in evidence) or all(map(is_cut_off, folder.captures)):
        raise nothing_measured(folder, limitations)
    problem = Problem(evidence)
    affordable = simulations or affordable_simulations(evidence)
    while True:
        try:
            looked_for = considered.excluding(excluded(told))
            terms = kept_terms(begun, looked_for) or seen_terms(told, looked_for)
            search = ForwardSelection(problem, looked_for, tell, affordable, terms, kept)
            found = _explained(search, folder.captures, considered.effects, installed, seed, tell)
        except Exception as error:
            culprit = culprit_of(error)
            name = culprit.use.removeprefix("effect.") if culprit else ""
            if name not in installed:
                raise
            considered = considered.without(name, error)
            installed = {other: cls for other, cls in installed.items() if other != name}
            told = tuple(form for form in told if form.effect != name)
            tell(considered.limitations[-1])
        else:
            said = (*folder.limitations, *limitations, *considered.limitations, *found.limitations)
            return replace(found, limitations=said, closed_forms=told)


def _told(considered: Candidates, captures: Sequence[RealCapture]) -> tuple[ClosedForm, ...]:
    """Results of arithmetic; nothing of an effect whose closed form fails, which the search then meets."""
    try:
        return closed_forms(considered.effects, captures)
    except Exception as error:
        if culprit_of(error) is None:
            raise
        return ()


def _explained(
    search: ForwardSelection,
    captures: Sequence[RealCapture],
    effects: Mapping[str, type[Any]],
    installed: Mapping[str, type[Any]],
    seed: int,
    tell: Notify,
) -> Diagnosis:
    tell("trying effects")
    attribution = search.run()
    best, problem = attribution.best, attribution.problem
    left = unexplained(problem, problem.replicate_residuals(best.hypothesis))
    tell("closure of the gap")
    held = held_out(attribution)
    causes = causes_of(problem, attribution, left, held, captures, installed, seed)
    if left.score >= 0.5:  # a little of everything fits what nothing explains
        causes = [c for c in causes if c.shapley >= LEAST_BESIDE_UNKNOWN or c.is_proven]
    gaps = resampled_gaps(problem, np.stack([problem.null, held.left]), generator(seed, "closure"))
    before, after = gaps[:, 0].tolist()
    left = left.beside(after) if causes else left
    closed = Share.of([closure(*each) for each in gaps.T.tolist()])
    places = locate(problem, problem.null)
    if places and not best.hypothesis:  # what survives the false-discovery rate is a gap, however small
        left = replace(left, score=max(left.score, LEAST_PRESENT), where=places[0].statistic)
    cause_set, wanted = cause_set_of(causes, attribution, captures, installed)
    if not causes and left.score < 0.5:
        cause_set, wanted = hidden_by_pose(problem.evidence, effects)
    if wanted is None and (len(cause_set) > max(len(causes), 1) or left.score > 0.5):
        wanted = best_capture(captures, _rival_hypotheses(attribution, cause_set), seed, left.where)
    nuisances = _nuisances(problem, best)
    return Diagnosis(
        verdict=_verdict(causes, before, after, left),
        gap_before=before,
        gap_after=after,
        gap_interval=Share.of(gaps[1].tolist()).interval,
        where=places,
        causes=causes,
        cause_set=cause_set,
        unknown=left,
        next_capture=wanted,
        below_floor=_below_floor(attribution, causes),
        negative_control=negative_control(attribution, closed.value, generator(seed, "negative control")),
        limitations=(
            *(of_one_specimen(cause) for cause in causes if cause.specimen),
            *(text for cause in causes for text in of_each_capture(cause)),
            *light_beyond_stated(captures, nuisances),
            *_cut_short(attribution),
        ),
        problem=problem,
        attribution=attribution,
        closure_interval=closed.interval,
        not_held_out=_not_held_out(held),
        detectable=detection_limits(problem, effects, best.z),
        nuisances=nuisances,
    )


def _not_held_out(held: HeldOut) -> str:
    """Reason why the closure of all is not held out from the selection; empty where it is."""
    if not held.unseen:
        return ""
    return f"half of the captures does not show {', '.join(sorted(held.unseen))}, and could not choose it"


def _cut_short(attribution: Attribution) -> list[str]:
    """Sentences on a search that ended early, and how to have it go on; empty where it did not."""
    if not attribution.cut_short:
        return []
    return [
        f"The search for further effects was ended, much being left unexplained: all captures were simulated "
        f"{attribution.problem.simulations} times. It goes on with a larger `simulations`."
    ]


def _nuisances(problem: Problem, best: Fitted) -> dict[str, dict[str, Any]]:
    each = [e for e in problem.evidence if isinstance(e, (PictureEvidence, BoardEvidence))]
    found = of_each(partial(_nuisances_beside, best.hypothesis), each)
    return {e.capture.id: values for e, values in zip(each, found, strict=True) if values}


def _nuisances_beside(hypothesis: Hypothesis, evidence: PictureEvidence | BoardEvidence) -> dict[str, Any]:
    return evidence.nuisances(placed_in(hypothesis, evidence))


def _verdict(causes: Sequence[Cause], before: float, after: float, left: Unexplained) -> str:
    if not causes:
        return "unknown" if left.score >= 0.5 else "no_gap"
    if left.score < 0.5:
        return "explained"
    proven = any(cause.is_proven for cause in causes)
    return "partly_explained" if proven or closure(before, after) >= 0.5 else "unknown"


def _rival_hypotheses(attribution: Attribution, cause_set: Sequence[str]) -> list[tuple[HypothesisTerm, ...]]:
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
