"""What parts a simulation from a real camera: where, why, and what closes the gap."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from tacos_framework.errors import Fault, UserError
from tacos_framework.gap.captures import read_captures
from tacos_framework.gap.diagnosis import Diagnosis, diagnose
from tacos_framework.plugins import Plugins
from tacos_framework.progress import Progress
from tacos_framework.settings import Settings, setting

NOT_CAUSES = ("auto-exposure",)
"""Effects that are a camera's control loop rather than a flaw of a capture."""


class Diagnose:
    """Compares real captures with what a simulator expects, and names the effects it leaves out.

    Writes ``diagnosis.json`` (what was found), ``patched.yaml`` (the causes, as effects to add to a recipe by
    ``--with``) and ``report.html``.
    """

    class Config(Settings):
        """Settings of the diagnosis."""

        captures: str = setting("captures", help="Folder of captures.", min_length=1, is_path=True)
        without: tuple[str, ...] = setting((), help="Effects that are not to be considered, by name.")
        workers: int = setting(2, help="Threads.", ge=1)

    def __init__(self, config: Config) -> None:
        self.config = config

    def run(self, *, out: Path, seed: int, plugins: Plugins, progress: Progress) -> Mapping[str, Any]:
        """Diagnose, and write what was found."""
        effects = candidate_effects(plugins, self.config.without)
        progress.phase("Diagnosing", None)
        folder = read_captures(self.config.captures)
        diagnosis = diagnose(folder, effects, seed=seed, workers=self.config.workers, notify=progress.step)
        data = diagnosis.as_data()
        (out / "diagnosis.json").write_text(json.dumps(data, indent=1, ensure_ascii=False) + "\n", "utf-8")
        (out / "patched.yaml").write_text(_patched(diagnosis), "utf-8")
        return {"diagnosis": data, "summary": summary(diagnosis)}


def candidate_effects(plugins: Plugins, without: tuple[str, ...] = ()) -> dict[str, type[Any]]:
    """Every installed effect that can be a cause, by name.

    Raises
    ------
    UserError
        When an effect of `without` is not installed.
    """
    names = {
        r.component.name
        for r in plugins
        if r.component.kind == "effect" and not r.component.missing_packages()
    }
    if unknown := [name for name in without if name not in names]:
        raise UserError(
            Fault("without", f"no effect is called {', '.join(unknown)}", ", ".join(sorted(names)))
        )
    chosen = sorted(names - set(without) - set(NOT_CAUSES))
    return {name: plugins.resolve(f"effect.{name}") for name in chosen}


def _patched(diagnosis: Diagnosis) -> str:
    head = "# Effects that close the gap; add them to a recipe: tacos-run RECIPE --with patched.yaml\n"
    return head + yaml.safe_dump(diagnosis.patch, sort_keys=False, default_flow_style=None)


def summary(diagnosis: Diagnosis) -> str:
    """What was found, in a few lines."""
    said = {
        "no_gap": "No gap: the captures differ from the simulation by no more than its own noise.",
        "explained": "Explained.",
        "partly_explained": "Partly explained: something outside the catalogue of effects remains.",
        "unknown": "Unknown: the cause lies outside the catalogue of effects.",
    }
    lines = [said[diagnosis.verdict]]
    for cause in diagnosis.causes:
        values = ", ".join(
            f"{name} {p.value}{'' if p.unit == '1' else f' {p.unit}'}" for name, p in cause.parameters.items()
        )
        lines.append(f"  {cause.effect} ({cause.probability:.0%}): {values}")
        lines.append(f"      closes {cause.closure:.0%} of the gap on what it was not fitted to")
    more = [name for name in diagnosis.cause_set if name not in {c.effect for c in diagnosis.causes}]
    if more:
        lines.append(f"  cannot be told from: {', '.join(more)}")
    lines.append(f"Gap: {diagnosis.gap_before:.1f} before, {diagnosis.gap_after:.1f} after, floor 1.")
    if diagnosis.next_capture:
        lines.append(f"Capture next: {diagnosis.next_capture.kind}; {diagnosis.next_capture.why}.")
    return "\n".join(lines)
