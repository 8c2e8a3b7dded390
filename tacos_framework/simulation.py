"""Evaluating candidates: from design variables through the graph to scores."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any, Protocol, TypeVar

import numpy as np
from pydantic import ValidationError

from tacos_framework.cache import Recent, content_key
from tacos_framework.contracts import Budget, Scorer, Scores, State, acts_after_noise
from tacos_framework.errors import CandidateFailed, Fault, UserError
from tacos_framework.fitness import Fitness, mean_scores
from tacos_framework.graph import Node
from tacos_framework.plan import Part, Plan, make_plan
from tacos_framework.plugins import Plugins
from tacos_framework.randomness import generator
from tacos_framework.recipe import Recipe, Scenario
from tacos_framework.values import Capture, Episode, Exposure, FrameBatch, Rig, Signal

log = logging.getLogger(__name__)

BATCH_BYTES = 256 * 2**20
"""Memory a batch of frames may take on its way through the graph [bytes]."""

BYTES_PER_PIXEL = 64
"""Memory of a simulated pixel at the widest point of the graph: light, depth, ids, samples [bytes]."""


@dataclass(frozen=True)
class EpisodeSpec:
    """Names an episode: the same spec gives the same world, path and noise, in any process.

    Parameters
    ----------
    seed
        Seed of the study or of its test scenes.
    name
        What the episode is for, e.g. ``("design", 3, 0)``.
    frames
        Number of frames; None leaves it to the scene.
    block
        Which part of the episode to score by itself, counted from 0, of how many equal parts.
    """

    seed: int
    name: tuple[str | int, ...]
    frames: int | None = None
    block: tuple[int, int] = (0, 1)


@dataclass(frozen=True)
class Evaluation:
    """What came out for one candidate.

    Parameters
    ----------
    values
        Plain values of all variables that were set.
    derived
        The rig's derived quantities.
    scores
        ``{"node.score": value}``, means over the episodes; empty when it failed.
    fitness
        Weighted sum; None when it failed.
    terms
        What each score contributes to the fitness.
    failed
        Why there are no scores, in a sentence.
    episodes
        Scores and fitness of each episode by itself, so that cameras can be compared episode by episode.
    images
        Images rendered.
    seconds
        Time spent in each node [s].
    states
        States of the trainable tasks after training on this candidate.
    cached
        Taken from an earlier, equal evaluation.
    dropped
        Why it was not scored on all episodes, in a sentence; its fitness is then what its place in the race
        stands for, not the sum of `terms`, which are of the episodes it saw.
    """

    values: Mapping[str, Any]
    derived: Mapping[str, float] = field(default_factory=dict)
    scores: Scores = field(default_factory=dict)
    fitness: float | None = None
    terms: Mapping[str, float] = field(default_factory=dict)
    failed: str | None = None
    episodes: tuple[Mapping[str, float], ...] = ()
    images: int = 0
    seconds: Mapping[str, float] = field(default_factory=dict)
    states: Mapping[str, State] = field(default_factory=dict)
    cached: bool = False
    dropped: str | None = None


def judged(evaluation: Evaluation, fitness: Fitness) -> Evaluation:
    """An evaluation with scores, fitness and terms from the scores of its episodes.

    Raises
    ------
    CandidateFailed
        When no episode reports a score that the fitness takes.
    """
    scores = mean_scores(evaluation.episodes)
    return replace(
        evaluation,
        scores=scores,
        fitness=fitness.value(scores),
        terms=fitness.terms(scores),
        episodes=tuple(_with_fitness(episode, fitness) for episode in evaluation.episodes),
    )


def _with_fitness(scores: Scores, fitness: Fitness) -> dict[str, float]:
    """An episode's scores, and its fitness where it has every score that takes."""
    if any(term.score not in scores for term in fitness.terms_of):
        return dict(scores)
    return {**scores, "fitness": fitness.value(scores)}


Result = TypeVar("Result", covariant=True)


