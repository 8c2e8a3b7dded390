"""What a detector learns from few worlds, from many, and on the camera that won: precision in unseen worlds.

The small detector of the joint headset study goes on from its shipped weights, with that study's settings::

    OMP_NUM_THREADS=1 python benchmarks/training_worlds.py

It takes a quarter of an hour of one core.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from tacos_framework import Budget, FrameBatch, Plugins, Recipe, State, load_recipe
from tacos_framework.plan import Plan, make_plan
from tacos_framework.simulation import EpisodeSpec, Simulation

RECIPE, TASK = "headset_joint_quick", "detect"
CAMERA, PITCH_DEG = "oak_d_pro_wide", -5.0
TRAINING_FRAMES, TEST_FRAMES = 32, 24
FEW = 5
TrainingSet = Sequence[FrameBatch]


class School:
    """One detector, and the frames it can be taught and examined with."""

    def __init__(self, plan: Plan, worlds: int, exams: int):
        self._plan, self._simulation = plan, Simulation(plan)
        self._task: Any = plan.nodes[TASK].make()
        self._train = plan.recipe.nodes[TASK].train
        camera = next(camera for camera in plan.cameras if camera.name == CAMERA)
        chosen = {**camera.fixes, "pitch_deg": PITCH_DEG}
        self.own = [self._frames(chosen, ("own", i), TRAINING_FRAMES) for i in range(worlds)]
        self.others = [self._frames(c, ("other", i), TRAINING_FRAMES) for i, c in self._cameras(worlds)]
        self._exams = [self._frames(chosen, ("exam", i), TEST_FRAMES) for i in range(exams)]
        self.state: State = self._simulation.initial_states()[TASK]
        self._before = self._examined(self.state)

    def _frames(self, values: Mapping[str, Any], name: tuple[Any, ...], frames: int) -> TrainingSet:
        spec = EpisodeSpec(self._plan.recipe.seed, name, frames)
        return list(self._simulation.batches(TASK, values, spec))

    def _cameras(self, count: int) -> Iterator[tuple[int, Mapping[str, Any]]]:
        """Cameras from all over the design space that keep to its constraints."""
        rng, found = np.random.default_rng(self._plan.recipe.seed), 0
        rig = self._plan.rig.make()
        while found < count:
            values = self._plan.space.sample(rng).as_dict()
            derived = rig.derived(self._plan.rig_variables(values))
            if not self._plan.breaches(values, derived):
                yield found, values
                found += 1

    def teach(self, state: State, sets: Iterable[TrainingSet], times: int = 1) -> State:
        """Train on each set in turn, as candidates of a study do, `times` over before the next."""
        budget = Budget(self._train.epochs, self._train.settings)
        for number, frames in enumerate(sets):
            for again in range(times):
                rng = np.random.default_rng((number, again))
                state = self._task.fit(frames, state=state, budget=budget, rng=rng)
        return state

    def _examined(self, state: State) -> np.ndarray:
        """Average precision in each unseen world; nan where nothing is to be seen."""
        precisions = []
        for exam in self._exams:
            scorer = self._task.begin(state=state)
            for frames in exam:
                scorer.update(frames)
            precisions.append(scorer.scores().get("ap50", math.nan))
        return np.array(precisions)

    def report(self, title: str, state: State) -> None:
        """Print how precise it has become."""
        now = self._examined(state)
        gains = (now - self._before)[np.isfinite(now)]
        error = gains.std(ddof=1) / math.sqrt(len(gains))
        print(f"{title:<62} {np.nanmean(now):6.3f} {gains.mean():+7.3f} +- {error:.3f}", flush=True)


def main() -> None:
    """Teach in several ways and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--worlds", type=int, default=20)
    parser.add_argument("--exams", type=int, default=16)
    parser.add_argument("--on-the-best", type=int, default=8)
    arguments = parser.parse_args()
    recipe = load_recipe(RECIPE)
    assert isinstance(recipe, Recipe)
    school = School(make_plan(recipe, Plugins.discover()), arguments.worlds, arguments.exams)
    worlds, few, best = arguments.worlds, FEW, arguments.on_the_best
    print(f"{'':<62} {'AP':>6} {'gain':>7}")
    school.report("as shipped", school.state)
    repeated = school.teach(school.state, school.own[:few], worlds // few)
    school.report(f"{worlds} trainings with this camera, in {few} worlds", repeated)
    renewed = school.teach(school.state, school.own)
    school.report(f"{worlds} trainings with this camera, in {worlds} worlds", renewed)
    mixed = school.teach(school.state, school.others)
    school.report(f"{worlds} trainings with other cameras, in {worlds} worlds", mixed)
    school.report(f"these, then {best} with this camera", school.teach(mixed, school.own[:best]))
    alone = school.teach(school.state, school.own[:best])
    school.report(f"{best} with this camera alone", alone)


if __name__ == "__main__":
    main()
