"""Sentences of the report, made from numbers. Each says what was found and no more than that."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tacos_framework.store import DESIGNED
from tacos_report import verdicts
from tacos_report.comparison import CameraDifference, best_of, difference, score_names
from tacos_report.plain_values import mapping, showable, text
from tacos_report.quantities import (
    duration,
    measured,
    number,
    percent,
    quantity,
    shown,
    signed,
    unit_of,
    words,
)
from tacos_report.study_data import CameraResult, StudyData, Tried
from tacos_report.view_geometry import floor_range_m

_SCHEMES = {
    "quantized": "searched by their properties, then the nearest part (the paper's quantized scheme)",
    "discrete": "searched by their number in the list (the paper's discrete scheme)",
}
_PLACES = {"sensor": 0, "focal_length_mm": 1, "pitch_deg": 3}


@dataclass(frozen=True)
class FailureGroup:
    """Candidates that failed for the same reason, numbers aside; ``example`` is one such sentence."""

    count: int
    example: str


def headline(study: StudyData) -> str:
    if study.designed is None:
        return "No camera was found: not one candidate could be scored."
    if study.analysis.degenerate:
        return "This study names no camera: its scores do not separate them."
    what = f"The best camera found: {design_words(study.designed.camera)}"
    if (decision := study.analysis.decision) is not None:
        title = study.title_of(decision.comparison.against)
        return f"{what}. {verdicts.headline(decision, title, len(study.others))}"
    other = best_of(study.others)
    change = difference(study.designed, other, "fitness") if other else None
    if other is None or change is None:
        return f"{what}."
    if change.outcome == "undecided":
        return f"{what}. On unseen scenes it is not clearly different from the {other.title}."
    others = _count(len(study.others), "off-the-shelf camera")
    best = f"the {other.title}, the best of {others}" if len(study.others) > 1 else f"the {other.title}"
    amount = f"{percent(abs(change.share)).lstrip('+')} " if change.share is not None else ""
    if change.outcome == "worse":
        return f"{what}. On unseen scenes it is {amount}less fit than {best}, and should not replace it."
    return f"{what}. On unseen scenes it is {amount}fitter than {best}."


def design_words(camera: Mapping[str, Any]) -> str:
    """A camera as an engineer would say it: ``the IMX178 sensor behind a 2.9 mm lens, pitched 22° down``."""
    said = {name: _variable_words(name, camera[name]) for name in in_order(camera)}
    if isinstance(camera.get("sensor"), dict) and "focal_length_mm" in said:
        said["sensor"] += f" behind {said.pop('focal_length_mm')}"
    return ", ".join(said.values()) or "one without design variables"


def optics_words(camera: Mapping[str, Any], units: Mapping[str, str]) -> str:
    """Optics and mounting of a camera: ``focal length 2.9 mm, pitch −20°``."""
    return ", ".join(
        f"{words(name).lower()} {shown(name, camera[name], units.get(name) or unit_of(name))}"
        for name in in_order(camera)
        if showable(camera[name])
    )


def in_order(camera: Mapping[str, Any]) -> list[str]:
    """Names of a camera's variables: the sensor first, the mounting last, in whatever order they come."""
    return sorted(camera, key=lambda name: _PLACES.get(name, 2))


def _variable_words(name: str, value: Any) -> str:
    if isinstance(value, dict):
        title, kind = shown(name, value), words(name).lower()
        return f"the {title}" if kind in title.lower().split() else f"the {title} {kind}"
    if name == "focal_length_mm":
        return f"a {shown(name, value)} lens"
    if name == "pitch_deg" and isinstance(value, int | float):
        if abs(value) < 0.05:
            return "mounted level"
        return f"pitched {quantity(abs(value), 'deg')} {'down' if value < 0 else 'up'}"
    if name == "sensor_binning" and value == 1:
        return "no binning"
    said = words(name).lower()
    article = "an" if said[0] in "aeio" or said.startswith("f-") else "a"
    return f"{article} {said} of {shown(name, value)}"


