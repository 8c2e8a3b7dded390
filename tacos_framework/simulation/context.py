"""One candidate on its way through the graph: its episodes, its frames, and the time they take."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from tacos_framework.cache import LRUCache, content_key
from tacos_framework.contracts import EpisodeStore, TaskBase, optional
from tacos_framework.formation import EpisodeDraws, ImageFormation, captured, frames_for
from tacos_framework.graph import Node
from tacos_framework.plan import Plan
from tacos_framework.randomness import generator
from tacos_framework.recipe import Scenario
from tacos_framework.simulation.checked_outputs import checked_output
from tacos_framework.simulation.clock import Clock
from tacos_framework.simulation.episodes import EpisodeSpec, block_of
from tacos_framework.values import Episode, Exposure, FrameBatch, Rig


@dataclass(frozen=True)
class EvaluationContext:
    """A candidate, ready to be simulated."""

    plan: Plan
    rig: Rig
    exposure: Exposure
    scenario: Scenario
    """The surroundings, with what the candidate sets of them."""
    components: Mapping[str, Any]
    """The component of each node, built with the candidate's settings; of sensors and effects as placed
    (`PlacedSensor`, `PlacedEffect`).
    """
    overrides: Mapping[str, Mapping[str, Any]]
    formation: ImageFormation
    """Image formation, with the effects that hold for all images."""
    kept: LRUCache[Episode]
    """Episodes made lately, shared by the evaluations of a simulation."""
    key: str
    clock: Clock
    store: EpisodeStore | None = None
    """Keeps episodes for other processes and studies, where there is one."""

    def episode(self, scene: str, spec: EpisodeSpec) -> Episode:
        """The episode of a scene node that a spec names."""
        overrides = dict(self.overrides.get(scene, {}))
        if spec.frames is not None:
            overrides["frames"] = spec.frames
        lux = self.scenario.illumination_lux

        part, names = self.plan.nodes[scene], (*spec.name, scene)

        def make() -> Episode:
            component = part.make(overrides) if overrides else self.components[scene]
            supplied = {"rng": generator(spec.seed, *names), "illumination_lux": lux}
            wanted = self.plan.graph.nodes[scene].signature.supplied
            with part.calling(f"episode in node {scene!r}"):
                made: Episode = component.episode(**{n: supplied[n] for n in supplied if n in wanted})
            return made

        def stored() -> Episode:
            if self.store is None:
                return make()
            follows_from = {"seed": spec.seed, "names": names, "illumination_lux": lux}
            return self.store.episode(part.cls, part.with_settings(overrides).config, follows_from, make)

        whole = self.kept.get(
            (scene, replace(spec, block=(0, 1), scenario=None), lux, content_key(overrides)), stored
        )
        return block_of(whole, *spec.block)

    def stream(
        self, scene: str, episode: Episode, draws: EpisodeDraws, tasks: Sequence[str], *, wanted: bool = True
    ) -> Iterator[Mapping[str, Any]]:
        """Inputs of the tasks in an episode, frame by frame: ``{task: {port: value}}``.

        Frames come in the form that each task wants, or without `wanted` as the cameras deliver them.
        Tasks that want several frames at a time get as many, if they say so (`Task.frames_per_update`). Of an
        episode that is gone on with, the draws remember what came before.
        """

        def call(node: Node, inputs: Mapping[str, Any], batch: Episode) -> Any:
            with self.at_work(node.name):
                return self.output(node, inputs, draws, batch.first_frame)

        at_a_time = [optional(self.components[task], TaskBase, "frames_per_update") for task in tasks]
        for inputs in self.plan.graph.stream(scene, episode, max(at_a_time, default=1), call, tasks):
            yield {task: self._as_wanted(task, given) if wanted else given for task, given in inputs.items()}

    def _as_wanted(self, task: str, given: Mapping[str, Any]) -> Mapping[str, Any]:
        """Inputs of a task, its frames in the form it wants."""
        component = self.components[task]
        return {
            port: frames_for(component, value) if isinstance(value, FrameBatch) else value
            for port, value in given.items()
        }

    def draws(self, spec: EpisodeSpec) -> EpisodeDraws:
        """Draws along an episode; candidates share them if the recipe says so."""
        common = self.plan.recipe.study.common_random_numbers
        return EpisodeDraws(spec.seed, (*spec.name, *(() if common else (self.key,))))

    def output(self, node: Node, inputs: Mapping[str, Any], draws: EpisodeDraws, first_frame: int) -> Any:
        """Output of a node that is neither scene nor task, for inputs that begin at a frame."""
        component = self.components[node.name]
        draws = draws.at(node.name)
        if node.kind == "sensor":
            (capture,) = inputs.values()
            return self.formation.expose(capture, component.assuming(draws.key), draws)
        if node.kind == "effect":
            (image,) = inputs.values()
            return self.formation.with_effect(image, component, draws)
        supplied = {
            "rig": self.rig,
            "exposure": self.exposure,
            "illumination_lux": self.scenario.illumination_lux,
        }
        asked = node.signature.supplied
        wanted = {name: value for name, value in supplied.items() if name in asked}
        if "rng" in asked:
            wanted["rng"] = draws.rng(first_frame, node.name)
        if "memory" in asked:
            wanted["memory"] = draws.memory()
        verb = partial(getattr(component, node.signature.verb), **inputs, **wanted)
        made = captured(component, self.rig, verb) if node.kind == "renderer" and "rig" in wanted else verb()
        checked_output(self.plan.nodes[node.name].origin, made)
        return self.formation.light(made, draws) if node.kind == "renderer" else made

    @contextmanager
    def at_work(self, name: str, doing: str = "") -> Iterator[None]:
        """Count the time inside for a node, or for one thing it does; say so where an error arose there."""
        at_node = f"in node {name!r}"
        guard = self.plan.nodes[name].calling(f"{doing} {at_node}" if doing else at_node)
        with self.clock.of(f"{name}, {doing}" if doing else name), guard:
            yield
