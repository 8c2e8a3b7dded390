"""Effect of a better simulation on the choice of a camera, in a verdict and a sentence."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from tacos_framework.study import PairedInterval
from tacos_gap.tasks.decision.ranked import RankedCameras

Verdict = Literal["stays", "changes", "undecided"]


@dataclass(frozen=True)
class Choice:
    """The camera one would take before and after."""

    before: str  # the best camera in the simulation as it was
    after: str  # the best one with the causes
    verdict: Verdict
    """``stays`` where no camera beats the first in the better simulation, or only by less than matters;
    ``changes`` where one does; ``undecided`` where the scenes do not tell."""
    decided_by: PairedInterval | None = None
    """The first camera less the one that decides, in the better simulation; None where none was compared."""

    def as_data(self) -> dict[str, Any]:
        found = self.decided_by
        compared = {} if found is None else {
            "difference": -found.difference,
            "ci": found.interval and [-found.interval[1], -found.interval[0]],
            "episodes": found.episodes,
        }  # fmt: skip
        return {"before": self.before, "after": self.after, "verdict": self.verdict, **compared}


def choice(before: RankedCameras, after: RankedCameras) -> Choice:
    """The camera to take, before and after."""
    first = before.order[0]
    best = after.order[0]
    beaten_by = [name for name, found in after.comparisons.items() if found.verdict == "worse"]
    if beaten_by:
        best = max(beaten_by, key=lambda name: -after.comparisons[name].difference)
        return Choice(first, best, "changes", after.comparisons[best])
    open_ones = [name for name, found in after.comparisons.items() if found.verdict == "undecided"]
    if after.reference != first or open_ones or (best != first and best not in after.comparisons):
        found = after.comparisons.get(best) or (after.comparisons[open_ones[0]] if open_ones else None)
        return Choice(first, best, "stays" if best == first and not open_ones else "undecided", found)
    nearest = min(after.comparisons.values(), key=lambda each: each.difference, default=None)
    return Choice(first, first, "stays", after.comparisons.get(best) or nearest)


def sentence(before: RankedCameras, after: RankedCameras, found: Choice, confidence: float) -> str:
    first, second = before.order, after.order
    if first == second:
        text = f"The ranking of the cameras stays: {', '.join(second)}."
    else:
        text = f"The ranking of the cameras changes, from {', '.join(first)} to {', '.join(second)}."
    compared = found.decided_by
    if compared is None or compared.interval is None:
        few = f"{after.episodes} scenes are too few to exclude chance: raise test.most_episodes"
        return f"{text} {few}." if len(first) > 1 else text
    low, high = -compared.interval[1], -compared.interval[0]
    sure = f"{confidence:.0%} interval {low:+.3g} to {high:+.3g}, {compared.episodes} unseen scenes"
    sure = sure.replace("%", " %").replace("-", "\u2212")
    match found.verdict:
        case "changes":
            ahead = f"by {-compared.difference:.3g} of fitness ({sure})"
            return f"{text} The camera to take changes: {found.after} beats {found.before} {ahead}."
        case "stays":
            if found.before != second[0]:
                rest = f"{second[0]} is ahead by no more than matters ({sure})"
            elif compared.verdict == "equivalent":
                rest = f"the next is equal to it within what matters ({sure})"
            else:
                rest = f"the next is {compared.difference:.3g} of fitness behind ({sure})"
            return f"{text} The camera to take stays: {found.before}; {rest}."
        case _:
            return (
                f"{text} These scenes do not decide if another camera should replace {found.before} "
                f"({sure}): set test.most_episodes higher."
            )
