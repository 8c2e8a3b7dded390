"""A plan brought to life, candidate by candidate."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from pydantic import ValidationError

from tacos_framework.cache import LRUCache, content_key
from tacos_framework.contracts import EffectBase, EpisodeStore, Scores, SensorBase, State, optional
from tacos_framework.errors import CandidateFailed, UserError
from tacos_framework.formation import ImageFormation, PlacedControl, PlacedEffect, PlacedSensor
from tacos_framework.plan import EXPOSURE, REFUSED, ConfiguredComponent, EffectPart, Plan
from tacos_framework.plugins import culprit_of
from tacos_framework.plugins.guarded import calling
from tacos_framework.randomness import generator
from tacos_framework.recipe import NamedScenario
from tacos_framework.settings import Settings
from tacos_framework.simulation.clock import Clock
from tacos_framework.simulation.context import EvaluationContext
from tacos_framework.simulation.episodes import EpisodeSpec
from tacos_framework.simulation.evaluation import Evaluation, failed_by, with_fitness_or_failed
from tacos_framework.simulation.overrides import SettingOverrides, overrides_of
from tacos_framework.simulation.scores import score
from tacos_framework.simulation.shown import not_shown
from tacos_framework.simulation.training import RenderedFrames, rendered_ahead, train
from tacos_framework.values import Episode, FrameBatch

KEPT_BYTES = 2**30
"""Memory the worlds of a simulation may take that are kept for candidates to come [bytes]."""


class Simulation:
    """A plan brought to life: components built once, worlds kept while they are used.

    - `store`: keeps episodes for other processes and studies.
    """

    def __init__(self, plan: Plan, store: EpisodeStore | None = None):
        self.plan = plan
        self._store = store
        recipe = plan.recipe
        self._rig = plan.rig.instance
        study = recipe.study
        kept = max(study.episodes, study.final_episodes or 1, recipe.test.episodes if recipe.test else 1)
        lights = len({scenario.illumination_lux for scenario in recipe.scenarios})
        self._episodes: LRUCache[Episode] = LRUCache(
            size=(kept + 2 * bool(plan.trainable)) * lights,
            most_bytes=KEPT_BYTES,
            bytes_of=lambda episode: episode.world.nbytes,
        )
        self._ahead: dict[tuple[str, EpisodeSpec, str], RenderedFrames | None] = {}

    def initial_states(self) -> dict[str, State]:
        """The states of the trainable tasks before the study."""
        states = {}
        for name in self.plan.trainable:
            rng = generator(self.plan.recipe.seed, "state", name)
            part = self.plan.nodes[name]
            with part.calling(f"initial_state in node {name!r}"):
                states[name] = part.instance.initial_state(rng=rng)
        return states

    def evaluate(
        self,
        values: Mapping[str, Any],
        episodes: Sequence[EpisodeSpec],
        *,
        states: Mapping[str, State],
        training: EpisodeSpec | None,
        partial: bool,
    ) -> Evaluation:
        """Train on and score one candidate.

        A candidate that breaks a constraint is not simulated. `CandidateFailed` is an answer; any other error
        of a component fails the candidate too, or passes unchanged where the recipe has ``on_error: stop``.
        What is wrong with the recipe, and shows only now, passes always.

        `training`: what they train on first; None leaves them as they are. `partial`: the episodes are but a
        part of those it is to be scored by: its fitness is left open.
        """
        clock = Clock()
        evaluation = Evaluation(values=values)
        with clock.of("framework"):
            try:
                variables = self.plan.rig_variables(values)
            except ValidationError as error:
                refused = f"the rig refuses it: {error.errors()[0]['msg']}"
                return replace(evaluation, failed=refused, broken=dict(REFUSED))
            try:
                with self.plan.rig.calling("derived"):
                    derived = dict(self._rig.derived(variables))
                evaluation = replace(evaluation, derived=derived)
                if breaches := self.plan.breaches(values, derived):
                    said = "; ".join(each.sentence for each in breaches)
                    amounts = {each.quantity: each.amount for each in breaches}
                    return replace(evaluation, failed=said, broken=amounts)
                contexts = self._contexts(values, variables, clock)
                scored = self._scored(evaluation, contexts, episodes, states, training)
                return scored if partial else with_fitness_or_failed(scored, self.plan.fitness)
            except CandidateFailed as error:
                return replace(evaluation, failed=str(error), seconds=clock.seconds)
            except (Exception, SystemExit) as error:
                error.add_note(f"while evaluating the candidate {dict(values)}")
                of_recipe = isinstance(error, UserError) and culprit_of(error) is None
                if of_recipe or self.plan.recipe.study.on_error == "stop":
                    raise
                return replace(failed_by(evaluation, error), seconds=clock.seconds)

    def _scored(
        self,
        evaluation: Evaluation,
        contexts: Mapping[str, EvaluationContext],
        episodes: Sequence[EpisodeSpec],
        states: Mapping[str, State],
        training: EpisodeSpec | None,
    ) -> Evaluation:
        """The evaluation with the scores of each episode, and what they cost."""
        context = next(iter(contexts.values()))
        for name, component in context.components.items():  # before anything is rendered in vain
            sensors = (
                [component.sensor, *component.by_camera.values()]
                if isinstance(component, PlacedSensor)
                else [component]
            )
            with self.plan.nodes[name].calling(f"lacks in node {name!r}"):
                reasons = [
                    each.lacks(context.rig)
                    for each in sensors
                    if callable(optional(each, SensorBase, "lacks"))
                ]
            if reason := next(filter(None, reasons), None):
                raise CandidateFailed(reason)
        if beyond := not_shown(contexts):
            raise CandidateFailed("; ".join(beyond.values()))
        for effect in context.formation.effects:
            if callable(optional(effect.cls, EffectBase, "lacks")):
                with calling(effect.use, doing="lacks"):
                    reason = effect.cls(effect.config).lacks(context.rig)
                if reason:
                    raise CandidateFailed(reason)
        images = 0
        states = dict(states)
        if training is not None:
            for name in self.plan.trainable:
                learning = [contexts[key] for key in _scenarios(contexts, training)]
                ahead = self._ahead.pop((context.key, training, name), None)
                states[name], rendered = train(learning, name, states[name], training, ahead)
                images += rendered
        columns: dict[str, list[Scores]] = {name: [] for name in contexts}
        for spec in episodes:
            for name in _scenarios(contexts, spec):
                scores, rendered = score(contexts[name], spec, states)
                columns[name].append(scores)
                images += rendered
        several = isinstance(self.plan.recipe.scenario, tuple)
        return replace(
            evaluation,
            episodes=() if several else tuple(columns[""]),
            scenario_episodes={name: tuple(column) for name, column in columns.items()} if several else {},
            images=images,
            seconds=context.clock.seconds,
            states=states if training is not None else {},
        )

    def prepare(self, values: Mapping[str, Any], training: EpisodeSpec) -> Evaluation:
        """Render what tasks will train on, and keep it until they do; the time it took."""
        clock = Clock()
        self._ahead = {}  # of one candidate at a time
        contexts = self._contexts(values, self.plan.rig_variables(values), clock)
        learning = [contexts[name] for name in _scenarios(contexts, training)]
        for task in self.plan.trainable:
            self._ahead[learning[0].key, training, task] = rendered_ahead(learning, task, training)
        return Evaluation(values=values, seconds=clock.seconds)

    def batches(
        self,
        task: str,
        values: Mapping[str, Any],
        spec: EpisodeSpec,
        port: str | None = None,
        *,
        wanted: bool = False,
    ) -> Iterator[FrameBatch]:
        """The frames that reach a task in an episode of a candidate, without scoring them.

        At a port; at its only one where none is named. As the cameras deliver them, or with `wanted` in the
        form that the task wants.
        """
        context = self._evaluation_context(values, spec)
        scene = self.plan.graph.scene_of(task)
        episode = context.episode(scene, spec)
        for inputs in context.stream(scene, episode, context.draws(spec), [task], wanted=wanted):
            (batch,) = inputs[task].values() if port is None else (inputs[task][port],)
            yield batch

    def not_shown(self, values: Mapping[str, Any]) -> dict[str, str]:
        """Why a candidate is not what the scenes can show: a word or two -> a sentence."""
        return not_shown(self._contexts(values, self.plan.rig_variables(values), Clock()))

    def frame_count(self, values: Mapping[str, Any], spec: EpisodeSpec) -> int:
        """Number of frames of an episode, which may be fewer than were asked for."""
        context = self._evaluation_context(values, spec)
        return len(context.episode(self.plan.graph.scene_of(self.plan.graph.shown), spec))

    def sample(self, values: Mapping[str, Any], spec: EpisodeSpec, position: float) -> FrameBatch:
        """One frame as tasks see it, at a position in 0..1 along the episode."""
        graph = self.plan.graph
        shown = graph.shown
        context = self._evaluation_context(values, spec)
        episode = context.episode(graph.scene_of(shown), spec)
        frame = round(position * (len(episode) - 1))
        batch = episode[frame : frame + 1]
        outputs: dict[str, Any] = {graph.scene_of(shown): batch}
        draws = context.draws(spec)
        for name in graph.leading_to(shown):
            node = graph.nodes[name]
            inputs = {port: outputs[source] for port, source in node.sources.items()}
            outputs[name] = context.output(node, inputs, draws, batch.first_frame)
        return outputs[shown]

    def _evaluation_context(self, values: Mapping[str, Any], spec: EpisodeSpec) -> EvaluationContext:
        """A candidate in the scenario of an episode; in the first, where it is of all."""
        contexts = self._contexts(values, self.plan.rig_variables(values), Clock())
        return contexts[_scenarios(contexts, spec)[0]]

    def _contexts(
        self, values: Mapping[str, Any], variables: Settings, clock: Clock
    ) -> dict[str, EvaluationContext]:
        """A candidate in each scenario, by name; the only one, where it has none, is called ``""``."""
        plan = self.plan
        overrides = overrides_of(values, plan.recipe.effect_names)
        components = {name: placed(name, part, overrides.nodes) for name, part in plan.nodes.items()}
        effects = [placed(part.name, part, overrides.effects) for part in plan.effects]
        control = None
        if plan.exposure is not None:
            part, _ = overrides.exposure.parts(EXPOSURE, plan.exposure)
            control = PlacedControl(part.origin, part.instance)
        key = content_key(values)
        with plan.rig.calling("build"):
            rig = self._rig.build(variables)
        contexts = {}
        for given in plan.recipe.scenarios:
            name = given.name if isinstance(given, NamedScenario) else ""
            scenario = given.model_copy(update=overrides.of_scenario(name))
            exposure = plan.exposure_in(scenario, variables)
            contexts[name] = EvaluationContext(
                plan=plan,
                rig=rig,
                exposure=exposure,
                scenario=scenario,
                components=components,
                overrides=overrides.nodes.settings,
                formation=ImageFormation(exposure, effects, control),
                kept=self._episodes,
                key=key,
                clock=clock,
                store=self._store,
            )
        return contexts


def _scenarios(contexts: Mapping[str, EvaluationContext], spec: EpisodeSpec) -> list[str]:
    return list(contexts) if spec.scenario is None else [spec.scenario]


def placed(name: str, part: ConfiguredComponent, overrides: SettingOverrides) -> Any:
    """The component of a node or effect with a candidate's settings, or what places it in image formation."""
    whole, own = overrides.parts(name, part)
    if part.use.partition(".")[0] == "sensor":
        by_camera = {camera: each.instance for camera, each in own.items()}
        return PlacedSensor(part.origin, name, whole.instance, by_camera)
    if isinstance(part, EffectPart):
        configs = {camera: each.config for camera, each in own.items()}
        return PlacedEffect(part.origin, name, part.cls, whole.config, configs, part.cameras)
    return whole.instance
