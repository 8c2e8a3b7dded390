"""The report where nothing could be measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from tacos_gap.answer.undiagnosed import WANTED
from tacos_gap.captures import CaptureFolder
from tacos_gap.report.photographed import effects_not_shown, photographed
from tacos_gap.report.words import gathered
from tacos_report.page import Code, Page, Paragraph, Section


def undiagnosed_page(
    folder: CaptureFolder, limitations: Sequence[str], effects: Mapping[str, type[Any]], command: str
) -> Page:
    wanted = f"Capture next: {WANTED.kind}. {WANTED.why[:1].upper()}{WANTED.why[1:]}."
    return Page(
        "Diagnosis of the gap between captures and their simulation",
        "Nothing could be measured in these captures",
        "So nothing is said of the gap: neither that there is one, nor that there is none.",
        [
            Section("Captures", tuple(photographed(folder.captures))),
            Section("Why nothing can be diagnosed", tuple(map(Paragraph, gathered(limitations)))),
            Section("Captures to take", (Paragraph(wanted), *effects_not_shown(folder.captures, effects))),
            Section("To repeat it", (Code(command),)),
        ],
    )


def undiagnosed_summary(limitations: Sequence[str]) -> str:
    said = [f"  {text}" for text in gathered(limitations)]
    lines = ["Unknown: nothing could be measured in any capture.", *said]
    return "\n".join([*lines, f"Capture next: {WANTED.kind}; {WANTED.why}."])
