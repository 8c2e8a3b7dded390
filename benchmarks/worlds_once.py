"""How often worlds are built and lit when a few cameras are scored on several scenes by two workers.

OMP_NUM_THREADS=1 python benchmarks/worlds_once.py --cameras 4 --scenes 4

Before, a job was a camera on all scenes, and every worker built every world; now a job is a camera in one
world and says so, and a worker is given jobs of the worlds it has. Then the same with a
store on disk, empty and full. Results are compared, too.
"""

from __future__ import annotations

import argparse
import os
import resource
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from tempfile import TemporaryDirectory

from tacos_framework import Evaluation, Plugins, load_recipe
from tacos_framework.plan import make_plan
from tacos_framework.simulation import EpisodeSpec, Evaluator, ScoreJob
from tacos_framework.study import score_sharded
from tacos_plugins.executors.process import ProcessExecutor
from tacos_plugins.kept_worlds.store import FOLDER_VARIABLE


@dataclass(frozen=True)
class WithoutAffinity:
    """A job that does not say which world it needs."""

    job: ScoreJob

    def run(self, simulation) -> Evaluation:  # type: ignore[no-untyped-def]
        """Do it."""
        return self.job.run(simulation)


def main() -> None:
    """Score the same cameras both ways."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--cameras", type=int, default=4)
    parser.add_argument("--scenes", type=int, default=4)
    parser.add_argument("--frames", type=int, default=4)
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()

    recipe = load_recipe("headset_quick", {"study.episodes": arguments.scenes})
    plan = make_plan(recipe, Plugins.discover())
    episodes = tuple(EpisodeSpec(1, ("scene", i), arguments.frames) for i in range(arguments.scenes))
    product = plan.cameras[0].fixes
    jobs = [ScoreJob({**product, "pitch_deg": -5.0 * i}, episodes) for i in range(arguments.cameras)]

    workers = arguments.workers

    def before(executor: ProcessExecutor, evaluate: Evaluator) -> Iterator[Evaluation]:
        return executor.map(evaluate, [WithoutAffinity(job) for job in jobs])  # type: ignore[list-item]

    def now(executor: ProcessExecutor, evaluate: Evaluator) -> Iterator[Evaluation]:
        return score_sharded(jobs, executor, evaluate)  # type: ignore[arg-type]

    with TemporaryDirectory() as folder:
        found = []
        for way, store in ((before, "off"), (now, "off"), (now, folder), (now, folder)):
            os.environ[FOLDER_VARIABLE] = store
            found.append(measured(way, Evaluator(recipe), workers))
    same = [[e.fitness for e in evaluations] for evaluations in found]
    assert all(evaluation.failed is None for evaluations in found for evaluation in evaluations)
    print("the same fitness" if all(each == same[0] for each in same) else f"other fitness: {same}")


def measured(
    way: Callable[[ProcessExecutor, Evaluator], Iterator[Evaluation]], evaluate: Evaluator, workers: int
) -> Sequence[Evaluation]:
    """The evaluations, and on the terminal what they cost."""
    executor = ProcessExecutor(ProcessExecutor.Config(workers=workers))
    began, spent_s = time.monotonic(), processor_s()
    evaluations = list(way(executor, evaluate))
    executor.close()
    world_s = sum(evaluation.seconds.get("world", 0.0) for evaluation in evaluations)
    print(
        f"{way.__name__:8} {time.monotonic() - began:6.1f} s by the clock, "
        f"{processor_s() - spent_s:6.1f} s of processor time, {world_s:6.1f} s building worlds"
    )
    return evaluations


def processor_s() -> float:
    """Processor time of the workers that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    main()
