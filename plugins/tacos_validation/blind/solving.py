"""Work of the workers: diagnose a case blind, and later measure its answer on fresh captures."""

from __future__ import annotations

import time
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.answer.gathering import gather
from tacos_gap.captures import read_captures
from tacos_gap.hypotheses.parameters import HypothesisTerm
from tacos_gap.inference.problem import Problem
from tacos_validation.blind.baselines import simpler_answers
from tacos_validation.blind.limits import TimeIsUp, time_limit

Effects = Mapping[str, type[Any]]


@dataclass(frozen=True)
class Diagnosing:
    case: str
    folder: Path
    removed: tuple[str, ...] = ()  # effects that the catalogue lacks this time
    baselines: bool = True  # whether simpler ways are tried as well
    processes: int = 1

    def work(self, effects: Effects) -> dict[str, Any]:
        known = {name: cls for name, cls in effects.items() if name not in self.removed}
        began = time.monotonic()
        folder = read_captures(self.folder)
        found = diagnose(folder, known, seed=0, workers=self.processes)
        seconds = time.monotonic() - began
        pixels = sum(c.real_dn[..., 0].size for c in folder.captures)
        simpler = simpler_answers(found, known) if self.baselines else {}
        return {
            **found.as_data(),
            "patch": found.effects,
            "seconds": round(seconds, 2),
            "captures": len(folder.captures),
            "pixels": int(pixels),
            "baselines": simpler,
        }


@dataclass(frozen=True)
class FreshGaps:
    """See how an answer fares on captures that were kept back, and how the truth would."""

    case: str
    folder: Path
    found: Sequence[Mapping[str, Any]]  # the answer's effects with their settings
    truth: Sequence[Mapping[str, Any]]
    """What was withheld; empty where the catalogue has no parameters for it."""

    def work(self, effects: Effects) -> dict[str, Any]:
        """Gaps before, with what was found, and with the truth [noise floor]."""
        evidence, _ = gather(read_captures(self.folder), seed=1)
        problem = Problem(evidence)
        gaps: dict[str, Any] = {"before": problem.gap(problem.null)}
        for name, added in (("found", self.found), ("truth", self.truth)):
            terms = tuple(_term(each, effects) for each in added)
            z = problem.residual(terms)
            gaps[name] = None if z is None or (name == "truth" and not terms) else problem.gap(z)
        return gaps


def _term(described: Mapping[str, Any], effects: Effects) -> HypothesisTerm:
    values = {key: value for key, value in described.items() if key != "use"}
    name = str(described["use"]).removeprefix("effect.")
    return HypothesisTerm(name, effects[name], values, {})


@dataclass(frozen=True)
class Worker:
    """Does jobs with the catalogue of effects; an error is an answer too, and a wrong one."""

    effects: Effects
    limit_s: float | None = None
    """Longest processor time for a job; past it there is no answer. None for any [s]."""

    def __call__(self, job: Diagnosing | FreshGaps) -> dict[str, Any]:
        try:
            with time_limit(self.limit_s):
                return job.work(self.effects)
        except TimeIsUp:
            return {"error": f"no answer within {self.limit_s:g} s of processor time"}
        except Exception as error:  # noqa: BLE001 - whatever it is, the case is reported with it
            last = traceback.extract_tb(error.__traceback__)[-1]
            return {"error": f"{type(error).__name__}: {error} ({Path(last.filename).name}:{last.lineno})"}

    def lost(self, job: Diagnosing | FreshGaps, reason: str) -> dict[str, Any]:
        return {"error": reason}
