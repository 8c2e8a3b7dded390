"""The numbers of a diagnosis, statistic by statistic: real, simulated before, simulated after."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tacos_gap.answer.findings import Diagnosis
from tacos_gap.captures import RealCapture
from tacos_gap.evidence import Label, PictureEvidence
from tacos_gap.evidence.boards import BoardEvidence
from tacos_gap.inference.problem import Problem


@dataclass(frozen=True, eq=False)
class Numbers:
    """All numbers of a statistic, over the captures it was taken in."""

    statistic: str
    stage: str  # of image formation that it shows most often
    labels: Sequence[Label]
    z_before: NDArray[np.float64]  # (K,) real less simulated [noise floor]
    z_after: NDArray[np.float64]  # (K,)
    sigma: NDArray[np.float64]  # (K,) one noise-floor unit, in the statistic's unit
    real: NDArray[np.float64]
    """(K,) of the real frames, in the statistic's unit; NaN where only differences are known."""
    gap_before: float  # root mean square of the differences [noise floor]
    gap_after: float

    @property
    def before(self) -> NDArray[np.float64]:
        """(K,) of the simulation as it was."""
        return self.real - self.z_before * self.sigma

    @property
    def after(self) -> NDArray[np.float64]:
        """(K,) of the simulation with the effects."""
        return self.real - self.z_after * self.sigma

    def chosen(self, keep: NDArray[np.bool_]) -> Numbers:
        return Numbers(
            self.statistic,
            self.stage,
            [label for label, kept in zip(self.labels, keep, strict=True) if kept],
            self.z_before[keep],
            self.z_after[keep],
            self.sigma[keep],
            self.real[keep],
            self.gap_before,
            self.gap_after,
        )


def numbers_of(
    problem: Problem, before: NDArray[np.float64], after: NDArray[np.float64]
) -> dict[str, Numbers]:
    """The numbers of every statistic, for two hypotheses given by their residuals [noise floor]."""
    real, sigma = _measured(problem)
    captures = {e.capture.id: e.capture for e in problem.evidence if isinstance(e, PictureEvidence)}
    members: dict[str, list[int]] = {}
    for k, label in enumerate(problem.labels):
        members.setdefault(label.statistic, []).append(k)
    found = {}
    for statistic, indices in members.items():
        part = np.zeros(len(problem.labels), bool)
        part[indices] = True
        found[statistic] = Numbers(
            statistic,
            problem.labels[indices[0]].stage,
            [_at_mean_level(problem.labels[k], captures) for k in indices],
            before[part],
            after[part],
            sigma[part],
            real[part],
            problem.gap(before, part),
            problem.gap(after, part),
        )
    return found


def _at_mean_level(label: Label, captures: Mapping[str, RealCapture]) -> Label:
    """A label with the mean level in place of an interval, whose ends bright and dark squares fill."""
    span = label.at.get("level_dn")
    capture = captures.get(label.capture)
    if not isinstance(span, list) or capture is None or capture.expected_dn is None:
        return label
    channel = "RGB".find(str(label.at.get("channel", "R")))
    level = capture.expected_dn.mean(axis=0)[..., max(channel, 0)][capture.valid]
    inside = level[(level >= span[0]) & (level <= span[1])]
    mean = float(inside.mean()) if inside.size else float(np.mean(span))
    return replace(label, at={**label.at, "level_dn": round(mean, 1)})


def capture_gaps(diagnosis: Diagnosis) -> dict[str, tuple[float, float]]:
    """Gap of each capture, before and after [noise floor]."""
    problem = diagnosis.problem
    names = np.array([label.capture for label in problem.labels])
    return {
        str(name): (
            problem.gap(problem.null, names == name),
            problem.gap(diagnosis.attribution.best.held_out, names == name),
        )
        for name in dict.fromkeys(names.tolist())
    }


def _measured(problem: Problem) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    real = np.full(len(problem.labels), np.nan)
    sigma = np.ones(len(problem.labels))
    for evidence, slot in zip(problem.evidence, problem.slots, strict=True):
        if isinstance(evidence, PictureEvidence):
            real[slot.start : slot.stop] = evidence.real
            sigma[slot.start : slot.stop] = evidence.sigma
        elif isinstance(evidence, BoardEvidence):
            sigma[slot.start : slot.stop] = evidence.sigma_px
    return real, sigma * problem.scale
