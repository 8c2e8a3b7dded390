"""From a finished study to the record that analyses are given."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

from tacos_framework.plan import Plan
from tacos_framework.simulation import Evaluation
from tacos_framework.study.problem import broken_by, coordinates_of, design_problem
from tacos_framework.study.record import ScoredEpisode, StudiedCamera, StudyRecord, Values
from tacos_framework.study.search import Search
from tacos_framework.study.unseen_test import UnseenTest


def make_record(
    plan: Plan,
    searches: Sequence[Search],
    lines: Iterable[Mapping[str, Any]],
    test: UnseenTest | None,
    failed: Mapping[str, str],
    score: Callable[[Sequence[Values], int], list[Evaluation]],
    degenerate: str | None,
) -> StudyRecord:
    """The record of a study, for analyses.

    - `searches`: that of the designed camera first.
    - `lines`: the generations of all searches, as the results folder has them.
    - `test`: what came out on the test scenes; None where the recipe has none.
    - `failed`: cameras of which no candidate could be scored, and why in a sentence.
    - `score`: scores plain values on so many fresh episodes.
    - `degenerate`: why no winner may be named, in a sentence; None where one may.
    """
    designed = searches[0]
    titles = {camera.name: camera.title for camera in plan.cameras}
    renew = plan.recipe.study.renew_episodes == "each_generation"

    def score_episodes(cameras: Sequence[Values], count: int) -> list[list[ScoredEpisode]]:
        found = score(cameras, count)
        return [list(_of_evaluation(each, "analysis", "analysis", designed.generation)) for each in found]

    episodes = list(_of_lines(lines, renew))
    for search in searches:
        for final in search.finalists:
            name = f"final/{search.generation if renew else 0}"
            episodes += _of_evaluation(final, name, "final", search.generation)
    for tested in test.scored.values() if test else ():
        episodes += _of_evaluation(tested, "test", "test", designed.generation)
    return StudyRecord(
        recipe=plan.recipe,
        space=plan.space,
        problem=design_problem(plan, weights_learn=designed.training),
        designed=designed.name,
        cameras=tuple(
            StudiedCamera(
                search.name,
                titles.get(search.name, "Designed"),
                search.best.values if search.best else None,
                search.space.names if search.space else (),
            )
            for search in searches
        ),
        episodes=tuple(episodes),
        derived=plan.derived,
        coordinates=partial(coordinates_of, plan),
        broken=partial(broken_by, plan),
        unknown=lambda values: plan.unknown(values, plan.derived(values)),
        score=score_episodes,
        comparisons=test.comparisons if test else {},
        failed={**failed, **(test.failed if test else {})},
        degenerate=degenerate,
        objectives=plan.objectives,
    )


def _of_lines(lines: Iterable[Mapping[str, Any]], renew: bool) -> Iterator[ScoredEpisode]:
    """Scored candidates of the searches; known ones stand there once."""
    for line in lines:
        generation = line["generation"]
        for candidate in line["candidates"]:
            if candidate["cached"]:
                continue
            for number, scores in candidate["episodes"].items():
                name = f"design/{generation if renew else 0}/{number}"
                yield ScoredEpisode(candidate["camera"], name, scores, "design", generation)


def _of_evaluation(evaluation: Evaluation, name: str, stage: Any, generation: int) -> Iterator[ScoredEpisode]:
    for number, scores in enumerate(evaluation.blocks):
        plain = {key: value for key, value in scores.items() if key.rpartition("/")[2] != "fitness"}
        yield ScoredEpisode(evaluation.values, f"{name}/{number}", plain, stage, generation)
