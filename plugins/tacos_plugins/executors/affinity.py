"""Choice of the next job of an idle worker, where jobs need costly things that workers keep."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Collection, Hashable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

Affinity = Hashable | None

Making = Literal["nothing", "first", "again"]
"""Things a worker makes for a job: nothing, something no worker has, or something another has."""

MOST_TIMES_LONGER, GRACE_S = 20, 60.0
"""A job that takes so many times the longest seen, and so much more [s], hangs."""


def affinity_of(job: Any) -> Affinity:
    """The costly things a job needs, if it says so (`tacos_framework.contracts.JobRunner`)."""
    found: Affinity = getattr(job, "affinity", None)
    return found


def making(needs: Affinity, at_hand: Collection[Affinity], anywhere: Collection[Affinity]) -> Making:
    """The things a worker has to make for a job, by what it has at hand, and what any worker has.

    >>> making("attic", at_hand={"cellar"}, anywhere={"attic", "cellar"})
    'again'
    """
    return "nothing" if needs in at_hand else "again" if needs in anywhere else "first"


_RECENT = 8  # jobs whose mean says what the next one takes: a search comes to cameras of more pixels


@dataclass
class JobTimes:
    """Times of jobs, by the things made for them: another worker's may be kept where they are read."""

    _at_hand_s: deque[float] = field(default_factory=lambda: deque(maxlen=_RECENT))
    _again_s: float = math.inf  # the least: others waited until the worker that had it first had made it
    _longest_s: float = 0.0

    def saw(self, seconds: float, *, made: Making) -> None:
        """A job took so long [s]."""
        self._longest_s = max(self._longest_s, seconds)
        if made == "nothing":
            self._at_hand_s.append(seconds)
        elif made == "again":
            self._again_s = min(self._again_s, seconds)

    def generous_s(self, attempt: int) -> float:
        """A time that no job takes unless it hangs, and ten times that for a second attempt [s]."""
        if not self._longest_s:
            return math.inf
        return (MOST_TIMES_LONGER * self._longest_s + GRACE_S) * 10 ** (attempt - 1)

    @property
    def cost_of_making(self) -> float:
        """Number of jobs done in the time of one that makes again what another has; 1 if unknown."""
        if not self._at_hand_s or math.isinf(self._again_s):
            return 1.0
        return max(1.0, self._again_s * len(self._at_hand_s) / sum(self._at_hand_s))


def assigned(
    waiting: Sequence[Affinity],
    idle: Sequence[Collection[Affinity]],
    busy: Collection[Affinity],
    cost_of_making: float = 1.0,
) -> dict[int, int]:
    """The job each idle worker is to do: ``{worker: job}``.

    A worker goes on with what it has at hand; then it takes up what no worker has yet; and before it idles it
    makes anew what another has, the last job of those most wait for, where it is done with it before the
    other would be. What another was given just now, that one has to do first; of what it does since longer,
    nothing may be left.

    - `waiting`: what each waiting job needs, in the order in which results are wanted; None for nothing.
    - `idle`: what each idle worker has at hand.
    - `busy`: what the other workers have at hand.
    - `cost_of_making`: see `JobTimes`; at 1 no worker idles while a job waits.

    >>> assigned(["attic", "cellar"], idle=[set(), {"attic"}], busy=set())
    {1: 0, 0: 1}
    >>> assigned(["attic", "attic"], idle=[set()], busy={"attic"})
    {0: 1}
    >>> assigned(["attic", "attic"], idle=[{"attic"}, set()], busy=set(), cost_of_making=1.8)
    {0: 0, 1: 1}
    """
    left = dict(enumerate(waiting))
    given: dict[int, int] = {}
    taken = {*busy, *(each for at_hand in idle for each in at_hand)} - {None}

    def give(worker: int, job: int | None) -> None:
        if job is not None:
            taken.add(left.pop(job))
            given[worker] = job

    for worker, at_hand in enumerate(idle):
        give(
            worker, next((job for job, needs in left.items() if needs is not None and needs in at_hand), None)
        )
    for worker in (each for each in range(len(idle)) if each not in given):
        give(worker, next((job for job, needs in left.items() if needs is None or needs not in taken), None))
    begun = Counter(waiting[job] for job in given.values())
    for worker in (each for each in range(len(idle)) if each not in given):
        wanted = Counter(left.values())
        last = max(left, key=lambda job: (wanted[left[job]], job), default=None)
        pays = last is not None and wanted[left[last]] + begun[left[last]] >= cost_of_making
        give(worker, last if pays else None)
    return given
