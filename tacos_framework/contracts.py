"""The contract of each kind of component, one Protocol a kind.

Positional parameters are input ports, the return annotation is the output port, and keyword-only parameters
are what the framework supplies: a component asks for those it needs and leaves out the rest.

=================  ====================================================================================
keyword            what the framework supplies
=================  ====================================================================================
rng                `numpy.random.Generator`, spawned by name from the study's seed
rig                the `Rig` of the candidate
exposure           the `Exposure` of the scenario
illumination_lux   illuminance of the scenario [lux]
effects            the recipe's effects of the stages pixel and readout, for sensors (`Effects`)
state              the state of a trainable task
budget             how much to train (`Budget`)
=================  ====================================================================================

Every component class has a ``Config`` (`tacos_framework.settings.Settings`) and is built as
``Class(Class.Config(...))``; optimizers take the design space and a generator beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, Protocol, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from tacos_framework.settings import Settings
from tacos_framework.values import (
    Capture,
    Episode,
    Exposure,
    FrameBatch,
    ImageContext,
    ImageGeometry,
    Rig,
    Signal,
)

Scores = Mapping[str, float]
"""Named numbers of one episode. A score without meaning there (no obstacle on the path) is left out."""

State = Mapping[str, NDArray[Any]]
"""What a trainable task has learnt: named arrays, so that it can be kept without pickle."""

Stage = Literal["scene", "optics", "exposure", "pixel", "readout", "isp", "codec"]
"""Where in image formation an effect acts; the noise lies between pixel and readout."""

STAGES: tuple[Stage, ...] = get_args(Stage)
"""The stages in the order of image formation."""


@dataclass(frozen=True)
class Budget:
    """How much to train: passes over the batches, and settings of the recipe's ``train:``.

    Where ``told`` is given, a task may tell it the losses of each step, by name.
    """

    epochs: int = 1
    settings: Mapping[str, Any] | None = None
    told: Callable[[Mapping[str, float]], None] | None = None


class Scene(Protocol):
    """Makes worlds and the agent's trips through them."""

    Config: ClassVar[type[Settings]]

    def episode(self, *, rng: np.random.Generator, illumination_lux: float) -> Episode:
        """One trip; the same generator state gives the same episode, always.

        Illuminance is the mean on a horizontal plane 1 m above the floor (or ground) [lux].
        """
        ...


class RigBuilder(Protocol):
    """Turns design variables into cameras.

    ``Variables`` is a `Settings` class whose fields are what a recipe may design or fix; fields without a
    default must be given by the recipe, as a design variable or as a fixed value under ``rig:``.
    """

    Config: ClassVar[type[Settings]]
    Variables: ClassVar[type[Settings]]
    derived_quantities: ClassVar[Mapping[str, str]]  # name -> unit, for constraints and reports

    def build(self, variables: Settings) -> Rig:
        """The rig for values of the variables, an instance of ``Variables``."""
        ...

    def derived(self, variables: Settings) -> Mapping[str, float]:
        """The derived quantities of these variables, cheaply: nothing is rendered."""
        ...


class Renderer(Protocol):
    """Gives the light that reaches each pixel, and the truth behind it.

    ``reads`` names the fields of `Camera` and `Exposure` its output depends on: candidates that agree in
    them may share a capture.
    """

    Config: ClassVar[type[Settings]]
    reads: ClassVar[frozenset[str]]

    def capture(self, episode: Episode, *, rig: Rig, exposure: Exposure) -> Capture:
        """One view per camera of the rig for every frame of the batch."""
        ...


Image = TypeVar("Image", Capture, Signal, FrameBatch)


