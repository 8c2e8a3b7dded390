"""From differences seed by seed to the verdict on a claim."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from tacos_validation.claims.settings import Claim, study_and_camera
from tacos_validation.studies_compared.pairs import spread
from tacos_validation.studies_table.findings import StudyRun, look_up

HOLDS, DOES_NOT, UNDECIDED = "holds", "does not hold", "undecided"
IMAGES = "images"


@dataclass(frozen=True)
class Contrast:
    """The figure of a claim's study less that of another one, over the seeds that have both.

    Of images it is the base-2 logarithm of their ratio.
    """

    over: str
    mean: float
    low: float
    high: float
    seeds: int
    verdict: str


@dataclass(frozen=True)
class ClaimFound:
    """The verdict on a claim under one scoring; a rival without a figure in two seeds has no contrast."""

    claim: str
    says: str
    scoring: str
    verdict: str
    contrasts: tuple[Contrast, ...]


def judged(
    name: str, claim: Claim, scoring: str, runs: Mapping[str, Mapping[int, StudyRun]], confidence: float
) -> ClaimFound:
    """The verdict on a claim: it holds if it does over each of its rivals.

    `runs`: by study and seed; studies that were left out are missing.
    """
    contrasts = []
    for over in claim.over:
        by = _differences(claim, over, runs)
        if len(by) > 1:
            contrasts.append(contrast(over, by, claim, confidence))
    verdicts = {each.verdict for each in contrasts}
    if DOES_NOT in verdicts:
        verdict = DOES_NOT
    else:
        verdict = HOLDS if verdicts == {HOLDS} and len(contrasts) == len(claim.over) else UNDECIDED
    return ClaimFound(name, claim.says, scoring, verdict, tuple(contrasts))


def contrast(over: str, differences: Sequence[float], claim: Claim, confidence: float) -> Contrast:
    """Mean of two or more differences, with its interval by Student's t.

    A claim of equality holds if the interval lies within the margin (two one-sided tests at half the
    remaining probability, so stricter than the customary 90 % interval).
    """
    from scipy.stats import t

    found = spread(differences)
    half = float(t.ppf((1 + confidence) / 2, found.seeds - 1)) * (found.standard_error or 0.0)
    low, high = found.mean - half, found.mean + half
    return Contrast(over, found.mean, low, high, found.seeds, _verdict(low, high, claim))


def _verdict(low: float, high: float, claim: Claim) -> str:
    if (margin := claim.equal_within) is not None:
        if -margin < low and high < margin:
            return HOLDS
        return DOES_NOT if low > margin or high < -margin else UNDECIDED
    if claim.better == "lower":
        low, high = -high, -low
    if low > 0:
        return HOLDS
    return DOES_NOT if high < 0 else UNDECIDED


def _differences(claim: Claim, over: str, runs: Mapping[str, Mapping[int, StudyRun]]) -> list[float]:
    (of_study, of_camera), (over_study, over_camera) = study_and_camera(claim.of), study_and_camera(over)
    own, others = runs.get(of_study, {}), runs.get(over_study, {})
    found = []
    for seed in own.keys() & others.keys():
        if claim.value == IMAGES:
            if own[seed].curve[1] and others[seed].curve[1]:  # else a search scored no camera
                found.append(_image_ratio_log2(own[seed], others[seed]))
            continue
        one = look_up(own[seed].result, of_camera, claim.value)
        other = look_up(others[seed].result, over_camera, claim.value)
        if isinstance(one, (int, float)) and isinstance(other, (int, float)):
            found.append(one - other)
    return found


def _image_ratio_log2(one: StudyRun, other: StudyRun) -> float:
    """Ratio of the images two searches render until each is as good as the worse of them ends [log2]."""
    level = min(one.curve[1][-1], other.curve[1][-1])

    def images(run: StudyRun) -> int:
        return next(spent for spent, best in zip(*run.curve, strict=True) if best >= level)

    return math.log2(images(one) / images(other))
