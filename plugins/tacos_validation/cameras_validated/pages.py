"""The report of a validation of cameras."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial

import numpy as np
from numpy.typing import NDArray

from tacos_report.page import (
    Block,
    Detailed,
    Heading,
    Page,
    PagePicture,
    Paragraph,
    Section,
    SideBySide,
    Table,
    image_uri,
    in_both_widths,
)
from tacos_validation.cameras_validated import figures
from tacos_validation.cameras_validated.findings import CamerasFindings
from tacos_validation.cameras_validated.ranking import CameraScores, RankFinding

Samples = Mapping[str, tuple[NDArray[np.uint8], ...]]
"""Of each camera a picture in reality, in its simulation before, and after."""


def title(findings: CamerasFindings) -> str:
    if not findings.scores:
        return "No score of a task could be compared over these cameras"
    first = findings.scores[0]
    found = findings.agreements[first.score]
    alike = {stack: found[stack].tau == 1 for stack in ("sim_before", "sim_after")}
    name = first.score.replace(".", ": ").replace("_", " ")
    if all(alike.values()):
        return f"By {name} the simulator ranks the cameras as reality does, before and after"
    if alike["sim_after"]:
        return f"By {name} the simulator ranks the cameras as reality does once the causes are simulated"
    if alike["sim_before"]:
        return f"By {name} the causes take the simulator away from the ranking of reality"
    return f"By {name} the simulator ranks the cameras otherwise than reality, before and after"


def summary(findings: CamerasFindings) -> str:
    lines = [f"{title(findings)}."]
    for scores in findings.scores:
        found = findings.agreements[scores.score]
        lines.append(
            f"  {scores.score}: rank correlation {shown(found['sim_before'])} before, "
            f"{shown(found['sim_after'])} after; reality with itself {shown(found['real'])}"
        )
    for name, curve in findings.noise.items():
        before, after = curve.off("sim_before"), curve.off("sim_after")
        lines.append(f"  {name}: noise off by {before:.0%} before, {after:.0%} after")
    return "\n".join([*lines, *(f"  {text}" for text in findings.left_out)])


def shown(found: RankFinding) -> str:
    """Kendall's tau with the interval that holds 95 % of the draws."""
    over = found.agreement.tau
    return f"{found.tau:.2f} [{over.low:.2f}, {over.high:.2f}]".replace("-", "\u2212")


def page(findings: CamerasFindings, samples: Samples) -> Page:
    named = ", ".join(findings.patches)
    return Page(
        eyebrow="Validation of real cameras",
        title=title(findings),
        lead=(
            f"{len(findings.patches)} cameras ({named}), each with captures of its own. Tasks are scored on "
            "the real frames, on their simulation as it was, and with the effects it lacked. Rankings are "
            "compared by Kendall's rank correlation; an interval holds 95 % of what other noise and other "
            "scenes like these would give. Reality with itself is what noise allows at best."
        ),
        sections=[
            Section("Frames side by side", tuple(_frames(samples))),
            Section("Does the simulator rank them as reality does", tuple(_rankings(findings))),
            *([Section("Noise against intensity", tuple(_noise(findings)))] if findings.noise else []),
            Section("What was added to each simulation", tuple(_patches(findings))),
            *([Section("What could not be compared", _left_out(findings))] if findings.left_out else []),
        ],
    )


def _frames(samples: Samples) -> Iterator[Block]:
    if not samples:
        yield Paragraph("The cameras share no scene to be shown.")
    for camera, pictures in samples.items():
        yield Heading(camera)
        titles = figures.TITLES.values()
        yield SideBySide(
            tuple(
                PagePicture(image_uri(picture), words, enlarged=True)
                for picture, words in zip(pictures, titles, strict=False)
            )
        )


def _rankings(findings: CamerasFindings) -> Iterator[Block]:
    if not findings.scores:
        yield Paragraph("No task gave a score for every camera.")
        return
    rows = []
    for scores in findings.scores:
        found = findings.agreements[scores.score]
        rows.append(
            (
                Detailed(scores.score, _scenes(scores)),
                *(
                    Detailed(shown(found[stack]), f"one order in {found[stack].agreement.same:.0%} of draws")
                    for stack in ("sim_before", "sim_after", "real")
                ),
            )
        )
    yield Table(("score", "before", "with the causes", "reality with itself"), tuple(rows))
    for scores in findings.scores:
        real, before, after = (", ".join(scores.order(stack)) for stack in figures.TITLES)
        yield in_both_widths(
            partial(figures.levels, scores, findings.seed),
            f"Best first, reality has {real}; the simulator had {before}; with the causes it has {after}.",
        )


def _scenes(scores: CameraScores) -> str:
    count = len(scores.scenes)
    return f"{count} scene{'s' if count > 1 else ''}: {', '.join(scores.scenes[:4])}"


def _noise(findings: CamerasFindings) -> Iterator[Block]:
    yield in_both_widths(
        partial(figures.noise, findings.noise),
        "Variance between frames over signal. Where the dots lie on each other, the simulator has the noise "
        "of the camera.",
    )
    rows = []
    for camera, curve in findings.noise.items():
        slopes = [_slope(curve.slope[stack]) for stack in figures.TITLES]
        off = f"{curve.off('sim_before'):.0%}, then {curve.off('sim_after'):.0%}"
        rows.append((camera, off, *slopes))
    heads = ("camera", "variance off by", "slope, real [DN]", "simulated", "with the causes")
    yield Table(heads, tuple(rows))


def _slope(found: tuple[float, float, float] | None) -> str:
    return "no line" if found is None else f"{found[0]:.3f} [{found[1]:.3f}, {found[2]:.3f}]"


def _patches(findings: CamerasFindings) -> Iterator[Block]:
    rows = [
        (camera, patch.verdict.replace("_", " "), ", ".join(patch.names) or "nothing")
        for camera, patch in findings.patches.items()
    ]
    yield Table(("camera", "diagnosis", "added"), tuple(rows))
    yield Paragraph("Each camera's patched.yaml and diagnosis.json stand in cameras/NAME.")


def _left_out(findings: CamerasFindings) -> tuple[Block, ...]:
    return tuple(Paragraph(text) for text in findings.left_out)
