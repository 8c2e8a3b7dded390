"""Pre-trains a task of a recipe on images of our own scenes, and writes weights to start studies with."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import JsonValue

from tacos_framework import (
    Budget,
    Executor,
    Fault,
    Plugins,
    Progress,
    Recipe,
    Scores,
    Settings,
    State,
    UserError,
    __version__,
    check,
    did_you_mean,
    generator,
    load_recipe,
    setting,
)
from tacos_framework.plan import Plan, make_plan
from tacos_framework.simulation import Evaluator
from tacos_framework.store import Results
from tacos_plugins.pretraining.kept_frames import KeptFrames
from tacos_plugins.pretraining.pages import PretrainingOutcome, page, summary
from tacos_plugins.pretraining.shots import Shooting, shots_of_worlds
from tacos_report.page import write_page

LOG = "epochs.jsonl"
MODEL = "model."
"""Begins the names of weights in a task's state; the rest is the optimizer's and stays behind."""


class Pretrain:
    """Trains one task of a recipe on images of many worlds, seen by many cameras of its design space.

    The images are rendered once and kept in the results folder, under ``frames/``. Every so many passes over
    them the task is scored on held-out worlds. The weights go to ``weights/NAME.safetensors``, from where
    the task's setting ``weights`` takes them; what made them stands in the file's header.

    A broken run goes on with ``--resume``, with the images there are and from the last pass that was
    finished, and ends with the same weights.

    Source: the paper, Sec. 4.3, "Object Detector": pre-trained on 2000 images of the simulator.
    """

    class Config(Settings):
        problem: str = setting(
            help="The recipe whose task is trained: a path, or the name of a shipped one.", is_path=True
        )
        change: dict[str, JsonValue] = setting(
            {}, help="Keys of that recipe to change, as with --set, e.g. {nodes.detect.batch_norm: update}."
        )
        node: str | None = setting(
            None, help="The node to train; may be left out where only one learns.", min_length=1
        )
        images: int = setting(2000, help="Images to train on.", ge=1)
        held_out: int = setting(256, help="Images of other worlds to score on.", ge=1)
        images_per_world: int = setting(32, help="Frames taken of each world.", ge=1)
        cameras_per_world: int = setting(8, help="Cameras that share a world's frames.", ge=1)
        epochs: int = setting(30, help="Passes over the images.", ge=1)
        score_every: int = setting(5, help="Passes between scores on held-out worlds.", ge=1)
        train: dict[str, JsonValue] = setting(
            {}, help="Settings of the training, as under a recipe's train:, e.g. {learning_rate: 1.0e-4}."
        )
        file: str = setting("pretrained", help="Name of the file of weights.", pattern=r"^[a-z0-9_-]+$")
        precision: Literal["float32", "float16"] = setting(
            "float32", help="Numbers in the file of weights; float16 halves it, and networks hardly notice."
        )

    def __init__(self, config: Config) -> None:
        self.config = config

    def check(self, *, seed: int, plugins: Plugins) -> None:
        """Look for faults in the recipe whose task is trained."""
        self._node(self._plan(plugins, seed))

    def run(
        self, *, out: Path, seed: int, plugins: Plugins, executor: Executor, progress: Progress, resume: bool
    ) -> Mapping[str, Any]:
        """Train; leaves the weights, ``epochs.jsonl`` and ``report.html``."""
        plan = self._plan(plugins, seed)
        node = self._node(plan)
        results = Results(out)
        training, held_out = self._shoot(plan, node, seed, out, plugins, executor, progress)
        task = plan.nodes[node].make()
        lines, state = self._train(task, training, held_out, seed, results, progress)
        about = self._about(plan, node, seed, lines)
        results.write_state(self.config.file, self._weights(state), about)
        results.keep_weights([self.config.file])
        size_bytes = (out / "weights" / f"{self.config.file}.safetensors").stat().st_size
        outcome = PretrainingOutcome(
            node=node,
            use=plan.nodes[node].use,
            file=f"weights/{self.config.file}.safetensors",
            size_bytes=size_bytes,
            images=training.images,
            held_out=held_out.images,
            epochs=tuple(lines),
            made_by=about,
        )
        write_page(out / "report.html", page(outcome))
        return {**outcome.as_data(), "summary": summary(outcome)}

    # what is trained --------------------------------------------------------------------------------------

    def _plan(self, plugins: Plugins, seed: int) -> Plan:
        recipe = load_recipe(self.config.problem, dict(self.config.change))
        if not isinstance(recipe, Recipe):
            raise UserError(Fault("problem", f"{self.config.problem} is no study", "a recipe that designs"))
        taken = {"seed": recipe.seed, "test.seed": recipe.test.seed if recipe.test else None}
        for key, value in taken.items():
            if value == seed:
                raise UserError(
                    Fault(
                        "seed",
                        f"{seed} is also the {key} of {self.config.problem}",
                        "a seed that no study uses, as its weights must not have seen a study's worlds",
                        "Set another seed.",
                    )
                )
        return make_plan(recipe, plugins)

    def _node(self, plan: Plan) -> str:
        names, wanted = plan.trainable, self.config.node
        if wanted is None and len(names) == 1:
            wanted = names[0]
        if wanted not in names:
            problem = self.config.problem
            what = (
                f"{problem} has no node {wanted!r} that learns"
                if wanted
                else f"{problem} has {len(names) or 'no'} nodes that learn"
            )
            raise UserError(Fault("node", what, "the name of one", did_you_mean(wanted or "", names)))
        kind = getattr(plan.nodes[wanted].cls, "Training", None)
        if kind is not None:
            faults = check(kind, dict(self.config.train), lambda path: ".".join(map(str, ("train", *path))))[
                1
            ]
            if faults:
                raise UserError(faults)
        return wanted

    def _shoot(
        self,
        plan: Plan,
        node: str,
        seed: int,
        out: Path,
        plugins: Plugins,
        executor: Executor,
        progress: Progress,
    ) -> tuple[KeptFrames, KeptFrames]:
        """The images to train on and those to score on, rendered where they are not there yet."""
        folder = out / "frames"
        folder.mkdir(exist_ok=True)
        wanted = {"pretrain": self.config.images, "held_out": self.config.held_out}
        worlds = {
            purpose: list(
                shots_of_worlds(
                    plan,
                    seed=seed,
                    purpose=purpose,
                    images=images,
                    images_per_world=self.config.images_per_world,
                    cameras_per_world=self.config.cameras_per_world,
                )
            )
            for purpose, images in wanted.items()
        }
        jobs = [Shooting(node, shots, str(folder)) for each in worlds.values() for shots in each]
        progress.phase("Rendering worlds", len(jobs))
        for rendered in executor.map(Evaluator(plan.recipe, plugins), jobs):
            progress.step(f"{rendered} images")
        rig = plan.rig.make()
        kept = (
            KeptFrames(
                tuple(
                    (file, rig.build(plan.rig_variables(shot.values)))
                    for shots in worlds[purpose]
                    for shot in shots
                    for file in shot.files(folder)
                )
            )
            for purpose in wanted
        )
        training, held_out = kept
        return training, held_out

    # training ---------------------------------------------------------------------------------------------

    def _train(
        self,
        task: Any,
        training: KeptFrames,
        held_out: KeptFrames,
        seed: int,
        results: Results,
        progress: Progress,
    ) -> tuple[list[dict[str, Any]], State]:
        """A line for each pass, and the state after the last."""
        lines = results.read_lines(LOG)
        state: State = (
            results.read_state(_state_name(len(lines)))
            if lines
            else task.initial_state(rng=generator(seed, "state"))
        )
        progress.phase("Training", self.config.epochs - len(lines))
        for epoch in range(len(lines) + 1, self.config.epochs + 1):
            began, steps = time.monotonic(), Steps()
            rng = generator(seed, "epoch", epoch)
            budget = Budget(1, self.config.train, steps.append)
            state = task.fit(training.shuffled(rng), state=state, budget=budget, rng=rng)
            due = epoch % self.config.score_every == 0 or epoch == self.config.epochs
            scores = _scores(task, state, held_out) if due else {}
            line = {
                "epoch": epoch,
                "losses": steps.means(),
                "scores": scores,
                "seconds": round(time.monotonic() - began, 3),
            }
            results.write_state(_state_name(epoch), state)
            results.append_line(LOG, line)
            results.keep_weights([_state_name(epoch)])
            lines.append(line)
            progress.step(", ".join(f"{name} {value:.3f}" for name, value in [*scores.items()][:1]))
        return lines, state

    def _weights(self, state: State) -> State:
        """The weights alone, in the precision asked for."""
        wanted = np.dtype(self.config.precision)
        weights = {}
        for name, array in state.items():
            if not name.startswith(MODEL):
                continue
            short = array.astype(wanted) if array.dtype == np.float32 else array
            weights[name.removeprefix(MODEL)] = short if np.all(np.isfinite(short)) else array
        return weights or dict(state)

    def _about(self, plan: Plan, node: str, seed: int, lines: Sequence[Mapping[str, Any]]) -> dict[str, str]:
        """Origin of the weights, for the header of their file."""
        asked = self.config.model_dump(mode="json", exclude={"file"})
        settings = plan.nodes[node].config.model_dump(mode="json", by_alias=True)
        return {
            "made_by": f"procedure.pretrain of tacos-framework {__version__}",
            "task": plan.nodes[node].use,
            "seed": str(seed),
            "recipe": json.dumps(asked, sort_keys=True),
            "settings": json.dumps(settings, sort_keys=True),
            "scores": json.dumps(lines[-1]["scores"], sort_keys=True),
        }


class Steps(list[Mapping[str, float]]):
    """Losses of the steps of a pass."""

    def means(self) -> dict[str, float]:
        names = self[0] if self else ()
        return {name: float(np.mean([losses[name] for losses in self])) for name in names}


def _scores(task: Any, state: State, frames: KeptFrames) -> Scores:
    scorer = task.begin(state=state)
    for batch in frames:
        scorer.update(batch)
    return {name: float(value) for name, value in scorer.scores().items()}


def _state_name(epoch: int) -> str:
    return f"epoch.{epoch}"
