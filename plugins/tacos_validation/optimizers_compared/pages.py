"""The report of a comparison."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from tacos_framework.report.figures.canvas import draw, light_grid, logarithmic_height
from tacos_framework.report.page import Drawing, Page, Paragraph, Section, Table, Warnings
from tacos_framework.report.palette import MUTED, camera_colour
from tacos_validation.optimizers_compared.contest import Run
from tacos_validation.optimizers_compared.standings import Middle, Standing, curve

POINTS = 120
"""Points of a curve."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """Everything the report tells.

    Parameters
    ----------
    target
        Median fitness of the reference.
    target_images
        Images that the reference's candidates come to when elites are rendered again, as in the paper.
    target_rendered
        Images they come to when no candidate is rendered twice.
    """

    problem: str
    reference: str
    images_per_evaluation: int
    images: int
    target: float
    target_images: float
    target_rendered: float
    best_known: float
    worst_known: float
    groups: Mapping[tuple[str, str], Sequence[Run]]
    standings: tuple[Standing, ...]
    notes: tuple[str, ...]

    def as_data(self) -> dict[str, Any]:
        """For ``result.json``; what was never reached is null."""
        return {
            "problem": self.problem,
            "reference": self.reference,
            "images_per_evaluation": self.images_per_evaluation,
            "images": self.images,
            "target": self.target,
            "target_images": self.target_images,
            "target_rendered": self.target_rendered,
            "best_known": self.best_known,
            "worst_known": self.worst_known,
            "standings": [_finite(asdict(each)) for each in self.standings],
            "comparison_notes": list(self.notes),
        }


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _finite(each) for key, each in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value


def summary(comparison: Comparison) -> str:
    """The finding in a few lines."""
    lines = [_finding(comparison)]
    for each in _ranked(comparison):
        lines.append(
            f"{each.optimizer} ({each.scheme}): regret {_interval(each.regret, 3)}, target after "
            f"{_images(each.images)} images, reached by {each.success:.0%}"
        )
    return "\n".join(lines)


def page(comparison: Comparison) -> Page:
    """The page."""
    runs = max(each.runs for each in comparison.standings)
    return Page(
        eyebrow="Optimizers compared",
        title=_finding(comparison),
        lead=(
            f"{len(comparison.standings)} searches of the problem {comparison.problem}, {runs} seeds each, "
            f"{comparison.images} images for every run, {comparison.images_per_evaluation} for a candidate. "
            f"Regret is the distance to the best fitness any run found, {comparison.best_known:.3f}; random "
            f"candidates reach down to {comparison.worst_known:.3f}. Lines are medians over seeds, bands "
            f"their 95 % intervals (order statistics, no assumption on the distribution)."
        ),
        sections=(
            Section("Notes", (Warnings("What to know", comparison.notes),))
            if comparison.notes
            else _target(comparison),
            *((_target(comparison),) if comparison.notes else ()),
            Section("Regret against images", tuple(_drawings(comparison, "images"))),
            Section("Regret against seconds", tuple(_drawings(comparison, "seconds"))),
            Section("Standings", (_table(comparison),)),
        ),
    )


def _target(comparison: Comparison) -> Section:
    return Section(
        "What is to be reached",
        (
            Paragraph(
                f"The target is the median quality of {comparison.reference}: fitness "
                f"{comparison.target:.3f}, a regret of {comparison.best_known - comparison.target:.3f}. The "
                f"paper renders every candidate of every generation, which comes to "
                f"{comparison.target_images:.0f} images; a tenth of that are "
                f"{comparison.target_images / 10:.0f}. Here no run renders a candidate twice, so it took "
                f"{comparison.target_rendered:.0f}. Images and seconds are counted as if each run were alone."
            ),
        ),
    )


def _finding(comparison: Comparison) -> str:
    reached = [each for each in _ranked(comparison) if math.isfinite(each.images.median)]
    others = [each for each in reached if f"{each.optimizer}, {each.scheme}" not in comparison.reference]
    if not others:
        return f"No other search reaches the quality of {comparison.reference} in {comparison.images} images"
    best = others[0]
    share = best.images.median / comparison.target_images
    return (
        f"{best.optimizer} ({best.scheme}) reaches the quality of {comparison.reference} with {share:.0%} of "
        f"its images: {best.images.median:.0f} of {comparison.target_images:.0f}"
    )


def _ranked(comparison: Comparison) -> list[Standing]:
    """Fewest images to the target first; those that do not reach it by their regret."""
    return sorted(comparison.standings, key=lambda each: (each.images.median, each.regret.median))


def _drawings(comparison: Comparison, unit: str) -> list[Drawing]:
    schemes = dict.fromkeys(scheme for _, scheme in comparison.groups)
    return [_drawing(comparison, scheme, unit) for scheme in schemes]


def _drawing(comparison: Comparison, scheme: str, unit: str) -> Drawing:
    groups = {name: runs for (name, of), runs in comparison.groups.items() if of == scheme}
    names = list(dict.fromkeys(name for name, _ in comparison.groups))
    most = max(
        (getattr(r.moments[-1], unit) for runs in groups.values() for r in runs if r.moments), default=1
    )
    floor = max(comparison.best_known - comparison.worst_known, 1e-12) * 1e-3

    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        for name, runs in groups.items():
            at = np.linspace(most / POINTS, most, POINTS)
            drawn = curve(
                runs,
                at,
                lambda moment: float(getattr(moment, unit)),
                best_known=comparison.best_known,
                worst_known=comparison.worst_known,
            )
            colour = camera_colour(names.index(name))
            axes.fill_between(
                at, np.maximum(drawn.low, floor), np.maximum(drawn.high, floor), color=colour, alpha=0.12,
                linewidth=0,
            )  # fmt: skip
            axes.plot(at, np.maximum(drawn.median, floor), color=colour, linewidth=2, label=name)
        goal = comparison.best_known - comparison.target
        axes.axhline(max(goal, floor), color=MUTED, linewidth=1, linestyle="--")
        if unit == "images":
            axes.axvline(comparison.target_images / 10, color=MUTED, linewidth=1, linestyle=":")
        logarithmic_height(axes)
        axes.set_xlim(0, most)
        axes.set_xlabel("images rendered" if unit == "images" else "seconds, optimizer included")
        axes.set_ylabel("regret")
        axes.set_title(f"{scheme} catalogs")
        light_grid(axes, "y")
        axes.legend(ncols=3, labelcolor=MUTED)

    described = f"Median regret of {', '.join(groups)} against {unit}, {scheme} catalogs."
    caption = "Dashed: the target." + (
        " Dotted: a tenth of the reference's images." if unit == "images" else ""
    )
    return Drawing(draw(f"{scheme}-{unit}", (9.2, 4.2), described, paint), caption)


def _table(comparison: Comparison) -> Table:
    heads = (
        "Optimizer", "Scheme", "Final fitness", "Final regret", "Images to the target",
        "Seconds to the target", "Reached", "Reached with a tenth", "On unseen scenes",
        "Thought per candidate",
    )  # fmt: skip
    rows = tuple(
        (
            each.optimizer,
            each.scheme,
            _interval(each.final, 3),
            _interval(each.regret, 3),
            _images(each.images),
            _interval(each.seconds, 0),
            f"{each.success:.0%}",
            f"{each.success_early:.0%}",
            "not tested" if each.unseen is None else f"{each.unseen:.3f}",
            f"{each.thought_ms:.1f} ms",
        )
        for each in _ranked(comparison)
    )
    caption = (
        "Medians over seeds, 95 % intervals in brackets. A tenth: with a tenth of the reference's images. "
        "On unseen scenes: mean fitness of the winners there."
    )
    return Table(heads, rows, caption)


def _images(found: Middle) -> str:
    return _interval(found, 0)


def _interval(found: Middle, digits: int) -> str:
    return f"{_shown(found.median, digits)} [{_shown(found.low, digits)}, {_shown(found.high, digits)}]"


def _shown(value: float, digits: int) -> str:
    return "never" if math.isinf(value) else f"{value:.{digits}f}"
