"""Ends a study in which candidates fail one after the other by the same defect."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from tacos_framework.errors import UserError
from tacos_framework.simulation import Evaluation

IN_A_ROW = 5
"""Candidates that raise the same type of error in the same component, one after the other, end a study."""

FEWEST = 3
"""Where the first generation is smaller than `IN_A_ROW`, as many as it has, but no fewer than these."""


MOST_ALIKE = 20
"""Where so many candidates in a row fail for one reason and none was ever scored, the search ends."""

_NUMBER = re.compile(r"[-+]?\d[\d.]*(e[-+]?\d+)?")


def alike(reason: str | None, other: str | None) -> bool:
    """True if two reasons are the same but for the numbers in them."""
    return _NUMBER.sub("#", reason or "") == _NUMBER.sub("#", other or "")


class KeepsFailing(Exception):
    """Candidates fail one after the other by the same defect of a component; the message says which.

    ``evaluations`` are those of the generation that is broken off, as far as it has come.
    """

    evaluations: Sequence[Evaluation] = ()


@dataclass
class FailuresInARow:
    """Counts the candidates that failed by the same defect, one after the other.

    Those that break a constraint, or that a component refuses, tell nothing of the defect and are passed
    over; so are evaluations known from before.
    """

    count: int = 0
    component: str = ""
    kind: str = ""

    def saw(self, evaluation: Evaluation, limit: int = IN_A_ROW) -> None:
        """Take in the next evaluation.

        Raises `KeepsFailing` when it is one too many: the first, where what the user gave is wrong, as all
        candidates meet it.
        """
        raised = evaluation.raised
        if evaluation.cached or (evaluation.failed and raised is None):
            return
        if raised is None:
            self.count, self.component, self.kind = 0, "", ""
            return
        if raised.kind == UserError.__name__:
            raise KeepsFailing(
                f"what the recipe names is at fault, and no candidate: {evaluation.failed}; once it is "
                "mended, --resume goes on"
            )
        if (raised.component, raised.kind) != (self.component, self.kind):
            self.count, self.component, self.kind = 0, raised.component, raised.kind
        self.count += 1
        if self.count >= limit:
            raise KeepsFailing(
                f"{self.count} candidates in a row failed by the same defect, the last: {evaluation.failed}; "
                "log.txt has the traceback; once it is mended, --resume goes on"
            )


def limit_of(first_generation: int | None) -> int:
    """Failures in a row that end a study, given the number of candidates of its first generation.

    `first_generation`: its size; None for later generations.
    """
    return IN_A_ROW if first_generation is None else min(IN_A_ROW, max(FEWEST, first_generation))
