"""Real cameras, ranked by a simulator and by reality."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import JsonValue

from tacos_framework import Plugins, Progress, Settings, setting
from tacos_framework.camera import display_image
from tacos_framework.formation import EpisodeDraws, PlacedEffect
from tacos_gap.captures import CaptureFolder, RealCapture
from tacos_gap.hypotheses.candidates import Candidates, candidates
from tacos_gap.procedures.checks import check_all, check_captures
from tacos_gap.procedures.progress import Telling
from tacos_gap.simulation.formation import simulate
from tacos_gap.tasks import CaptureScores, RecipeTask, default_tasks, score_tasks, tasks_of
from tacos_gap.tasks.recipe_tasks import frozen_plan
from tacos_validation.cameras_validated.camera_folders import PATCH, camera_folders, read_cameras
from tacos_validation.cameras_validated.findings import CamerasFindings
from tacos_validation.cameras_validated.noise_curves import NoiseCurve, noise_curve
from tacos_validation.cameras_validated.pages import page, summary
from tacos_validation.cameras_validated.patches import CameraPatch, diagnosed_patch, given_patch
from tacos_validation.cameras_validated.ranking import CameraScores, camera_scores
from tacos_validation.harness import leave

SHOWN = ("scene", "edge", "chart", "sequence", "flat")
"""Kinds to show a frame of, the richest first."""


class ValidateCameras:
    """Asks whether a simulator ranks real cameras as reality does, before and after what it lacked was added.

    Each camera has a folder of captures, of kinds that a diagnosis can use and of scenes that tasks can be
    scored on; captures of one id are of one scene. Every camera is diagnosed, or its ``patched.yaml`` taken,
    and every task of a recipe scored on its real frames, on their simulation as it was, and with the causes.
    Leaves ``report.html``, and for each camera ``cameras/NAME/diagnosis.json`` and ``patched.yaml``.

    Source: The paper, Sec. 4.1: noise against intensity, and ORB inliers of three cameras, real and
    simulated.
    """

    class Config(Settings):
        captures: str = setting(
            "captures", help="Folder with a folder of captures for each camera.", min_length=1, is_path=True
        )
        patches: Literal["diagnose", "given"] = setting(
            "diagnose",
            help="Source of the effects that a simulation lacks: a diagnosis of each camera, or the "
            "patched.yaml in each folder.",
        )
        study: str = setting(
            "", help="A recipe (path or name) whose tasks are scored; by default ORB features.", is_path=True
        )
        change: dict[str, JsonValue] = setting({}, help="Keys of that recipe to change, as with --set.")
        without: tuple[str, ...] = setting((), help="Effects that are not to be considered, by name.")
        workers: int | None = setting(
            None, help="Processes that simulate captures; by default one for each core, at most 4.", ge=1
        )

    def __init__(self, config: Config) -> None:
        self.config = config

    def check(self, *, plugins: Plugins) -> None:
        check_all(
            partial(self._check_folders, plugins),
            lambda: self._tasks(plugins),
            lambda: candidates(plugins, self.config.without),
        )

    def run(self, *, out: Path, seed: int, plugins: Plugins, progress: Progress) -> Mapping[str, Any]:
        tasks = self._tasks(plugins)
        considered = candidates(plugins, self.config.without)
        progress.phase("Reading captures", None)
        folders = self._folders()
        cameras = read_cameras(folders, plugins)
        patches = {
            name: self._patch(name, folder, folders[name], considered, plugins, seed, progress)
            for name, folder in cameras.items()
        }
        for name, patch in patches.items():
            _keep(out / "cameras" / name, patch)
        progress.phase("Scoring tasks", len(cameras))
        scored: dict[str, tuple[CaptureScores, ...]] = {}
        noise: dict[str, NoiseCurve] = {}
        left_out: list[str] = []
        for name, folder in cameras.items():
            effects = patches[name].effects
            found = score_tasks(folder.captures, partial(_in_any, effects), tasks, seed)
            scored[name] = found.captures
            left_out += [f"{name}: {text}" for text in found.left_out]
            if (curve := noise_curve(folder.captures, effects, seed)) is not None:
                noise[name] = curve
            progress.step(name)
        scores, not_shared = _compared(scored, tasks)
        findings = CamerasFindings(patches, scores, noise, (*left_out, *not_shared), seed)
        shown = page(findings, _samples(cameras, patches, seed))
        return leave(out, shown, findings.as_data(), summary(findings))

    def _folders(self) -> dict[str, Path]:
        return camera_folders(self.config.captures, patched=self.config.patches == "given")

    def _check_folders(self, plugins: Plugins) -> None:
        folders = self._folders().values()
        given = folders if self.config.patches == "given" else ()
        check_all(
            *(partial(check_captures, str(path), plugins) for path in folders),
            *(partial(given_patch, path / PATCH, plugins) for path in given),
        )

    def _tasks(self, plugins: Plugins) -> tuple[RecipeTask, ...]:
        if not self.config.study:
            return default_tasks(plugins)
        return tasks_of(frozen_plan(self.config.study, self.config.change, plugins))

    def _patch(
        self,
        name: str,
        folder: CaptureFolder,
        path: Path,
        considered: Candidates,
        plugins: Plugins,
        seed: int,
        progress: Progress,
    ) -> CameraPatch:
        if self.config.patches == "given":
            return given_patch(path / PATCH, plugins)
        progress.phase(f"Diagnosing {name}", None)
        with Telling(progress) as tell:
            return diagnosed_patch(folder, considered, seed, self.config.workers, tell)


def _keep(folder: Path, patch: CameraPatch) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / PATCH).write_text(patch.text, "utf-8")
    if patch.diagnosis:
        text = json.dumps(patch.diagnosis, indent=1, ensure_ascii=False)
        (folder / "diagnosis.json").write_text(f"{text}\n", "utf-8")


def _compared(
    scored: Mapping[str, tuple[CaptureScores, ...]], tasks: tuple[RecipeTask, ...]
) -> tuple[tuple[CameraScores, ...], list[str]]:
    """Scores that all cameras have, those a fitness counts first; and a sentence for each of the others."""
    names = list(dict.fromkeys(n for each in scored.values() for c in each for s in c.real for n in s))
    by_node = {task.node: task for task in tasks}
    found, left_out = [], []
    for name in sorted(names, key=lambda n: n.partition(".")[2] not in by_node[n.partition(".")[0]].counted):
        node, _, score = name.partition(".")
        scores = camera_scores(name, scored, lower_is_better=by_node[node].lower_is_better(score))
        if scores is None:
            left_out.append(f"{name}: not every camera has it.")
        else:
            found.append(scores)
    return tuple(found), left_out


def _samples(
    cameras: Mapping[str, CaptureFolder], patches: Mapping[str, CameraPatch], seed: int
) -> dict[str, tuple[NDArray[np.uint8], ...]]:
    samples = {}
    for name, folder in cameras.items():
        shown = [c for c in folder.captures if c.kind in SHOWN and c.expected_dn is not None]
        if shown:
            capture = min(shown, key=lambda c: SHOWN.index(c.kind))
            samples[name] = _pictures(capture, patches[name], seed)
    return samples


def _in_any(effects: Sequence[PlacedEffect], capture: RealCapture) -> Sequence[PlacedEffect]:
    del capture
    return effects


def _pictures(capture: RealCapture, patch: CameraPatch, seed: int) -> tuple[NDArray[np.uint8], ...]:
    draws = EpisodeDraws(seed, ("sample", capture.id))
    context = capture.context
    frames = [
        capture.real_dn[0],
        *(simulate(capture, effects, draws, frames=1)[0] for effects in ((), patch.effects)),
    ]
    shown = [display_image(frame, context.black_level_dn, context.white_level_dn) for frame in frames]
    return tuple(image[..., 0] if image.shape[-1] == 1 else image for image in shown)
