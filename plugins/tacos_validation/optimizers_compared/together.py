"""Several runs at once: what they ask for is simulated in one batch, and no worker waits for a run to think.

A run by itself asks for one camera after the other, which keeps one worker busy at most.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from threading import Condition
from typing import TypeVar

from tacos_validation.score_table import ScoreTable, Wanted

Member = TypeVar("Member")


class GivenUp(Exception):
    """Another run has failed or the user has broken off, and no run goes on."""


class FilledTogether:
    """A table that is filled once all of its members wait for it, with what all of them want.

    The order in which members ask is not known, but what a table holds does not depend on it. Members wait in
    threads of their own; the table is filled in the thread that calls `serve`.

    `members`: how many fill it; each `leave` in the end.
    """

    def __init__(self, table: ScoreTable, members: int) -> None:
        self._table = table
        self._members = members
        self._waiting = 0
        self._batch = 0
        self._wanted: list[Wanted] = []
        self._is_given_up = False
        self._changed = Condition()

    def fill(self, wanted: Iterable[Wanted]) -> None:
        """Return once all that is wanted stands in the table.

        Raises GivenUp when filling it has failed, or a member has given up.
        """
        with self._changed:
            if lacking := self._table.lacking(wanted):
                own = self._batch
                self._wanted += lacking
                self._waiting += 1
                self._changed.notify_all()
                self._changed.wait_for(lambda: self._batch > own or self._is_given_up)
            if self._is_given_up:
                raise GivenUp

    def leave(self) -> None:
        with self._changed:
            self._members -= 1
            self._changed.notify_all()

    def give_up(self) -> None:
        with self._changed:
            self._is_given_up = True
            self._changed.notify_all()

    def serve(self) -> None:
        """Fill the table again and again, until all members have left or one has given up.

        The table is filled outside of the lock, so that `give_up` never waits for a batch.
        """
        while wanted := self._all_that_is_wanted():
            self._table.fill(sorted(wanted, key=repr))  # in an order that no thread decides
            with self._changed:
                self._batch += 1
                self._changed.notify_all()

    def _all_that_is_wanted(self) -> list[Wanted]:
        with self._changed:
            self._changed.wait_for(lambda: self._is_given_up or self._waiting == self._members)
            if self._is_given_up:
                return []
            wanted, self._wanted, self._waiting = self._wanted, [], 0
            return wanted


def together(members: Sequence[Member], go: Callable[[Member], None], table: FilledTogether) -> None:
    """Let every member go at once, each in a thread; the first that fails ends all.

    The table is filled in this thread, which Ctrl-C interrupts: a batch in work is left at once, what had
    come of it stays, and the members end as soon as they would ask for more.
    """

    def gone(member: Member) -> None:
        try:
            go(member)
        except BaseException:
            table.give_up()
            raise
        table.leave()

    with ThreadPoolExecutor(max(1, len(members))) as threads:
        running = [threads.submit(gone, member) for member in members]
        try:
            table.serve()
        finally:
            table.give_up()
    for each in running:
        if not isinstance(error := each.exception(), GivenUp | None):
            raise error