def verdict(study: StudyData) -> str:
    if study.analysis.degenerate:
        return study.analysis.degenerate
    if study.designed is None:
        return _why_none(study)
    if not study.tested:
        best = study.best_fitness
        reached = f" On the scenes it was designed on it reached a fitness of {number(best)}." if best else ""
        return f"{untested(study)}{reached}"
    if study.analysis.decision is not None:
        return verdicts.lead(study.analysis.decision)
    ours = measured(study.designed.fitness or 0.0, study.designed.spread.get("fitness"))
    other = best_of(study.others)
    change = difference(study.designed, other, "fitness") if other else None
    if other is None or change is None:
        return f"Fitness on unseen scenes: {ours}. {_why_alone(study)}"
    theirs = measured(change.other, other.spread.get("fitness"))
    figures = f"Fitness on unseen scenes: {ours} against {theirs}, a difference of "
    figures += signed(change.value, change.error)
    if change.error is None:
        return f"{figures}. Its uncertainty is not known, so a small difference may be chance."
    if change.outcome == "undecided":
        return f"{figures} (95 % interval), which may be chance: more test scenes would be needed to tell."
    return f"{figures} (95 % interval over the test scenes)."


def untested(study: StudyData) -> str:
    if not study.asks_for_test:
        return "It has not been tried on unseen scenes: the recipe has no section test."
    return "It has not been tried on unseen scenes: the study ended before its test."


def _why_none(study: StudyData) -> str:
    groups = failure_groups(study.tried)
    if groups:
        return f"Most often the reason was: {groups[0].example.rstrip('.')}."
    said = text(mapping(study.result.get("failed")).get(DESIGNED))
    return f"The reason: {said.rstrip('.')}." if said else "The log says why."


def _why_alone(study: StudyData) -> str:
    reasons = {each.against: each.why for each in study.analysis.comparisons if each.why}
    if reasons:
        said = "; ".join(f"{study.title_of(name)}: {why.rstrip('.')}" for name, why in reasons.items())
        return f"No camera off the shelf can be compared with it. {said}."
    return study.analysis.decision_absent or "The recipe names no camera to compare it with."


def against_best(study: StudyData) -> str:
    """The best other camera's fitness on unseen scenes: ``Luxonis OAK-D Pro Wide: 1.28 ± 0.03``."""
    other = best_of(study.others)
    if other is None or other.fitness is None:
        return ""
    return f"{other.title}: {measured(other.fitness, other.spread.get('fitness'))}"


def per_score(study: StudyData) -> str:
    """Composition of the difference: each score that the fitness takes; the table has the others."""
    other = best_of(study.others)
    if study.designed is None or other is None:
        return ""
    parts = []
    changes = score_changes(study, other)
    counted = score_weights(study) or changes
    for score in (score for score in changes if score in counted):
        change = changes[score]
        if change.outcome == "undecided" and change.error:
            amount = "no clear difference"
        elif change.value == 0:
            amount = "the same"
        else:
            amount = percent(change.share) if change.share is not None else signed(change.value)
        parts.append(f"{words(score)} {amount}")
    return f"Against the {other.title}, score by score: {'; '.join(parts)}." if parts else ""


def score_changes(study: StudyData, other: CameraResult) -> dict[str, CameraDifference]:
    if study.designed is None:
        return {}
    pairs = (
        (score, difference(study.designed, other, score, higher_is_better=higher_is_better(study, score)))
        for score in score_names([study.designed, other], score_weights(study))
    )
    return {score: change for score, change in pairs if change is not None}


def score_weights(study: StudyData) -> dict[str, float]:
    return {str(row["score"]): float(row["weight"]) for row in study.result.get("fitness") or []}


