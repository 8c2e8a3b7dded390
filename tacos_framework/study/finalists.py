"""The most promising candidates of every search, scored once more: those of all searches at the same time."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from tacos_framework.contracts import Executor
from tacos_framework.simulation import Evaluation, Evaluator
from tacos_framework.study.search import Search
from tacos_framework.study.shards import score_sharded


def rescore_finalists(
    searches: Sequence[Search],
    executor: Executor,
    evaluate: Evaluator,
    on_counted: Callable[[int], None],
    on_evaluated: Callable[[Evaluation], None],
) -> None:
    """Score the finalists of each search that has ended; `Search.best` is then the best of them.

    A search alone may have one finalist and one world to see it in, which leaves all workers but one idle.

    Parameters
    ----------
    searches
        Those whose finalists are scored already are left as they are.
    executor, evaluate
        Run the jobs.
    on_counted
        Told how many there are to score, if any, before the first.
    on_evaluated
        Told each evaluation as it comes.
    """
    ended = [search for search in searches if not search.finalists_rescored]
    jobs = [search.finalist_jobs() for search in ended]
    every = [job for of_search in jobs for job in of_search]
    if every:
        on_counted(len(every))
    places = [place for place, of_search in enumerate(jobs) for _ in of_search]
    found: list[list[Evaluation]] = [[] for _ in ended]
    for place, evaluation in zip(places, score_sharded(every, executor, evaluate), strict=True):
        found[place].append(evaluation)
        on_evaluated(evaluation)
    for search, finalists in zip(ended, found, strict=True):
        search.choose_among(finalists)
