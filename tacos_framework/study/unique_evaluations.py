"""Evaluating candidates that do not hand on what they learn: each once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace

from tacos_framework.cache import content_key
from tacos_framework.contracts import Executor
from tacos_framework.simulation import Evaluation, Evaluator, ScoreJob, state_key
from tacos_framework.study.shards import score_sharded


def job_keys(jobs: Sequence[ScoreJob]) -> list[str]:
    """Content keys of jobs that start with the same states."""
    weights = state_key(jobs[0].states) if jobs else ""
    return [_key(job, weights) for job in jobs]


def _key(job: ScoreJob, weights: str) -> str:
    specs = [asdict(spec) for spec in job.episodes]
    return content_key(job.values, specs, weights, job.training and asdict(job.training))


def evaluate_each_once(
    wanted: Sequence[ScoreJob],
    known: Mapping[str, Evaluation],
    executor: Executor,
    evaluate: Evaluator,
    on_evaluated: Callable[[Evaluation], None],
) -> tuple[list[Evaluation], dict[str, Evaluation]]:
    """Evaluate what has not been evaluated before in exactly this way, each thing once.

    `known`: evaluations of before, by the keys of their jobs.

    Returns: the evaluations in the order wanted, and those of them that are new, by the keys of their jobs.
    """
    keys = job_keys(wanted)
    jobs = {key: job for key, job in zip(keys, wanted, strict=True) if key not in known}
    fresh: dict[str, Evaluation] = {}
    for key, evaluation in zip(jobs, score_sharded(list(jobs.values()), executor, evaluate), strict=True):
        fresh[key] = evaluation
        on_evaluated(evaluation)
    evaluations, given = [], set()
    for key in keys:
        if key in fresh and key not in given:
            evaluations.append(fresh[key])
        else:
            again = replace(fresh.get(key) or known[key], cached=True, images=0, seconds={})
            evaluations.append(again)
            on_evaluated(again)
        given.add(key)
    return evaluations, fresh
