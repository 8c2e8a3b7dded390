"""The most promising candidates of every search, scored once more: those of all searches at the same time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from tacos_framework.contracts import Executor
from tacos_framework.plan import Plan
from tacos_framework.plan.feasibility import derived_of
from tacos_framework.simulation import Evaluation, Evaluator
from tacos_framework.study.problem import broken_by
from tacos_framework.study.search import Search
from tacos_framework.study.shards import score_sharded


def rescore_finalists(
    searches: Sequence[Search],
    executor: Executor,
    evaluate: Evaluator,
    on_counted: Callable[[int], None],
    on_evaluated: Callable[[Evaluation], None],
    *,
    tested: bool = False,
) -> None:
    """Score the finalists of each search that has ended; `Search.best` is then the best of them.

    A search alone may have one finalist and one world to see it in, which leaves all workers but one idle.

    - `searches`: those whose finalists are scored already are left as they are.
    - `on_counted`: told how many there are to score, if any, before the first.
    - `on_evaluated`: told each evaluation as it comes.
    - `tested`: whether a test scores the best of each search, on more episodes. The only finalist there is,
      is then the best without more ado.
    """
    ended, jobs = [], []
    for search in searches:
        if search.finalists_rescored:
            continue
        wanted = search.finalist_values()
        if len(wanted) == 1 and tested and (known := _unscored(search.plan, wanted[0])):
            search.choose_unscored(known)
            continue
        ended.append(search)
        jobs.append(search.finalist_jobs(wanted))
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


def _unscored(plan: Plan, values: Mapping[str, Any]) -> Evaluation | None:
    """A camera without scores; None where it breaks a constraint, or its rig refuses it."""
    derived = derived_of(plan, values)
    if derived is None or broken_by(plan, values):
        return None
    return Evaluation(values, derived)
