"""A plan brought to life, candidate by candidate."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from pydantic import ValidationError

from tacos_framework.cache import Recent, content_key
from tacos_framework.contracts import Scores, State
from tacos_framework.errors import CandidateFailed, UserError
from tacos_framework.formation import ImageFormation, PlacedEffect, PlacedSensor
from tacos_framework.plan import Part, Plan
from tacos_framework.plugins import culprit_of
from tacos_framework.randomness import generator
from tacos_framework.settings import Settings
from tacos_framework.simulation.clock import Clock
from tacos_framework.simulation.episodes import EpisodeSpec
from tacos_framework.simulation.evaluation import Evaluation, failed_by, judged
from tacos_framework.simulation.scores import score
from tacos_framework.simulation.training import train
from tacos_framework.simulation.trial import Trial
from tacos_framework.values import Episode, Exposure, FrameBatch


class Simulation:
    """A plan brought to life: components built once, worlds kept while they are used.

    Parameters
    ----------
    plan
        What to simulate.
    """

    def __init__(self, plan: Plan):
        self.plan = plan
        recipe = plan.recipe
        self._rig = plan.rig.make()
        self._components = {name: _placed(name, part) for name, part in plan.nodes.items()}
        kept = max(recipe.study.episodes, recipe.test.episodes if recipe.test else 1)
        self._episodes: Recent[Episode] = Recent(size=min(kept, 4) + bool(plan.trainable))

    def initial_states(self) -> dict[str, State]:
        """The states of the trainable tasks before the study."""
        states = {}
        for name in self.plan.trainable:
            rng = generator(self.plan.recipe.seed, "state", name)
            with self.plan.nodes[name].calling(f"initial_state in node {name!r}"):
                states[name] = self._components[name].initial_state(rng=rng)
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

        Parameters
        ----------
        values
            Plain values of its design variables.
        episodes
            What it is scored on.
        states
            States of the trainable tasks before it.
        training
            What they train on first; None leaves them as they are.
        partial
            The episodes are but a part of those it is to be judged by: its fitness is left open.
        """
        clock = Clock()
        evaluation = Evaluation(values=values)
        with clock.of("framework"):
            try:
                variables = self.plan.rig_variables(values)
            except ValidationError as error:
                return replace(evaluation, failed=f"the rig refuses it: {error.errors()[0]['msg']}")
            try:
                with self.plan.rig.calling("derived"):
                    derived = dict(self._rig.derived(variables))
                evaluation = replace(evaluation, derived=derived)
                broken = [sentence for c in self.plan.constraints for sentence in c.broken(derived)]
                if broken:
                    return replace(evaluation, failed="; ".join(broken))
                trial = self._trial(values, variables, clock)
                scored = self._scored(evaluation, trial, episodes, states, training)
                return scored if partial else judged(scored, self.plan.fitness)
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
        trial: Trial,
        episodes: Sequence[EpisodeSpec],
        states: Mapping[str, State],
        training: EpisodeSpec | None,
    ) -> Evaluation:
        """The evaluation with the scores of each episode, and what they cost."""
        for component in trial.components.values():  # before anything is rendered in vain
            component = component.sensor if isinstance(component, PlacedSensor) else component
            if callable(lacks := getattr(component, "lacks", None)) and (reason := lacks(trial.rig)):
                raise CandidateFailed(reason)
        images = 0
        states = dict(states)
        if training is not None:
            for name in self.plan.trainable:
                states[name], rendered = train(trial, name, states[name], training)
                images += rendered
        per_episode: list[Scores] = []
        for spec in episodes:
            scores, rendered = score(trial, spec, states)
            per_episode.append(scores)
            images += rendered
        return replace(
            evaluation,
            episodes=tuple(per_episode),
            images=images,
            seconds=trial.clock.seconds,
            states=states if training is not None else {},
        )

    def batches(self, task: str, values: Mapping[str, Any], spec: EpisodeSpec) -> Iterator[FrameBatch]:
        """What a task of one port is given of an episode that a candidate sees, without scoring it."""
        trial = self._trial(values, self.plan.rig_variables(values), Clock())
        scene = self.plan.graph.scene_of(task)
        episode = trial.episode(scene, spec)
        for inputs in trial.stream(scene, episode, spec, [task]):
            (batch,) = inputs[task].values()
            yield batch

    def sample(self, values: Mapping[str, Any], spec: EpisodeSpec, position: float) -> FrameBatch:
        """One frame of the first sensor node, at a position in 0..1 along the episode."""
        graph = self.plan.graph
        sensor = graph.of_kind("sensor")[0]
        scene = graph.scene_of(sensor)
        trial = self._trial(values, self.plan.rig_variables(values), Clock())
        episode = trial.episode(scene, spec)
        frame = round(position * (len(episode) - 1))
        batch = episode[frame : frame + 1]
        outputs: dict[str, Any] = {scene: batch}
        draws = trial.draws(spec)
        for name in graph.leading_to(sensor):
            node = graph.nodes[name]
            inputs = {port: outputs[source] for port, source in node.sources.items()}
            outputs[name] = trial.output(node, inputs, draws)
        return outputs[sensor]

    def _trial(self, values: Mapping[str, Any], variables: Settings, clock: Clock) -> Trial:
        overrides: dict[str, dict[str, Any]] = {}
        for name, value in values.items():
            node, _, setting = name.partition(".")
            if setting:
                overrides.setdefault(node, {})[setting] = value
        scenario = self.plan.recipe.scenario.model_copy(update=overrides.pop("scenario", {}))
        components = {
            name: _placed(name, self.plan.nodes[name], overrides[name]) if name in overrides else component
            for name, component in self._components.items()
        }
        exposure = Exposure(scenario.exposure_ms * 1e-3, scenario.f_number, scenario.gain_db)
        return Trial(
            plan=self.plan,
            rig=self._rig.build(variables),
            exposure=exposure,
            scenario=scenario,
            components=components,
            overrides=overrides,
            formation=ImageFormation(exposure, [placed_effect(part.use, part) for part in self.plan.effects]),
            kept=self._episodes,
            key=content_key(values),
            clock=clock,
        )


def _placed(name: str, part: Part, overrides: Mapping[str, Any] | None = None) -> Any:
    """The component of a node, or what places it in image formation."""
    match part.use.partition(".")[0]:
        case "sensor":
            return PlacedSensor(part.name, name, part.make(overrides))
        case "effect":
            return placed_effect(name, part, overrides)
    return part.make(overrides)


def placed_effect(name: str, part: Part, overrides: Mapping[str, Any] | None = None) -> PlacedEffect:
    """An effect of a recipe, for all cameras."""
    return PlacedEffect(part.name, name, part.cls, part.with_settings(overrides).config)
