"""The effects that a camera's simulation lacked: diagnosed, or given."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tacos_framework import Fault, Plugins, Use, UserError, read_yaml
from tacos_framework.files import read_text
from tacos_framework.formation import PlacedEffect
from tacos_gap.answer.diagnosis import Notify, diagnose
from tacos_gap.answer.transfer import Photographed, patched
from tacos_gap.captures import CaptureFolder
from tacos_gap.hypotheses.candidates import Candidates
from tacos_gap.inference.problem import placed
from tacos_plugins.building import part_of


@dataclass(frozen=True, eq=False)
class CameraPatch:
    """Effects added to the simulation of a camera."""

    effects: tuple[PlacedEffect, ...]
    verdict: str  # of the diagnosis; ``given`` where there was none
    text: str
    diagnosis: Mapping[str, Any]  # ``diagnosis.json``; empty where there was none

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(effect.use.removeprefix("effect.") for effect in self.effects)


def diagnosed_patch(
    folder: CaptureFolder, considered: Candidates, seed: int, workers: int | None, notify: Notify
) -> CameraPatch:
    found = diagnose(folder, considered, seed=seed, workers=workers, notify=notify)
    effects = tuple(placed(found.attribution.best.hypothesis))
    text = patched(found.causes, Photographed.of(folder.captures))
    return CameraPatch(effects, found.verdict, text, found.as_data())


def given_patch(path: Path, plugins: Plugins) -> CameraPatch:
    """The effects of a ``patched.yaml``.

    Raises UserError when it is no list of effects, or one of them is not there or has wrong settings.
    """
    document = read_yaml(path)
    listed = document.data.get("effects") if isinstance(document.data, dict) else document.data
    if not isinstance(listed, list) or not all(
        isinstance(entry, dict) and "use" in entry for entry in listed
    ):
        wanted = "a list such as [{use: effect.vignetting, k1: -0.4}]"
        raise UserError(Fault(document.where(()), "no list of effects", wanted))
    parts = [part_of(Use.model_validate(entry), "effect", plugins) for entry in listed]
    effects = tuple(PlacedEffect(part.use, part.use, part.cls, part.config) for part in parts)
    return CameraPatch(effects, "given", read_text(path), {})