class Effect(Protocol[Image]):
    """One physical effect of a real camera.

    ``neutral`` gives, for each parameter, the value at which the effect is exactly off. Effects of the
    stages scene, optics and exposure change a `Capture`; pixel and readout a `Signal`; isp and codec a
    `FrameBatch`.

    The physics of an effect stands in `on_array`, on plain arrays, and `apply` brings it to the views of a
    capture, signal or batch; the diagnosis of real captures calls `on_array` itself. At the neutral values
    both hand on the very object they were given.

    Further members are optional:

    ``after_noise: ClassVar[bool]``
        True for an effect of the stage pixel that acts on noisy samples: electrons that are lost or shared
        once they are counted. It then follows the noise, ahead of the effects of the stage readout.
    ``rank: ClassVar[int]``
        The order within a stage, lower first; 0 by default. Equal ranks act in the recipe's order.
    ``photon_scale: float``
        Factor on the variance of the photon noise, for an effect that changes the noise and not the signal.
    ``probes: ClassVar[Sequence[Mapping[str, Any]]]``
        Severities met in the field, where a diagnosis begins its search; parameters given as floats are then
        fitted. An effect without is tried a little to either side of neutral, one with ``()`` only where the
        captures point to it.
    ``plausible: bool``
        False for settings that no camera has, as a lens that brightens its corners. Recipes may have them, a
        diagnosis does not propose them.
    ``source(geometry)``
        For an effect that only moves pixels: (H, W) columns and rows where each pixel of the image looks in
        the image without it.
    ``moments(mean_dn, variance_dn2, *, geometry, context)``
        Mean and variance of the noise after the effect, from those before it, where a closed form exists; so
        that a diagnosis need not draw samples. Both are arrays of the shape (N, H, W, C), or flat fields that
        broadcast to it.
    """

    Config: ClassVar[type[Settings]]
    stage: ClassVar[Stage]
    neutral: ClassVar[Mapping[str, Any]]

    def apply(self, image: Image, *, rig: Rig, exposure: Exposure, rng: np.random.Generator) -> Image:
        """The image with the effect."""
        ...

    def on_array(
        self,
        signal: NDArray[Any],
        *,
        geometry: ImageGeometry,
        context: ImageContext,
        rng: np.random.Generator,
    ) -> NDArray[Any]:
        """Samples with the effect.

        Parameters
        ----------
        signal
            (N, H, W, C) float32 or float64 frames of one camera, C = 1 or 3; left as they are. For the
            stages scene, optics and exposure light in any linear unit, 0 is darkness; for pixel and readout
            samples with the pedestal, neither rounded nor clipped [DN]; for isp and codec the values of the
            file [DN].
        geometry
            Where the pixels lie on the sensor.
        context
            What else is known; `ContextMissing` is raised where it is not enough for these settings.
        rng
            Draws what is random.

        Returns
        -------
        Same shape and dtype.
        """
        ...


def acts_after_noise(effect: type[Any]) -> bool:
    """Whether an effect acts on noisy samples, which correlates noise, rather than on expected light."""
    return getattr(effect, "after_noise", False) or STAGES.index(effect.stage) > STAGES.index("pixel")


def formation_order(effect: type[Any]) -> tuple[int, bool, int]:
    """Where an effect class stands in image formation: sort effects by it, and each acts at its place.

    Whatever order a recipe or a diagnosis lists effects in, white balance then comes before the tone curve.
    """
    return STAGES.index(effect.stage), acts_after_noise(effect), getattr(effect, "rank", 0)


class Effects(Protocol):
    """The effects of a recipe that act inside the sensor; the sensor calls each stage at its place."""

    def pixel(self, signal: Signal) -> Signal:
        """Apply the effects on the expected signal, before the noise."""
        ...

    def readout(self, signal: Signal) -> Signal:
        """Apply the effects on noisy samples, before rounding: of the pixel, then of the readout."""
        ...


class Sensor(Protocol):
    """Turns light into digital images, with noise.

    A further member is optional:

    ``lacks(rig) -> str | None``
        What the sensor would have to know of a rig's cameras and does not, in a sentence. A recipe none of
        whose cameras it can serve is refused with it; a candidate it cannot serve fails.
    """

    Config: ClassVar[type[Settings]]

    def expose(
        self,
        capture: Capture,
        *,
        rig: Rig,
        exposure: Exposure,
        rng: np.random.Generator,
        effects: Effects,
    ) -> FrameBatch:
        """The frames of a batch; black and white level are those of the files."""
        ...


class Scorer(Protocol):
    """Scores one episode, batch by batch. The positional parameters of `update` are the task's ports."""

    def update(self, frames: FrameBatch) -> None:
        """Take in the next batch; batches come in order and do not overlap."""
        ...

    def scores(self) -> Scores:
        """The scores of all that was taken in; at least those named in ``Task.scores`` that have meaning."""
        ...


class Task(Protocol):
    """A perception task. ``scores`` names what its scorers report.

    Further members are optional:

    ``lacks(rig) -> str | None``
        Why it cannot judge a rig's cameras, in a sentence; used as that of a `Sensor`.
    ``lower_is_better: ClassVar[frozenset[str]]``
        Those of the scores that are errors, of which reports call the smallest best. Of the others higher is
        better.
    """

    Config: ClassVar[type[Settings]]
    scores: ClassVar[tuple[str, ...]]

    def begin(self, *, state: State | None) -> Scorer:
        """A scorer for one episode; `state` is None for tasks that do not learn."""
        ...


