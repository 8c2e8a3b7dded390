"""Whether a study would decide otherwise in the better simulator."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tacos_framework.contracts import Executor
from tacos_framework.errors import Fault, UserError
from tacos_framework.plan import Plan, make_plan
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Recipe
from tacos_framework.recipe.loading import load_recipe
from tacos_framework.simulation import EpisodeSpec, Evaluation, Evaluator, ScoreJob
from tacos_framework.study.progress import Progress
from tacos_framework.study.search import Search
from tacos_report.comparison import half_width

DESIGNED = "designed"


@dataclass(frozen=True)
class Question:
    """A study whose decision is asked for.

    Parameters
    ----------
    study
        Its recipe: a path, or the name of a shipped one.
    change
        Keys of it to change.
    evaluations
        Evaluations of what each off-the-shelf camera leaves free.
    design
        Evaluations to design a camera with; 0 leaves it out.
    """

    study: str
    change: Mapping[str, Any]
    evaluations: int
    design: int

    def plan(self, plugins: Plugins, effects: Sequence[Mapping[str, Any]] = ()) -> Plan:
        """The checked study.

        Raises
        ------
        UserError
            When it is no study, compares no cameras, or trains a task.
        """
        recipe = load_recipe(self.study, dict(self.change), effects)
        if not isinstance(recipe, Recipe):
            raise UserError(Fault("study", f"{self.study} is no study", "a recipe that designs"))
        plan = make_plan(recipe, plugins)
        if not plan.cameras and not self.design:
            raise UserError(
                Fault("study", f"{self.study} compares no cameras", "compare: {cameras: [...]}, or design")
            )
        if plan.trainable:
            raise UserError(
                Fault("study", f"{self.study} trains a task, which takes too long here", "untrained tasks")
            )
        return plan


def decide(
    question: Question,
    effects: Sequence[Mapping[str, Any]],
    plugins: Plugins,
    executor: Executor,
    progress: Progress,
) -> dict[str, Any]:
    """Fitness of each camera on the same unseen scenes, without and with the effects.

    What a camera leaves free is optimised anew in either simulator, as a user would.
    """
    results = {}
    for name, added in (("without", ()), ("with", tuple(effects))):
        plan = question.plan(plugins, added)
        results[name] = _ranked(plan, question, plugins, executor, progress, f"Ranking cameras {name} it")
    cameras = sorted(results["without"], key=lambda camera: -_fitness(results["without"][camera]))
    rankings = {
        name: sorted(cameras, key=lambda camera: -_fitness(found[camera])) for name, found in results.items()
    }
    return {
        "study": question.study,
        "cameras": [
            {"camera": camera, **{name: found[camera].fitness for name, found in results.items()}}
            for camera in cameras
        ],
        "ranking": rankings,
        "ranking_changes": rankings["with"] != rankings["without"],
        "best_changes": rankings["with"][0] != rankings["without"][0],
        "designed": {
            name: dict(found[DESIGNED].values) for name, found in results.items() if question.design
        },
        "sentence": sentence(rankings, results["with"]),
    }


def sentence(rankings: Mapping[str, Sequence[str]], scored: Mapping[str, Evaluation]) -> str:
    """Whether the ranking changes, and whether that may be chance."""
    before, after = rankings["without"], rankings["with"]
    if before == after:
        return f"The ranking of the cameras stays: {', '.join(after)}."
    text = f"The ranking of the cameras changes, from {', '.join(before)} to {', '.join(after)}."
    if before[0] == after[0]:
        return f"{text} The best one stays the same."
    first, second = (scored[name] for name in (after[0], before[0]))
    pairs = zip(first.episodes, second.episodes, strict=False)
    differences = [a["fitness"] - b["fitness"] for a, b in pairs if "fitness" in a and "fitness" in b]
    error = half_width(differences)
    ahead = _fitness(first) - _fitness(second)
    if error is None or ahead <= error:
        return f"{text} That the best one changes may be chance: more test scenes would be needed to tell."
    return f"{text} The best one changes, by {ahead:.3f} of fitness (95 % interval ± {error:.3f})."


def _ranked(
    plan: Plan,
    question: Question,
    plugins: Plugins,
    executor: Executor,
    progress: Progress,
    title: str,
) -> dict[str, Evaluation]:
    """Every camera at its best, on the test scenes; on those of the design where there are no others."""
    searches = []
    for camera in plan.cameras:
        space = plan.space.fix([name for name in camera.fixes if name in plan.space.names])
        free = space if space.variables else None
        searches.append(Search(camera.name, plan, free, dict(camera.fixes), question.evaluations))
    if question.design:
        searches.append(Search(DESIGNED, plan, plan.space, {}, question.design))
    progress.phase(title, None)
    evaluate = Evaluator(plan.recipe, plugins)
    for search in searches:
        while not search.stopped:
            search.step(executor, evaluate, progress.evaluated)
        search.rescore_finalists(executor, evaluate, progress.evaluated)
        progress.step(search.name)
    found = {search.name: search.best for search in searches if search.best is not None}
    test = plan.recipe.test
    if test is not None:
        episodes = tuple(EpisodeSpec(test.seed, ("test", i), test.frames) for i in range(test.episodes))
        jobs = [ScoreJob(best.values, episodes) for best in found.values()]
        found = dict(zip(found, executor.map(evaluate, jobs), strict=True))
    lost = {search.name: Evaluation({}, failed="no candidate could be scored") for search in searches}
    return {**lost, **found}


def _fitness(evaluation: Evaluation) -> float:
    return float("-inf") if evaluation.fitness is None else evaluation.fitness
