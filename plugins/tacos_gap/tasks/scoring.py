"""Scores of tasks on captures: real frames, and their simulation without and with effects."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import CandidateFailed, Rig, TaskBase, optional
from tacos_framework.formation import EpisodeDraws, PlacedEffect, frames_for
from tacos_gap.captures import RealCapture
from tacos_gap.simulation.formation import simulate
from tacos_gap.simulation.sensors import camera_of
from tacos_gap.tasks.captured_frames import TruthMissing, as_batch
from tacos_gap.tasks.recipe_tasks import RecipeTask

KINDS = ("scene", "edge", "sequence")
"""Captures that show something a task can find."""

PAIR = 2
"""Frames of a still that are scored together: tasks that match need two, and more tell nothing new."""

DRAWS_OF_STILLS, DRAWS_OF_SEQUENCES = 4, 2
"""How often the noise is drawn anew; a sequence averages over its own frames."""

Scores = Mapping[str, float]


@dataclass(frozen=True)
class CaptureScores:
    """Scores of a capture by ``node.score``, once for each pair of frames or draw of the noise."""

    capture: str
    real: tuple[Scores, ...]
    sim_before: tuple[Scores, ...]
    sim_after: tuple[Scores, ...]

    def values(self, of: str, score: str) -> NDArray[np.float64]:
        """(n,) a score of ``real``, ``sim_before`` or ``sim_after``; empty where it has no meaning."""
        return np.array([scores[score] for scores in getattr(self, of) if score in scores])


@dataclass(frozen=True)
class ScoredTasks:
    """Scores of tasks, and the reasons why some have none."""

    captures: tuple[CaptureScores, ...]  # scores of each capture that showed something
    left_out: tuple[str, ...]  # for each task that gave no score, its title and why, in a sentence

    @property
    def names(self) -> tuple[str, ...]:
        of_all = [scores for each in self.captures for scores in each.real]
        return tuple(dict.fromkeys(name for scores in of_all for name in scores))


def score_tasks(
    captures: Sequence[RealCapture],
    effects_in: Callable[[RealCapture], Sequence[PlacedEffect]],
    tasks: Sequence[RecipeTask],
    seed: int,
) -> ScoredTasks:
    """Score tasks on all captures that show something.

    Stills are scored two frames at a time, sequences whole; the simulation with as many frames each time.

    `captures`: all captures; those of even fields and boards, and those without an expectation, show nothing.
    `effects_in`: the causes in a capture, as a recipe places them.
    """
    shown = [c for c in captures if c.kind in KINDS and c.expected_dn is not None]
    why = {task.node: task.why_not for task in tasks}
    able = [task for task in tasks if not task.why_not]
    found = []
    for capture in shown:
        scored = _on_capture(capture, effects_in(capture), able, seed, why)
        if any(scored.real):
            found.append(scored)
    reported = {name.partition(".")[0] for each in found for scores in each.real for name in scores}
    left_out = [
        f"{task.title}: it is not scored, as {why[task.node] or _nothing_shown(shown)}."
        for task in tasks
        if task.node not in reported
    ]
    return ScoredTasks(tuple(found), tuple(left_out))


def _nothing_shown(shown: Sequence[RealCapture]) -> str:
    if not shown:
        return "no capture is of a scene, of edges or a sequence with an expectation"
    return "it has no score for what these captures show"


def _on_capture(
    capture: RealCapture,
    effects: Sequence[PlacedEffect],
    tasks: Sequence[RecipeTask],
    seed: int,
    why: dict[str, str],
) -> CaptureScores:
    """Every task on a capture; why one cannot be scored goes into `why`."""
    moves = capture.kind == "sequence"
    size = capture.frames if moves else min(PAIR, capture.frames)
    draws = DRAWS_OF_SEQUENCES if moves else DRAWS_OF_STILLS
    runs = [capture.real_dn[i : i + size] for i in range(0, capture.frames - size + 1, size)]
    able = [task for task in tasks if _is_able(task, capture, runs[0], why)]
    if not able:
        return CaptureScores(capture.id, (), (), ())

    def simulated(added: Sequence[PlacedEffect]) -> Iterable[NDArray[np.float32]]:
        for number in range(draws):
            yield simulate(capture, added, EpisodeDraws(seed, ("task", capture.id, number)), frames=size)

    return CaptureScores(
        capture.id,
        *(
            tuple(_scores(able, capture, stack) for stack in stacks)
            for stacks in (runs, simulated(()), simulated(effects))
        ),
    )


def _is_able(
    task: RecipeTask, capture: RealCapture, frames: NDArray[np.float32], why: dict[str, str]
) -> bool:
    lacks = optional(task.part.instance, TaskBase, "lacks")
    if callable(lacks) and (reason := lacks(Rig((camera_of(capture),)))):
        why[task.node] = f"of the captures' single camera {reason}"
        return False
    try:
        _scores([task], capture, frames[:1])
    except TruthMissing as missing:
        why[task.node] = f"{missing}, which {capture.id} does not carry"
        return False
    except Exception as error:  # noqa: BLE001 - whatever a stranger's task raises is said
        of = "" if isinstance(error, CandidateFailed) else f"it fails: {type(error).__name__}: "
        why[task.node] = f"{of}{' '.join(str(error).split())}"
        return False
    return True


def _scores(
    tasks: Sequence[RecipeTask], capture: RealCapture, frames_dn: NDArray[np.float32]
) -> dict[str, float]:
    found: dict[str, float] = {}
    batch = as_batch(capture, frames_dn)
    for task in tasks:
        scorer = task.begin()
        with task.part.calling(f"update in node {task.node!r}"):
            scorer.update(frames_for(task.part.instance, batch))
            scores = scorer.scores()
        found |= {f"{task.node}.{name}": float(value) for name, value in scores.items()}
    return found