class Trainable(Protocol):
    """A task that learns. State goes in and comes out; the object itself keeps none.

    A further member is optional:

    ``Training: ClassVar[type[Settings]]``
        The settings it takes from the recipe's ``train:`` through `Budget.settings`; those given are then
        checked with the recipe, before anything is computed.
    """

    scores: ClassVar[tuple[str, ...]]

    def begin(self, *, state: State | None) -> Scorer:
        """A scorer that uses `state`."""
        ...

    def initial_state(self, *, rng: np.random.Generator) -> State:
        """The state before any training of this study."""
        ...

    def fit(
        self, batches: Iterable[FrameBatch], *, state: State, budget: Budget, rng: np.random.Generator
    ) -> State:
        """A new state, trained on the batches; `state` itself is left as it was."""
        ...


def learns(task: type[Any]) -> bool:
    """Whether a task class is `Trainable`."""
    return callable(getattr(task, "fit", None)) and callable(getattr(task, "initial_state", None))


@dataclass(frozen=True)
class Evaluated:
    """A candidate and its fitness, higher is better; None when it failed or breaks a constraint."""

    candidate: Any  # tacos_framework.design_space.Candidate
    fitness: float | None


class Optimizer(Protocol):
    """The derivative-free side: ``Class(config, space=space, rng=rng)``, then ask and tell until stop."""

    Config: ClassVar[type[Settings]]

    @property
    def expected_candidates(self) -> int | None:
        """How many candidates it will ask for in all, for progress bars; None when it cannot tell."""
        ...

    def ask(self) -> list[Any]:
        """The next candidates, snapped to the space; never empty before `stop` gives a reason."""
        ...

    def tell(self, evaluated: Sequence[Evaluated]) -> None:
        """The results of exactly the candidates last asked, in their order."""
        ...

    def stop(self) -> str | None:
        """Why there is nothing more to ask, in a sentence; None to go on."""
        ...

    def state(self) -> dict[str, Any]:
        """All that is needed to go on, as JSON values, generator included."""
        ...

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from a `state`; equal to never having stopped."""
        ...


Job = TypeVar("Job")
Result = TypeVar("Result")


class Executor(Protocol):
    """Runs evaluations, here or elsewhere.

    A further member is optional:

    ``workers: int``
        How many jobs it runs at a time; work is cut into as many parts. 1 where it does not say.
    """

    Config: ClassVar[type[Settings]]

    def map(self, evaluate: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[Result]:
        """The results in the order of the jobs, each as soon as it and those before it are there.

        `evaluate` can be pickled and keeps costly things (GL context, worlds) between calls in the process
        it runs in. An exception it raises comes out of the iterator unchanged. Where a process dies or hangs
        on a job whenever it is tried, the result is ``evaluate.lost(job, reason)`` if `evaluate` has that.
        """
        ...

    def close(self) -> None:
        """Let go of all workers; safe to call twice."""
        ...


class Procedure(Protocol):
    """What a recipe may run that is not a study: a calibration, a validation, a comparison, a diagnosis.

    Its recipe has ``use: procedure.NAME`` at the top, and the settings of its ``Config`` beside it. Of the
    keywords of `run` a procedure asks for those it needs; one that asks for `resume` can go on where a
    broken run stopped.

    ========  =============================================================================================
    out       the results folder, `pathlib.Path`, there and empty (with `resume`: that of the broken run)
    seed      seed of the recipe
    plugins   the installed `Plugins`, to resolve other components
    executor  the recipe's `Executor`, for work that can be shared out
    progress  the `Progress` to tell: ``phase(title, steps)``, then ``step()`` for each
    resume    whether to go on with a broken run
    ========  =============================================================================================
    """

    Config: ClassVar[type[Settings]]

    def run(
        self, *, out: Any, seed: int, plugins: Any, executor: Executor, progress: Any, resume: bool
    ) -> Mapping[str, Any]:
        """Do it. Pictures and ``report.html`` go into `out`; what is returned becomes ``result.json``.

        The entry ``summary`` of the result is a text in a few lines, which ``tacos-run`` prints.
        """
        ...


PROTOCOLS: Mapping[str, type[Any]] = {
    "scene": Scene,
    "rig": RigBuilder,
    "renderer": Renderer,
    "effect": Effect,
    "sensor": Sensor,
    "task": Task,
    "optimizer": Optimizer,
    "executor": Executor,
    "procedure": Procedure,
}

VERBS: Mapping[str, tuple[str, ...]] = {
    "scene": ("episode",),
    "rig": ("build", "derived"),
    "renderer": ("capture",),
    "effect": ("apply",),
    "sensor": ("expose",),
    "task": ("begin",),
    "optimizer": ("ask", "tell", "stop", "state", "restore"),
    "executor": ("map", "close"),
    "procedure": ("run",),
}
"""The methods a component of each kind must have."""