class Job(Protocol[Result]):
    """Something to do with a simulation, in whatever process it lives."""

    def run(self, simulation: Simulation) -> Result:
        """Do it."""
        ...

    def lost(self, reason: str) -> Result:
        """What stands for the result where the process that runs it dies or hangs, again and again."""
        ...


@dataclass(frozen=True)
class ScoreJob:
    """Train the trainable tasks on a candidate's frames, then score it on other frames.

    Where the episodes are but a part of those it is to be judged by (``partial``), the fitness is left open.
    """

    values: Mapping[str, Any]
    episodes: tuple[EpisodeSpec, ...]
    states: Mapping[str, State] = field(default_factory=dict)
    training: EpisodeSpec | None = None
    partial: bool = False

    def run(self, simulation: Simulation) -> Evaluation:
        """See `Simulation.evaluate`."""
        return simulation.evaluate(self)

    def lost(self, reason: str) -> Evaluation:
        """The candidate failed."""
        return Evaluation(values=self.values, failed=reason)


@dataclass(frozen=True)
class SampleJob:
    """Take sample frames with a camera, to look at."""

    values: Mapping[str, Any]
    episode: EpisodeSpec
    at: tuple[float, ...]

    def run(self, simulation: Simulation) -> list[FrameBatch]:
        """One batch of one frame for each position in 0..1 along the episode."""
        return [simulation.sample(self, position) for position in self.at]

    def lost(self, reason: str) -> list[FrameBatch]:
        """No pictures."""
        log.warning("no sample frames of %s: %s", dict(self.values), reason)
        return []


class Evaluator:
    """Runs jobs in a simulation of its own. Can be pickled; the simulation is built where it is first used.

    Parameters
    ----------
    recipe
        What to simulate.
    plugins
        The host's plugins; None discovers the installed ones. Other processes discover them anew and
        register the modules that were registered by hand.
    """

    def __init__(self, recipe: Recipe, plugins: Plugins | None = None):
        self.recipe = recipe
        self._plugins = plugins
        self._modules = plugins.modules if plugins else ()
        self._simulation: Simulation | None = None

    def __call__(self, job: Job[Result]) -> Result:
        """Run a job."""
        return job.run(self.simulation)

    def lost(self, job: Job[Result], reason: str) -> Result:
        """What an executor gives for a job whose worker died or hung each time it was tried."""
        return job.lost(reason)

    @property
    def simulation(self) -> Simulation:
        """The simulation of this process."""
        if self._simulation is None:
            self._simulation = Simulation(make_plan(self.recipe, self._plugins or self._discover()))
        return self._simulation

    def _discover(self) -> Plugins:
        from importlib import import_module

        plugins = Plugins.discover()
        for name in self._modules:
            plugins.register(import_module(name))
        return plugins

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_plugins": None, "_simulation": None}


