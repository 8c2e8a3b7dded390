"""Every hook a plugin may implement, on one screen.

A hook that raises stops nobody: the plugin is listed as broken, or switched off where it observes a study.
Those that observe are given copies, which are theirs to keep and to change; an analysis is given a record
that it must not change.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pluggy

from tacos_framework.components import Command, Component, ReferencePage
from tacos_framework.environment import EnvironmentFinding, Gpu

hookspec = pluggy.HookspecMarker("tacos")
hookimpl = pluggy.HookimplMarker("tacos")


@hookspec
def tacos_components() -> Sequence[Component]:  # type: ignore[empty-body]
    """Offer components. Called once at discovery: name code by string, import nothing heavy."""


@hookspec
def tacos_doctor() -> Sequence[EnvironmentFinding]:  # type: ignore[empty-body]
    """Look at what the plugin's components need on this machine; for ``tacos doctor`` and for results."""


@hookspec
def tacos_gpus() -> Sequence[Gpu]:  # type: ignore[empty-body]
    """Say which GPUs components may use; asked only where ``--device`` names one, which then must exist."""


@hookspec
def tacos_commands() -> Sequence[Command]:  # type: ignore[empty-body]
    """Offer commands of ``tacos``. Called whenever it starts: import nothing heavy.

    A name that two plugins offer is left out, as is one that ``tacos`` has itself.
    """


@hookspec
def tacos_reference_pages() -> Sequence[ReferencePage]:  # type: ignore[empty-body]
    """Offer pages of the reference that follow from the plugin's code; for ``make docs``."""


@hookspec
def tacos_episode_stores() -> Sequence[Any]:  # type: ignore[empty-body]
    """Offer to keep the episodes that scenes make (`tacos_framework.contracts.EpisodeStore`); one is used."""


@hookspec
def tacos_study_started(recipe: Any, out: Any) -> None:
    """A study begins, or goes on: its `Recipe` and its results folder (`pathlib.Path`)."""


@hookspec
def tacos_generation_finished(generation: int, evaluated: Sequence[Any], best: Any) -> None:
    """A generation was evaluated: number from 0, its `Evaluation`s, and the best so far (or None)."""


@hookspec
def tacos_candidate_failed(candidate: Any, reason: str) -> None:
    """A candidate could not be evaluated, and why: a constraint, a component that refuses it, a defect."""


@hookspec
def tacos_analyse_study(record: Any) -> Mapping[str, Any] | None:
    """A study is over, all but its result: keys to add to ``result.json``, as plain data.

    `record` is a `tacos_framework.study.record.StudyRecord`, shared with the other plugins. Keys that
    ``result.json`` has itself, or another plugin has given, are refused. An analysis that raises is left out
    with a note, and the study ends as it would have.
    """


@hookspec
def tacos_study_finished(result: Mapping[str, Any]) -> None:
    """A study ended; `result` is what stands in ``result.json``."""


@hookspec
def tacos_report(folder: Path) -> Path | None:
    """Write a report of a results folder into it, and return the file; None where it is not for you.

    Called once a study has ended, and by ``tacos report``. What it raises is shown, and costs no result.
    """
