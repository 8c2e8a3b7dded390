"""Cost of evaluations, and reasons of the failed ones."""

from __future__ import annotations

import logging

from tacos_framework.plugins import Observers
from tacos_framework.simulation import Evaluation

log = logging.getLogger(__name__)


class Account:
    """Adds up the time of evaluations, and tells of failures.

    - `observers`: told of each candidate that failed.
    """

    def __init__(self, observers: Observers) -> None:
        self._observers = observers
        self.seconds_by_node: dict[str, float] = {}
        """Time spent in each node of the graph, over all evaluations [s]."""

    def add(self, evaluation: Evaluation) -> None:
        """Take in what came out for a candidate; a failure known from the cache is told once only."""
        for node, seconds in evaluation.seconds.items():
            self.seconds_by_node[node] = self.seconds_by_node.get(node, 0.0) + seconds
        if not evaluation.failed or evaluation.cached:
            return
        where = f"\n{evaluation.raised.traceback}" if evaluation.raised else ""
        level = logging.ERROR if where else logging.INFO
        log.log(level, "failed: %s: %s%s", dict(evaluation.values), evaluation.failed, where)
        self._observers.tell("tacos_candidate_failed", candidate=evaluation.values, reason=evaluation.failed)