class Clock:
    """Time spent by name. Nested spans are taken out of the span around them."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._open: list[str] = []
        self._since = time.perf_counter()

    @contextmanager
    def of(self, name: str) -> Iterator[None]:
        """Count the time inside for `name`."""
        self._switch()
        self._open.append(name)
        try:
            yield
        finally:
            self._switch()
            self._open.pop()

    def _switch(self) -> None:
        now = time.perf_counter()
        if self._open:
            self.seconds[self._open[-1]] = self.seconds.get(self._open[-1], 0.0) + now - self._since
        self._since = now


@dataclass(frozen=True)
class _Setup:
    """A candidate, ready to be simulated."""

    rig: Rig
    exposure: Exposure
    scenario: Scenario
    components: Mapping[str, Any]
    overrides: Mapping[str, Mapping[str, Any]]
    key: str


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
        self._components = {name: part.make() for name, part in plan.nodes.items()}
        self._effects = [(part, part.make()) for part in plan.effects]
        kept = max(recipe.study.episodes, recipe.test.episodes if recipe.test else 1)
        self._episodes: Recent[Episode] = Recent(size=min(kept, 4) + bool(plan.trainable))

    def initial_states(self) -> dict[str, State]:
        """The states of the trainable tasks before the study."""
        return {
            name: self._components[name].initial_state(rng=generator(self.plan.recipe.seed, "state", name))
            for name in self.plan.trainable
        }

    def evaluate(self, job: ScoreJob) -> Evaluation:
        """Train on and score one candidate.

        A candidate that breaks a constraint is not simulated. Components' errors pass unchanged, with a note
        saying where they arose; only `CandidateFailed` is taken for an answer.
        """
        clock = Clock()
        failed = Evaluation(values=job.values)
        with clock.of("framework"):
            try:
                variables = self.plan.rig_variables(job.values)
            except ValidationError as error:
                return replace(failed, failed=f"the rig refuses it: {error.errors()[0]['msg']}")
            derived = dict(self._rig.derived(variables))
            failed = replace(failed, derived=derived)
            broken = [sentence for c in self.plan.constraints for sentence in c.broken(derived)]
            if broken:
                return replace(failed, failed="; ".join(broken))
            try:
                return self._evaluate(job, derived, self._set_up(job.values, variables), clock)
            except CandidateFailed as error:
                return replace(failed, failed=str(error), seconds=clock.seconds)
            except Exception as error:
                error.add_note(f"while evaluating the candidate {dict(job.values)}")
                raise

    def _evaluate(self, job: ScoreJob, derived: dict[str, float], setup: _Setup, clock: Clock) -> Evaluation:
        for component in setup.components.values():  # before anything is rendered in vain
            if callable(lacks := getattr(component, "lacks", None)) and (reason := lacks(setup.rig)):
                raise CandidateFailed(reason)
        images = 0
        states = dict(job.states)
        if job.training is not None:
            for name in self.plan.trainable:
                states[name], rendered = self._train(name, states[name], job.training, setup, clock)
                images += rendered
        per_episode: list[Scores] = []
        for spec in job.episodes:
            scores, rendered = self._score(spec, states, setup, clock)
            per_episode.append(scores)
            images += rendered
        evaluation = Evaluation(
            values=job.values,
            derived=derived,
            episodes=tuple(per_episode),
            images=images,
            seconds=clock.seconds,
            states=states if job.training is not None else {},
        )
        return evaluation if job.partial else judged(evaluation, self.plan.fitness)

    # one candidate ----------------------------------------------------------------------------------------

    def _set_up(self, values: Mapping[str, Any], variables: Any) -> _Setup:
        overrides: dict[str, dict[str, Any]] = {}
        for name, value in values.items():
            node, _, setting = name.partition(".")
            if setting:
                overrides.setdefault(node, {})[setting] = value
        scenario = self.plan.recipe.scenario.model_copy(update=overrides.pop("scenario", {}))
        components = {
            name: self.plan.nodes[name].make(overrides[name]) if name in overrides else component
            for name, component in self._components.items()
        }
        exposure = Exposure(scenario.exposure_ms * 1e-3, scenario.f_number, scenario.gain_db)
        rig = self._rig.build(variables)
        return _Setup(rig, exposure, scenario, components, overrides, content_key(values))

    def _episode(self, scene: str, spec: EpisodeSpec, setup: _Setup) -> Episode:
        overrides = dict(setup.overrides.get(scene, {}))
        if spec.frames is not None:
            overrides["frames"] = spec.frames
        lux = setup.scenario.illumination_lux

        def make() -> Episode:
            component = self.plan.nodes[scene].make(overrides) if overrides else setup.components[scene]
            supplied = {"rng": generator(spec.seed, *spec.name, scene), "illumination_lux": lux}
            wanted = self.plan.graph.nodes[scene].signature.supplied
            return component.episode(**{name: supplied[name] for name in supplied if name in wanted})

        whole = self._episodes.get((scene, replace(spec, block=(0, 1)), lux, content_key(overrides)), make)
        return _block(whole, *spec.block)

    def _score(
        self, spec: EpisodeSpec, states: Mapping[str, State], setup: _Setup, clock: Clock
    ) -> tuple[Scores, int]:
        graph = self.plan.graph
        scores: dict[str, float] = {}
        images = 0
        for scene in graph.of_kind("scene"):
            tasks = [task for task in graph.of_kind("task") if graph.scene_of(task) == scene]
            scorers: dict[str, Scorer] = {
                task: setup.components[task].begin(state=states.get(task)) for task in tasks
            }
            with clock.of(scene):
                episode = self._episode(scene, spec, setup)
            images += len(episode) * len(setup.rig.cameras)
            for inputs in self._stream(scene, episode, spec, setup, clock, tasks):
                for task in tasks:
                    with clock.of(task), _noting(graph.nodes[task]):
                        scorers[task].update(**inputs[task])
            for task in tasks:
                with clock.of(task), _noting(graph.nodes[task]):
                    reported = scorers[task].scores()
                scores.update({f"{task}.{name}": float(value) for name, value in reported.items()})
        return scores, images

    def _train(
        self, task: str, state: State, spec: EpisodeSpec, setup: _Setup, clock: Clock
    ) -> tuple[State, int]:
        settings = self.plan.recipe.nodes[task].train
        if settings is None or settings.weights == "frozen":
            return state, 0
        scene = self.plan.graph.scene_of(task)
        spec = replace(spec, frames=settings.frames)
        with clock.of(scene):
            episode = self._episode(scene, spec, setup)
        batches = _Batches(self, scene, episode, spec, setup, clock, task)
        rng = generator(spec.seed, *spec.name, task, "fit")
        with clock.of(task), _noting(self.plan.graph.nodes[task]):
            budget = Budget(settings.epochs, settings.settings)
            return setup.components[task].fit(batches, state=state, budget=budget, rng=rng), batches.images

    def _stream(
        self,
        scene: str,
        episode: Episode,
        spec: EpisodeSpec,
        setup: _Setup,
        clock: Clock,
        tasks: Sequence[str],
    ) -> Iterator[Mapping[str, Any]]:
        def call(node: Node, inputs: Mapping[str, Any], batch: Episode) -> Any:
            with clock.of(node.name), _noting(node):
                return self._call(node, inputs, batch, spec, setup)

        yield from self.plan.graph.stream(scene, episode, batch_frames(setup.rig), call, tasks)

    def _call(
        self, node: Node, inputs: Mapping[str, Any], batch: Episode, spec: EpisodeSpec, setup: _Setup
    ) -> Any:
        crn = self.plan.recipe.study.common_random_numbers
        names = (*spec.name, node.name, batch.first_frame, *(() if crn else (setup.key,)))
        rng = generator(spec.seed, *names)
        acting = ActingEffects(
            self._effects, setup.rig, setup.exposure, generator(spec.seed, *names, "effects")
        )
        supplied = {
            "rig": setup.rig,
            "exposure": setup.exposure,
            "rng": rng,
            "effects": acting,
            "illumination_lux": setup.scenario.illumination_lux,
        }
        wanted = {name: value for name, value in supplied.items() if name in node.signature.supplied}
        if node.kind == "renderer":
            return acting.light(setup.components[node.name].capture(**inputs, **wanted))
        return acting.files(setup.components[node.name].expose(**inputs, **wanted))

    def batches(self, task: str, values: Mapping[str, Any], spec: EpisodeSpec) -> Iterator[FrameBatch]:
        """What a task of one port is given of an episode that a candidate sees, without scoring it."""
        setup = self._set_up(values, self.plan.rig_variables(values))
        scene = self.plan.graph.scene_of(task)
        episode = self._episode(scene, spec, setup)
        for inputs in self._stream(scene, episode, spec, setup, Clock(), [task]):
            (batch,) = inputs[task].values()
            yield batch

    def sample(self, job: SampleJob, position: float) -> FrameBatch:
        """One frame of the first sensor node, at a position in 0..1 along the episode."""
        graph = self.plan.graph
        sensor = graph.of_kind("sensor")[0]
        setup = self._set_up(job.values, self.plan.rig_variables(job.values))
        episode = self._episode(graph.scene_of(sensor), job.episode, setup)
        frame = round(position * (len(episode) - 1))
        batch = episode[frame : frame + 1]
        values: dict[str, Any] = {graph.scene_of(sensor): batch}
        for name in graph.order:
            node = graph.nodes[name]
            if node.kind in ("renderer", "sensor") and set(node.sources.values()) <= set(values):
                inputs = {port: values[source] for port, source in node.sources.items()}
                values[name] = self._call(node, inputs, batch, job.episode, setup)
        return values[sensor]


def _block(episode: Episode, index: int, count: int) -> Episode:
    """One of `count` nearly equal parts of an episode."""
    if count > len(episode):
        raise UserError(
            Fault(
                "study.blocks",
                f"an episode of {len(episode)} frames cannot be cut into {count} blocks",
                f"at most {len(episode)} blocks",
                "Set fewer blocks, or more frames.",
            )
        )
    start, stop = (len(episode) * i // count for i in (index, index + 1))
    return episode[start:stop] if count > 1 else episode


def batch_frames(rig: Rig) -> int:
    """How many frames go through the graph together, so that memory stays flat."""
    pixels = sum(camera.width_px * camera.height_px for camera in rig.cameras)
    return int(np.clip(BATCH_BYTES // (pixels * BYTES_PER_PIXEL), 1, 32))


@contextmanager
def _noting(node: Node) -> Iterator[None]:
    """Say in which node an error arose; the error itself stays what it is."""
    try:
        yield
    except Exception as error:
        error.add_note(f"in node {node.name!r} ({node.use})")
        raise


@dataclass(frozen=True)
class _Batches:
    """The training frames of a task; each iteration renders them anew, so that memory stays flat."""

    simulation: Simulation
    scene: str
    episode: Episode
    spec: EpisodeSpec
    setup: _Setup
    clock: Clock
    task: str
    rendered: list[int] = field(default_factory=list)

    @property
    def images(self) -> int:
        """Images rendered by all iterations so far."""
        return sum(self.rendered)

    def __iter__(self) -> Iterator[FrameBatch]:
        stream = self.simulation._stream(
            self.scene, self.episode, self.spec, self.setup, self.clock, [self.task]
        )
        for inputs in stream:
            (batch,) = inputs[self.task].values()
            self.rendered.append(len(batch.episode) * len(batch.images))
            yield batch


class ActingEffects:
    """The effects of the recipe, bound to a candidate; implements `tacos_framework.contracts.Effects`."""

    def __init__(
        self,
        effects: Sequence[tuple[Part, Any]],
        rig: Rig,
        exposure: Exposure,
        rng: np.random.Generator,
    ):
        self._effects = effects
        self._supplied = {"rig": rig, "exposure": exposure, "rng": rng}

    def _apply(self, image: Any, *stages: str, after_noise: bool) -> Any:
        for part, effect in self._effects:
            if part.cls.stage in stages and acts_after_noise(part.cls) is after_noise:
                try:
                    image = effect.apply(image, **self._supplied)
                except Exception as error:
                    error.add_note(f"in {part.use}")
                    raise
        return image

    def light(self, capture: Capture) -> Capture:
        """Effects on light on its way to the pixels."""
        return self._apply(capture, "scene", "optics", "exposure", after_noise=False)

    def pixel(self, signal: Signal) -> Signal:
        """Effects on the expected signal, before the noise."""
        return self._apply(signal, "pixel", after_noise=False)

    def readout(self, signal: Signal) -> Signal:
        """Effects on noisy samples."""
        return self._apply(signal, "pixel", "readout", after_noise=True)

    def files(self, frames: FrameBatch) -> FrameBatch:
        """Effects on digital images."""
        return self._apply(frames, "isp", "codec", after_noise=True)


def state_key(states: Mapping[str, State]) -> str:
    """Content key of the states of trainable tasks."""
    return content_key({name: {k: np.asarray(v) for k, v in state.items()} for name, state in states.items()})
