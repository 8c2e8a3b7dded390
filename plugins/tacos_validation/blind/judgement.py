"""An answer held against what is known of a real camera, which is seldom everything."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tacos_framework import Fault, UserError
from tacos_framework.files import read_json

SURE = 0.5
"""Presence above which an effect counts as named."""

RIGHT, UNKNOWN, WRONG, WRONG_BESIDE, NO_ANSWER = "right", "unknown", "wrong", "wrong beside", "no answer"

_LISTS = ("accept", "also", "confusable", "expect_verdict")


def sureness(cause: Mapping[str, Any]) -> float:
    """Certainty that the effect is there: ``present``, or ``probability`` of older answers."""
    return float(cause.get("present", cause.get("probability", 0.0)))


@dataclass(frozen=True)
class KnownTruth:
    accept: tuple[str, ...]  # effects of which one must come first
    also: tuple[str, ...] = ()  # effects that may stand beside it
    confusable: tuple[str, ...] = ()
    """Effects that may come first where the answer's set holds an accepted one."""
    expect_verdict: tuple[str, ...] = ("explained", "partly_explained")
    """Verdicts that are right; with ``no_gap`` nothing need be named."""
    negligible: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    """By effect and parameter, the amount up to which naming it counts for nothing."""

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> KnownTruth:
        lists = {key: tuple(data[key]) for key in _LISTS if key in data}
        return cls(**lists, negligible=data.get("negligible", {}))

    def as_data(self) -> dict[str, Any]:
        return {**{key: list(getattr(self, key)) for key in _LISTS}, "negligible": dict(self.negligible)}


@dataclass(frozen=True)
class Judgement:
    outcome: str
    """``right``: an accepted effect comes first, and no stranger beside it; or nothing, where no gap was
    expected. ``unknown``: nothing is named with a presence above one half. ``wrong``: something else comes
    first. ``wrong beside``: the first is right, but a stranger stands beside it. ``no answer``: an error, or
    past the time limit."""
    first_right: bool  # true if what comes first is right, whatever stands beside it
    strangers: tuple[str, ...] = ()  # what was named and should not have been

    @property
    def confident_and_wrong(self) -> bool:
        return self.outcome in (WRONG, WRONG_BESIDE)


def judged(known: KnownTruth, answer: Mapping[str, Any]) -> Judgement:
    if "error" in answer:
        return Judgement(NO_ANSWER, False)
    causes = [cause for cause in answer["causes"] if not _negligible(cause, known.negligible)]
    named = [str(cause["effect"]) for cause in causes if sureness(cause) > SURE]
    if not named:
        quiet = "no_gap" in known.expect_verdict and answer["verdict"] == "no_gap"
        return Judgement(RIGHT if quiet else UNKNOWN, quiet)
    strangers = tuple(sorted(set(named) - {*known.accept, *known.also, *known.confusable}))
    in_set = bool(set(answer.get("cause_set", ())) & set(known.accept))
    if named[0] in known.accept or (named[0] in known.confusable and in_set):
        return Judgement(WRONG_BESIDE if strangers else RIGHT, True, strangers)
    return Judgement(WRONG, False, strangers)


def _negligible(cause: Mapping[str, Any], limits: Mapping[str, Mapping[str, float]]) -> bool:
    """True if the first parameter that has a limit stays below it."""
    for name, limit in limits.get(cause["effect"], {}).items():
        for key, parameter in cause.get("parameters", {}).items():
            if key == name or (key.startswith(name) and isinstance(parameter["value"], int | float)):
                return bool(abs(parameter["value"]) <= limit)
    return False


def read_known(folder: Path, effects: Sequence[str]) -> dict[str, KnownTruth]:
    """Known truth of the folders of captures in a folder, by their names.

    Either one ``truth.json`` beside them, a mapping of their names to what is known, or one in each of them.

    Raises UserError with all faults of all files.
    """
    faults: list[Fault] = []
    beside = folder / "truth.json"
    if beside.is_file():
        found = [(name, data, str(beside)) for name, data in _read(beside, faults).items()]
    else:
        files = sorted(folder.glob("*/truth.json"))
        if not files:
            wanted = "one beside the folders of captures, or one in each"
            raise UserError(Fault(str(folder), "there is no truth.json", wanted))
        found = [(file.parent.name, _read(file, faults), str(file)) for file in files]
    known = {}
    for name, data, where in found:
        own = _faults(folder, name, data, where, effects)
        faults += own
        if not own:
            known[name] = KnownTruth.of(data)
    if faults:
        raise UserError(faults)
    return known


def _read(file: Path, faults: list[Fault]) -> dict[str, Any]:
    try:
        data = read_json(file, expected="JSON", remedy="Correct the file.")
    except UserError as error:
        faults.extend(error.faults)
        return {}
    if not isinstance(data, dict):
        faults.append(Fault(str(file), f"it holds {type(data).__name__}", "an object", "Correct the file."))
        return {}
    return data


def _faults(folder: Path, name: str, data: Any, where: str, effects: Sequence[str]) -> list[Fault]:
    if not isinstance(data, dict) or "accept" not in data:
        return [Fault(where, f"{name!r} does not say what to accept", "accept: a list of effects")]
    faults = []
    if not (folder / name / "captures.yaml").is_file():
        faults.append(Fault(where, f"there is no {name}/captures.yaml", "a folder of captures"))
    for key in ("accept", "also", "confusable"):
        if not isinstance(data.get(key, []), list):
            faults.append(Fault(where, f"{key} of {name!r} is {data[key]!r}", "a list of effects"))
            continue
        strange = sorted(set(data.get(key, [])) - set(effects))
        if strange:
            faults.append(Fault(where, f"{key} of {name!r} holds {', '.join(strange)}", "names of effects"))
    return faults
