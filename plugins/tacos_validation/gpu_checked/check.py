"""The procedure `procedure.check-gpu`."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from tacos_framework import Evaluation, Executor, Fault, Plugins, Progress, Settings, UserError, setting
from tacos_framework.plan import Plan, make_plan
from tacos_framework.simulation import EpisodeSpec, Evaluator, ScoreJob
from tacos_framework.study import score_pipelined, score_sharded
from tacos_validation.gpu_checked.pictures import Difference, difference, taken_on
from tacos_validation.harness import study_recipe

ALIKE = Difference(ids=1e-3, depth=1e-3, luminance=5e-2)
"""Pictures of two devices that part by no more than this are alike: edges are rounded differently."""


class CheckGpu:
    """Compares the pictures of the device in use with those of software, and times a study on it.

    A few candidates of a recipe are trained on and scored by its executor: candidates an hour, and for each
    part of the work the share of the workers' time. What is left of it is idle, or starting.
    """

    class Config(Settings):
        recipe: str = setting(
            "headset_quick",
            help="The recipe that is rendered and timed: a path, or the name of a shipped one.",
            is_path=True,
        )
        frames: int = setting(8, help="Frames that are compared.", ge=2, le=1000)
        candidates: int = setting(4, help="Candidates that are timed.", ge=1, le=1000)

    def __init__(self, config: Config) -> None:
        self.config = config

    def check(self, *, plugins: Plugins) -> None:
        self._plan(plugins)

    def run(self, *, plugins: Plugins, executor: Executor, progress: Progress) -> Mapping[str, Any]:
        plan = self._plan(plugins)
        values = _middle(plan)
        progress.phase("Rendering on both", 2)
        used = taken_on("auto", plan.recipe, values, self.config.frames)
        progress.step()
        software = taken_on("cpu", plan.recipe, values, self.config.frames)
        progress.step()
        parted = difference(used, software)
        alike = all(asdict(parted)[name] <= most for name, most in asdict(ALIKE).items())
        progress.phase("Timing a study", None)
        timing = self._timed(plan, values, executor)
        result = {
            "renderer": used.renderer,
            "is_gpu": not used.is_software,
            "frames_per_s": {used.renderer: used.frames_per_s, "software": software.frames_per_s},
            "differing_pixels": asdict(parted),
            "alike": alike,
            **timing,
        }
        return {**result, "summary": _summary(result)}

    def _plan(self, plugins: Plugins) -> Plan:
        return make_plan(study_recipe(self.config.recipe, {}, key="recipe"), plugins)

    def _timed(self, plan: Plan, values: dict[str, Any], executor: Executor) -> dict[str, Any]:
        evaluate, seed = Evaluator(plan), plan.recipe.seed
        states = evaluate.simulation.initial_states()
        episodes = tuple(EpisodeSpec(seed, ("gpu-check", i)) for i in range(plan.recipe.study.episodes))
        jobs = [
            ScoreJob(values, episodes, states, EpisodeSpec(seed, ("train", 0, i)) if states else None)
            for i in range(self.config.candidates)
        ]
        began = time.perf_counter()
        scored = score_pipelined if states else score_sharded
        found: list[Evaluation] = list(scored(jobs, executor, evaluate))
        wall_s = time.perf_counter() - began
        if failed := next((each.failed for each in found if each.failed), None):
            raise UserError(Fault(self.config.recipe, f"its candidate cannot be scored: {failed}"))
        workers = getattr(executor, "workers", 1)
        nodes = dict.fromkeys(name for each in found for name in each.seconds)
        shares = {
            name: sum(each.seconds.get(name, 0.0) for each in found) / (wall_s * workers) for name in nodes
        }
        return {
            "workers": workers,
            "trains": bool(states),
            "candidates_per_hour": 3600 * len(found) / wall_s,
            "share_of_time": shares,
            "idle_share": max(0.0, 1 - sum(shares.values())),
        }


def _middle(plan: Plan) -> dict[str, Any]:
    """The first product with what it leaves free in the middle, or the middle of the design space."""
    fixes = dict(plan.cameras[0].fixes) if plan.cameras else {}
    space = plan.free_of(plan.cameras[0]) if plan.cameras else plan.space
    middle = [(gene.lower + gene.upper) / 2 for gene in space.genes]
    return {**fixes, **space.decode(middle).as_dict()}


def _summary(result: Mapping[str, Any]) -> str:
    rates = result["frames_per_s"]
    device = result["renderer"]
    lines = [
        f"{device}: {rates[device]:.1f} frames/s through all of image formation; "
        f"software: {rates['software']:.1f} frames/s."
    ]
    if not result["is_gpu"]:
        lines.insert(0, "No GPU renders here: software was compared with itself.")
    parted = ", ".join(f"{name} {share:.2%}" for name, share in result["differing_pixels"].items())
    lines.append(
        f"The pictures are {'alike' if result['alike'] else 'NOT alike'}; pixels that differ: {parted}."
    )
    doing = "trained on and scored" if result["trains"] else "scored"
    lines.append(
        f"{result['candidates_per_hour']:.0f} candidates an hour {doing} by {result['workers']} workers, "
        f"{result['idle_share']:.0%} of their time idle or starting."
    )
    shares = sorted(result["share_of_time"].items(), key=lambda each: -each[1])
    lines.append("Of their time: " + ", ".join(f"{name} {share:.0%}" for name, share in shares[:8]) + ".")
    return "\n".join(lines)
