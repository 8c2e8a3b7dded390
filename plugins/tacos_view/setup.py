"""A camera in a study's scenes, ready to take frames."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from tacos_framework import Exposure, FrameBatch, NamedScenario, Plugins, Recipe, Rig
from tacos_framework.formation import PlacedEffect, PlacedSensor
from tacos_framework.plan import Plan, make_plan
from tacos_framework.simulation import EpisodeSpec, Simulation, overrides_of, placed
from tacos_view.cameras import CameraChoice, CameraName, built_rig, choose_camera
from tacos_view.recipes import study_recipe

PURPOSE = "view"
"""Names the episodes, so that no study has been scored on the scenes that are shown."""


@dataclass(frozen=True)
class RenderSetup:
    """A camera in a study's scenes, ready to take frames."""

    plan: Plan
    camera: CameraChoice
    simulation: Simulation

    @property
    def rig(self) -> Rig:
        return built_rig(self.plan, self.camera)

    def frames(self, count: int | None = None, *, seed: int | None = None) -> Iterator[FrameBatch]:
        """Consecutive frames of one trip, one by one; nothing of earlier ones is kept.

        `seed`: which world and trip; the recipe's seed if None.
        """
        spec, values = self.episode_spec(count, seed), self.camera.values
        if taken := self._taken_by_a_task:
            task, port = taken
            for batch in self.simulation.batches(task, values, spec, port):
                for i in range(len(batch.episode)):
                    yield one_frame(batch, i)
            return
        length = self.simulation.frame_count(values, spec)
        for i in range(length):
            yield self.simulation.sample(values, spec, i / max(1, length - 1))

    @property
    def _taken_by_a_task(self) -> tuple[str, str] | None:
        """A task and its port that take the frames that are shown, with as little else as may be."""
        graph = self.plan.graph
        taking = [
            (task, port)
            for task in graph.of_kind("task")
            for port, source in graph.nodes[task].sources.items()
            if source == graph.shown
        ]
        return min(taking, key=lambda each: len(graph.nodes[each[0]].sources), default=None)

    def along_the_trip(self, count: int, *, seed: int | None = None) -> Iterator[FrameBatch]:
        spec = self.episode_spec(None, seed)
        for i in range(count):
            yield self.simulation.sample(self.camera.values, spec, (i + 0.5) / count)

    def episode_spec(self, count: int | None, seed: int | None) -> EpisodeSpec:
        first = self.plan.recipe.scenarios[0]
        scenario = first.name if isinstance(first, NamedScenario) else None
        return EpisodeSpec(
            self.plan.recipe.seed if seed is None else seed, (PURPOSE,), count, (0, 1), scenario
        )

    @cached_property
    def exposure(self) -> Exposure:
        first = self.plan.recipe.scenarios[0]
        name = first.name if isinstance(first, NamedScenario) else ""
        scenario = first.model_copy(update=self._overrides.of_scenario(name))
        return self.plan.exposure_in(scenario, self.plan.rig_variables(self.camera.values))

    @cached_property
    def sensor(self) -> PlacedSensor:
        name = self.plan.graph.of_kind("sensor")[0]
        sensor: PlacedSensor = placed(name, self.plan.nodes[name], self._overrides.nodes)
        return sensor

    @cached_property
    def effects(self) -> tuple[PlacedEffect, ...]:
        nodes = [(n, self.plan.nodes[n], self._overrides.nodes) for n in self.plan.graph.of_kind("effect")]
        own = [(part.name, part, self._overrides.effects) for part in self.plan.effects]
        return tuple(placed(name, part, overrides) for name, part, overrides in (*own, *nodes))

    @property
    def _overrides(self) -> Any:
        return overrides_of(self.camera.values, self.plan.recipe.effect_names)


def one_frame(batch: FrameBatch, index: int) -> FrameBatch:
    """One frame of a batch, without copying."""
    if len(batch.episode) == 1:
        return batch
    capture = replace(
        batch.capture,
        episode=batch.episode[index : index + 1],
        views=tuple(view.frame(index) for view in batch.capture.views),
    )
    return replace(
        batch,
        capture=capture,
        images=tuple(image[index : index + 1] for image in batch.images),
        exposures=tuple(taken[index : index + 1] for taken in batch.exposures),
        dn_per_electron=tuple(known[index : index + 1] for known in batch.dn_per_electron),
    )


def set_up(
    recipe: str | Path | Recipe,
    camera: CameraName = None,
    *,
    sets: Mapping[str, Any] | None = None,
    effects: Sequence[Mapping[str, Any]] = (),
    plugins: Plugins | None = None,
) -> RenderSetup:
    """A camera in a study's scenes, ready to take frames.

    - `recipe`: what `tacos_view.recipes.study_recipe` takes: a recipe, a results folder, or ``scene.indoor``.
    - `camera`: what `tacos_view.cameras.choose_camera` takes: a name, values, or None for the default.
    - `plugins`: what is installed; it is looked up if None.

    Raises UserError with all that is wrong with the recipe, or with the camera.
    """
    plugins = plugins or Plugins.discover()
    plan = make_plan(study_recipe(recipe, sets, effects, plugins=plugins), plugins)
    is_run = not isinstance(recipe, Recipe) and (Path(recipe) / "result.json").is_file()
    choice = choose_camera(plan, camera, Path(str(recipe)) if is_run else None)
    return RenderSetup(plan, choice, Simulation(plan))