def higher_is_better(study: StudyData, score: str) -> bool:
    """By the sign of its weight; where the fitness leaves it out, by what its task says."""
    weight = score_weights(study).get(score)
    if weight is not None:
        return weight >= 0
    return score not in (study.result.get("lower_is_better") or ())


def floor_words(camera: CameraResult, eye_height_m: float, ground: str = "floor") -> str:
    """Floor or ground that a camera sees straight ahead of the agent."""
    vfov_deg = camera.derived.get("vfov_deg")
    if vfov_deg is None:
        return "not known"
    seen = floor_range_m(eye_height_m, camera.pitch_deg, vfov_deg)
    if seen is None:
        return f"sees no {ground}"
    near, far = seen
    start = "from the feet on" if near < 0.05 else f"from {quantity(near, 'm', digits=2)}"
    return start if far == float("inf") else f"{start} to {quantity(far, 'm', digits=2)}"


def ground_words(study: StudyData, camera: CameraResult) -> str:
    return floor_words(camera, study.eye_height_m, study.ground)


def search_words(study: StudyData) -> str:
    scored = study.scored
    rounds = len(study.generations)
    if not rounds:
        return "No generation was finished."
    if not scored:
        return f"None of {_count(len(study.tried), 'candidate')} could be scored."
    best = max(scored, key=lambda candidate: candidate.fitness or 0.0)
    place = [generation.number for generation in study.generations].index(best.generation) + 1
    text = f"The highest of {_count(len(scored), 'score')} came in generation {place} of {rounds}"
    if place == rounds and rounds > 1:
        return f"{text}, the last: a longer search may find a better one."
    later = rounds - place
    return f"{text}; {_count(later, 'later generation')} found nothing higher." if later else f"{text}."


def chosen_words(study: StudyData) -> str:
    """Place of the designed camera among the candidates; the highest dot of many noisy ones may be luck."""
    if study.designed is None:
        return ""
    if any(study.shows_design(candidate.camera) for candidate in study.scored):
        return "The star is the designed camera; a higher dot may owe its place to luck."
    return "The designed camera is none of them: the optimizer predicted from them that it is best."


def size_words(study: StudyData) -> str:
    result = study.result
    parts = []
    if isinstance(evaluations := result.get("evaluations"), int):
        parts.append(_count(evaluations, "evaluation"))
    if isinstance(frames := result.get("frames_rendered"), int):
        parts.append(_count(frames, "image") + " rendered")
    if isinstance(seconds := result.get("seconds"), int | float):
        parts.append(duration(float(seconds)))
    return ", ".join(parts)


def failure_groups(tried: Sequence[Tried]) -> list[FailureGroup]:
    """Reasons why candidates failed, the most frequent first; sentences that differ in numbers are one."""
    counts: Counter[str] = Counter()
    examples: dict[str, str] = {}
    for candidate in tried:
        if candidate.failed:
            reason = re.sub(r"[-−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?", "#", candidate.failed)
            counts[reason] += 1
            examples.setdefault(reason, candidate.failed)
    return [FailureGroup(count, examples[reason]) for reason, count in counts.most_common()]


def space_words(row: Mapping[str, Any]) -> str:
    """Choices for a design variable: ``1 mm to 20 mm``, ``43 rows of a catalog, quantized``."""
    unit = row.get("unit") or unit_of(str(row.get("name", "")))
    lower, upper = row.get("lower"), row.get("upper")
    if isinstance(lower, int | float) and isinstance(upper, int | float):
        return f"{quantity(lower, unit)} to {quantity(upper, unit)}"
    values = row.get("values")
    count = values if isinstance(values, int) else len(values) if isinstance(values, list) else None
    choices = _count(count, "choice") if count is not None else str(row.get("kind", ""))
    return f"{choices}, {_SCHEMES.get(str(row['scheme']), row['scheme'])}" if row.get("scheme") else choices


def _count(value: int, noun: str) -> str:
    return f"{number(value, 12)} {noun}{'' if value == 1 else 's'}"
