"""The report of a pre-training."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from matplotlib.figure import Figure

from tacos_report.figures.canvas import NARROW_IN, draw, light_grid
from tacos_report.page import Code, Drawing, Page, Paragraph, Section, Table, in_both_widths
from tacos_report.palette import camera_colour


@dataclass(frozen=True, eq=False)
class PretrainingOutcome:
    node: str
    use: str
    file: str
    size_bytes: int
    images: int
    held_out: int
    """Images trained on and scored on."""
    epochs: tuple[Mapping[str, Any], ...]
    """Losses, scores and seconds of each pass over the images."""
    made_by: Mapping[str, str]
    """The header of the file."""

    @property
    def scores(self) -> Mapping[str, float]:
        """On held-out worlds, after the last pass."""
        scores: Mapping[str, float] = self.epochs[-1]["scores"]
        return scores

    @property
    def training_seconds(self) -> float:
        return sum(float(line["seconds"]) for line in self.epochs)

    def as_data(self) -> dict[str, Any]:
        return {
            "trained": self.use,
            "weights": self.file,
            "weights_bytes": self.size_bytes,
            "images": self.images,
            "held_out": self.held_out,
            "epochs": len(self.epochs),
            "training_seconds": round(self.training_seconds, 1),
            "losses": dict(self.epochs[-1]["losses"]),
            "scores": dict(self.scores),
        }


def summary(outcome: PretrainingOutcome) -> str:
    return (
        f"{_finding(outcome)}\n"
        f"Weights: {outcome.file} ({outcome.size_bytes / 1e6:.1f} MB), for `weights` of {outcome.use}."
    )


def page(outcome: PretrainingOutcome) -> Page:
    rows = tuple((name, f"{value:.3f}") for name, value in outcome.scores.items())
    return Page(
        eyebrow="Pre-training",
        title=_finding(outcome),
        lead=(
            f"{outcome.images} images of procedural worlds, each camera drawn from the design space, "
            f"{len(outcome.epochs)} passes over them in {outcome.training_seconds / 60:.0f} min. Scores are "
            f"of {outcome.held_out} images of other worlds, by other cameras."
        ),
        sections=(
            Section("Course", _drawings(outcome.epochs)),
            Section("Scores on held-out worlds", (Table(("Score", "Value"), rows),)),
            Section(
                "The weights",
                (
                    Paragraph(f"Name the file in a recipe, under the node of {outcome.use}:"),
                    Code(f"{outcome.node}: {{use: {outcome.use}, weights: {outcome.file}, ...}}"),
                    Table(("Header", "Value"), tuple(outcome.made_by.items())),
                ),
            ),
        ),
    )


def _finding(outcome: PretrainingOutcome) -> str:
    scores = list(outcome.scores.items())
    found = (
        f"{scores[0][0]} {scores[0][1]:.3f} on held-out worlds" if scores else "No score on held-out worlds"
    )
    return f"{found} after {len(outcome.epochs)} passes over {outcome.images} images"


def _drawings(epochs: Sequence[Mapping[str, Any]]) -> tuple[Drawing, ...]:
    losses = {name: [line["losses"][name] for line in epochs] for name in epochs[0]["losses"]}
    scored = [line for line in epochs if line["scores"]]
    first = next(iter(scored[-1]["scores"]), None) if scored else None
    drawings = []
    if losses:
        passes = [line["epoch"] for line in epochs]
        caption = "Losses while training."
        drawn = partial(_curves, "losses", passes, losses, "mean loss of a pass", caption)
        drawings.append(in_both_widths(drawn, caption))
    if first is not None:
        values = {first: [line["scores"].get(first, 0.0) for line in scored]}
        passes = [line["epoch"] for line in scored]
        caption = "On held-out worlds."
        drawings.append(in_both_widths(partial(_curves, "scores", passes, values, first, caption), caption))
    return tuple(drawings)


def _curves(
    name: str,
    passes: Sequence[int],
    curves: Mapping[str, Sequence[float]],
    label: str,
    caption: str,
    *,
    narrow: bool = False,
) -> str:
    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        for i, (of, values) in enumerate(curves.items()):
            axes.plot(passes, values, color=camera_colour(i), linewidth=2, marker="o", markersize=4, label=of)
        axes.set_ylim(bottom=0)
        axes.set_xlabel("passes over the images")
        axes.set_ylabel(label)
        light_grid(axes, "y")
        if len(curves) > 1:
            axes.legend(ncols=1 if narrow else 3)

    last = ", ".join(f"{of} {values[-1]:.3f}" for of, values in curves.items())
    described = f"{caption} At the end: {last}."
    if narrow:
        return draw(f"{name}-narrow", (NARROW_IN, 3.0), described, paint)
    return draw(name, (9.2, 3.6), described, paint)
