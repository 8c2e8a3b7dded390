"""One candidate on its way through the graph: its episodes, its frames, and the time they take."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tacos_framework.cache import Recent, content_key
from tacos_framework.graph import Node
from tacos_framework.plan import Part, Plan
from tacos_framework.randomness import generator
from tacos_framework.recipe import Scenario
from tacos_framework.simulation.acting_effects import ActingEffects
from tacos_framework.simulation.checked_outputs import checked_output
from tacos_framework.simulation.clock import Clock
from tacos_framework.simulation.episodes import EpisodeSpec, block_of
from tacos_framework.values import Episode, Exposure, Rig

BATCH_BYTES = 256 * 2**20
"""Memory a batch of frames may take on its way through the graph [bytes]."""

BYTES_PER_PIXEL = 64
"""Memory of a simulated pixel at the widest point of the graph: light, depth, ids, samples [bytes]."""


@dataclass(frozen=True)
class Trial:
    """A candidate, ready to be simulated.

    Parameters
    ----------
    plan
        What is simulated.
    rig
        The candidate's cameras.
    exposure
        How long and how wide they open.
    scenario
        The surroundings, with what the candidate sets of them.
    components
        The component of each node, built with the candidate's settings.
    overrides
        The candidate's settings, by node.
    effects
        The effects in the order of image formation.
    kept
        Episodes made lately, shared by the trials of a simulation.
    key
        Content key of the candidate's values.
    clock
        Takes the time of each node.
    """

    plan: Plan
    rig: Rig
    exposure: Exposure
    scenario: Scenario
    components: Mapping[str, Any]
    overrides: Mapping[str, Mapping[str, Any]]
    effects: Sequence[tuple[Part, Any]]
    kept: Recent[Episode]
    key: str
    clock: Clock

    def episode(self, scene: str, spec: EpisodeSpec) -> Episode:
        """The episode of a scene node that a spec names."""
        overrides = dict(self.overrides.get(scene, {}))
        if spec.frames is not None:
            overrides["frames"] = spec.frames
        lux = self.scenario.illumination_lux

        def make() -> Episode:
            component = self.plan.nodes[scene].make(overrides) if overrides else self.components[scene]
            supplied = {"rng": generator(spec.seed, *spec.name, scene), "illumination_lux": lux}
            wanted = self.plan.graph.nodes[scene].signature.supplied
            return component.episode(**{name: supplied[name] for name in supplied if name in wanted})

        whole = self.kept.get((scene, replace(spec, block=(0, 1)), lux, content_key(overrides)), make)
        return block_of(whole, *spec.block)

    def stream(
        self, scene: str, episode: Episode, spec: EpisodeSpec, tasks: Sequence[str]
    ) -> Iterator[Mapping[str, Any]]:
        """What the tasks are given of an episode, batch by batch: ``{task: {port: value}}``."""

        def call(node: Node, inputs: Mapping[str, Any], batch: Episode) -> Any:
            with self.at_work(node.name):
                return self.image(node, inputs, batch, spec)

        yield from self.plan.graph.stream(scene, episode, batch_frames(self.rig), call, tasks)

    def image(self, node: Node, inputs: Mapping[str, Any], batch: Episode, spec: EpisodeSpec) -> Any:
        """What a renderer or a sensor makes of its inputs: light, or files."""
        crn = self.plan.recipe.study.common_random_numbers
        names = (*spec.name, node.name, batch.first_frame, *(() if crn else (self.key,)))
        rng = generator(spec.seed, *names)
        acting = ActingEffects(self.effects, self.rig, self.exposure, generator(spec.seed, *names, "effects"))
        supplied = {
            "rig": self.rig,
            "exposure": self.exposure,
            "rng": rng,
            "effects": acting,
            "illumination_lux": self.scenario.illumination_lux,
        }
        wanted = {name: value for name, value in supplied.items() if name in node.signature.supplied}
        name = self.plan.nodes[node.name].name
        if node.kind == "renderer":
            light = checked_output(name, self.components[node.name].capture(**inputs, **wanted))
            return acting.light(light)
        return acting.files(checked_output(name, self.components[node.name].expose(**inputs, **wanted)))

    @contextmanager
    def at_work(self, name: str, doing: str = "") -> Iterator[None]:
        """Count the time inside for a node, or for one thing it does; say so where an error arose there."""
        at_node = f"in node {name!r}"
        guard = self.plan.nodes[name].calling(f"{doing} {at_node}" if doing else at_node)
        with self.clock.of(f"{name}, {doing}" if doing else name), guard:
            yield


def batch_frames(rig: Rig) -> int:
    """How many frames go through the graph together, so that memory stays flat."""
    pixels = sum(camera.width_px * camera.height_px for camera in rig.cameras)
    return int(np.clip(BATCH_BYTES // (pixels * BYTES_PER_PIXEL), 1, 32))
