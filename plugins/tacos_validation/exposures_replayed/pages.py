"""The report of replayed exposures."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from matplotlib.figure import Figure

from tacos_report.figures.canvas import NARROW_IN, draw, light_grid
from tacos_report.page import Block, Page, Paragraph, Section, Table, in_both_widths
from tacos_validation.exposures_replayed.findings import ReplayedExposure, SourceFindings

_LEAD = (
    "Each exposure of the recording was replayed from each other one, with the motion, noise and coding "
    "that the recording itself shows, and scored as the real frames are."
)


def page(sources: Mapping[str, SourceFindings], notes: tuple[str, ...]) -> Page:
    sections = [
        Section("What was measured", tuple(Paragraph(note) for note in notes)),
        *(Section(f"From {name} ms", _blocks(name, found)) for name, found in sources.items()),
    ]
    return Page("Replay of a recording", "Exposures, replayed and real", _LEAD, sections)


def summary(sources: Mapping[str, SourceFindings]) -> str:
    lines = []
    for name, found in sources.items():
        refused = len(found.exposures) - len(found.answered)
        measured = [each for each in found.answered if each.near is not None]
        near = sum(bool(each.near) for each in measured)
        tau = "no order" if found.tau is None else f"tau {found.tau:.2f}"
        held = f"{tau}, {near} of {len(measured)} within 15 % or ten inliers" if measured else "not measured"
        lines.append(f"from {name} ms: {held}, {refused} refused")
    return "\n".join(lines)


def _blocks(name: str, found: SourceFindings) -> tuple[Block, ...]:
    table = Table(
        ("exposure [ms]", "real", "replayed", "interval", "refused"),
        tuple(_row(each) for each in found.exposures),
        "Mean inliers of consecutive frames.",
    )
    if len(found.answered) < 2:
        return (Paragraph("Fewer than two exposures can be answered, so there is no order."), table)
    text = f"Replayed order: {_order(found, lambda each: each.predicted)} ms."
    if found.tau is not None:
        text += f" Real order: {_order(found, lambda each: each.real)} ms. Kendall's tau {found.tau:.2f}."

    def drawing(*, narrow: bool = False) -> str:
        return _levels(name, found, narrow=narrow)

    return Paragraph(text), in_both_widths(drawing, "Inliers over the exposure."), table


def _order(found: SourceFindings, of: Callable[[ReplayedExposure], float | None]) -> str:
    ordered = sorted(found.answered, key=lambda each: of(each) or 0.0, reverse=True)
    return ", ".join(f"{each.ms:g}" for each in ordered)


def _row(each: ReplayedExposure) -> tuple[str, ...]:
    predicted = "" if each.predicted is None else f"{each.predicted:.0f}"
    interval = "" if each.interval is None else f"{each.interval[0]:.0f} to {each.interval[1]:.0f}"
    real = "" if each.real is None else f"{each.real:.0f}"
    return f"{each.ms:g}", real, predicted, interval, each.refused or ""


def _levels(name: str, found: SourceFindings, *, narrow: bool) -> str:
    def paint(figure: Figure) -> None:
        axes = figure.add_subplot()
        if real := [(e.ms, e.real) for e in found.exposures if e.real is not None]:
            axes.plot(*zip(*real, strict=True), "o-", label="real")
        for each in found.answered:
            axes.vlines(each.ms, *(each.interval or (0.0, 0.0)), color="C1")
        axes.plot(
            [e.ms for e in found.answered],
            [e.predicted or 0.0 for e in found.answered],
            "s",
            color="C1",
            label="replayed",
        )
        axes.set_xscale("log", base=2)
        axes.set_xticks([e.ms for e in found.exposures], [f"{e.ms:g}" for e in found.exposures])
        axes.set(xlabel="exposure [ms]", ylabel="inliers")
        axes.legend()
        light_grid(axes, "y")

    size = (NARROW_IN, 3.0) if narrow else (7.0, 3.2)
    drawn = f"levels-{name.replace('.', '-')}{'-narrow' if narrow else ''}"
    return draw(drawn, size, f"Inliers over the exposure, real and replayed from {name} ms.", paint)
