"""A study's answer at a point, held against the industry's: both are about the camera that is best."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from tacos_decision.pool import Pool
from tacos_framework import Constraint, quantity
from tacos_framework.plan import Plan
from tacos_framework.study import broken_by
from tacos_validation.known_answers.industry import IndustryAnswer

PLACES = 2048
"""Cameras of a design space of which the share in a class is counted."""


@dataclass(frozen=True)
class PointHeld:
    """A point of a job: what the industry has, and what the study says."""

    job: str
    point: str
    industry: str
    study: str | float | None
    """The word, or median, of the best camera over draws of the study's posterior; None without one."""
    probability: float | None
    """Share of those draws whose best camera is of the industry's class; None where the study has no
    answer."""
    chance: float  # share of the cameras the study could choose that are of that class
    agrees: bool  # whether that probability is at least one half
    why: str | None = None  # why the study has no answer, in a sentence

    def as_data(self) -> dict[str, Any]:
        return {name: value for name, value in asdict(self).items() if name != "why" or value is not None}


def held(job: str, answer: IndustryAnswer, result: Mapping[str, Any], plan: Plan) -> PointHeld:
    """One point of a job.

    - `result`: what the study found, as `result.json` has it.
    """
    chance = share_in_class(plan, answer.within)
    optimal = result.get("equivalent", {}).get("optimal", ())
    if not optimal:
        why = result.get("decision_absent") or result.get("ranking_absent") or "the study ranks no camera"
        return PointHeld(job, answer.point, answer.said, None, None, chance, False, str(why))
    name = answer.within.quantity
    rows = {row["camera"][part]["name"]: row["camera"][part] for part, row in _parts(result)}
    found = [
        (quantity(name, _with_columns(each["camera"], rows), each["derived"]), each["probability"])
        for each in optimal
    ]
    total = sum(share for _, share in found)
    inside = sum(share for value, share in found if answer.within.breach(value) is None) / total
    return PointHeld(
        job, answer.point, answer.said, middle(found), round(inside, 3), round(chance, 3), inside >= 0.5
    )


def middle(found: Sequence[tuple[float | str | None, float]]) -> str | float | None:
    """The median of numbers with their weights, or the word of most weight; None where none is known."""
    known = [(value, weight) for value, weight in found if value is not None]
    numbers = sorted((float(value), weight) for value, weight in known if not isinstance(value, str))
    if numbers:
        cumulated = np.cumsum([weight for _, weight in numbers])
        return float(f"{numbers[int(np.searchsorted(cumulated, cumulated[-1] / 2))][0]:.3g}")
    weights: dict[str, float] = defaultdict(float)
    for value, weight in known:
        weights[str(value)] += weight
    return max(weights, key=lambda word: weights[word]) if weights else None


def share_in_class(plan: Plan, within: Constraint) -> float:
    """Share of a design space's cameras that keep a bound beside all others, parts and places alike."""
    pool = Pool(plan.space)
    parts = list(pool.parts)
    places = pool.spread(max(1, PLACES // len(parts)))
    cameras = [pool.camera(own, place) for own in parts for place in places]
    kept = [camera for camera in cameras if not broken_by(plan, camera)]
    inside = [
        within.breach(quantity(within.quantity, camera, plan.derived(camera))) is None for camera in kept
    ]
    return float(np.mean(inside)) if inside else 0.0


def _parts(result: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Each line of the ranking with each of its parts' variables."""
    for row in result["ranking"]:
        for name, value in row["camera"].items():
            if isinstance(value, Mapping):
                yield name, row


def _with_columns(camera: Mapping[str, Any], rows: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    return {
        name: rows.get(value, value) if isinstance(value, str) else value for name, value in camera.items()
    }
