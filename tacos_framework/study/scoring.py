"""Scoring the candidates of a generation in a race: block by block, fewer of them each time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from tacos_framework.contracts import Executor
from tacos_framework.errors import Fault, UserError
from tacos_framework.recipe import RaceSettings, Recipe
from tacos_framework.simulation import Evaluation, Evaluator, ScoreJob, merged_evaluation
from tacos_framework.study.racing import Race


def score_in_a_race(
    jobs: Mapping[str, ScoreJob],
    rivals: Mapping[str, Evaluation],
    rules: RaceSettings,
    executor: Executor,
    evaluate: Evaluator,
) -> list[Evaluation]:
    """Score candidates until each has seen all blocks or was dropped.

    Parameters
    ----------
    jobs
        What scoring each candidate on all blocks would be, by key; all on the same blocks.
    rivals
        Candidates known from before that have seen these very blocks, all of them.
    rules
        When a candidate is dropped.

    Returns
    -------
    One evaluation for each job, in their order. One that was dropped has its scores on the blocks it saw,
    says so in `Evaluation.dropped`, and has the fitness that `Race.fitness_of_dropped` gives.
    """
    race = Race(evaluate.plan.fitness, rules.standard_errors, rules.min_blocks)
    for key, rival in rivals.items():
        race.saw(key, rival.blocks)
    found: dict[str, list[Evaluation]] = {key: [] for key in jobs}
    running = list(jobs)
    blocks = len(next(iter(jobs.values())).episodes) if jobs else 0
    first = 0
    while running and first < blocks:
        last = min(rules.min_blocks, blocks) if first == 0 else first + 1
        heat = [_part(jobs[key], first, last, found[key]) for key in running]
        for key, evaluation in zip(list(running), executor.map(evaluate, heat), strict=True):
            found[key].append(evaluation)
            if evaluation.failed:
                race.withdraw(key)
                running.remove(key)
            else:
                race.saw(key, evaluation.blocks)
        if last < blocks:
            out = race.drop()
            running = [key for key in running if key not in out]
        first = last
    return _outcomes(found, race, rivals)


def _part(job: ScoreJob, first: int, last: int, before: Sequence[Evaluation]) -> ScoreJob:
    """The part of a job that is about some of its blocks; training comes with the first."""
    part = replace(job, episodes=job.episodes[first:last], partial=True)
    return replace(part, states=before[0].states or job.states, training=None) if before else part


def _outcomes(
    found: Mapping[str, Sequence[Evaluation]], race: Race, rivals: Mapping[str, Evaluation]
) -> list[Evaluation]:
    """One evaluation for each candidate, of all blocks it saw."""
    whole = {key: merged_evaluation(parts, race.fitness) for key, parts in found.items()}
    complete = {key: e.fitness for key, e in whole.items() if key not in race.dropped}
    complete |= {key: e.fitness for key, e in rivals.items()}
    dropped = race.fitness_of_dropped(
        {key: fitness for key, fitness in complete.items() if fitness is not None}
    )
    return [
        replace(e, fitness=dropped.get(key, e.fitness), dropped=str(race.dropped[key]))
        if key in race.dropped
        else e
        for key, e in whole.items()
    ]


def refuse_race_of_parts(recipe: Recipe, optimizer: str, numbers: Sequence[int]) -> None:
    """Refuse a recipe with a race whose optimizer has a candidate scored on some of the episodes only.

    Raises
    ------
    UserError
        Where the recipe has a race.
    """
    if recipe.study.race is None:
        return
    fault = Fault(
        recipe.where(("study", "race")),
        f"candidates cannot race: {optimizer} asks for one to be scored on episodes "
        f"{', '.join(map(str, numbers))} only",
        "an optimizer that has all candidates scored on all episodes",
        "Take study.race out, or set the optimizer to score candidates on all episodes.",
    )
    raise UserError(fault)
