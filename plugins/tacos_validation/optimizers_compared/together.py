"""Several runs at once: what they ask for is simulated in one batch, and no worker waits for a run to think.

A run by itself asks for one camera after the other, which keeps one worker busy at most.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from threading import Condition
from typing import TypeVar

from tacos_validation.score_table import ScoreTable, Wanted

Member = TypeVar("Member")


class GivenUp(Exception):
    """Another run has failed, and no run goes on."""


class FilledTogether:
    """A table that is filled once all of its members wait for it, with what all of them want.

    The order in which members ask is not known, but what a table holds does not depend on it.

    Parameters
    ----------
    table
        The table.
    members
        How many fill it; each `leave` in the end.
    """

    def __init__(self, table: ScoreTable, members: int) -> None:
        self._table = table
        self._members = members
        self._waiting = 0
        self._batch = 0
        self._wanted: list[Wanted] = []
        self._has_failed = False
        self._changed = Condition()

    def fill(self, wanted: Iterable[Wanted]) -> None:
        """Return once all that is wanted stands in the table.

        Raises
        ------
        GivenUp
            When filling it has failed for another member, or one has given up.
        """
        with self._changed:
            if lacking := self._table.lacking(wanted):
                own = self._batch
                self._wanted += lacking
                self._waiting += 1
                self._fill_if_all_wait()
                self._changed.wait_for(lambda: self._batch > own or self._has_failed)
            if self._has_failed:
                raise GivenUp

    def leave(self) -> None:
        """One member asks for nothing any more."""
        with self._changed:
            self._members -= 1
            self._fill_if_all_wait()

    def give_up(self) -> None:
        """Nobody is to wait any longer."""
        with self._changed:
            self._has_failed = True
            self._changed.notify_all()

    def _fill_if_all_wait(self) -> None:
        if not self._waiting or self._waiting < self._members or self._has_failed:
            return
        wanted, self._wanted, self._waiting = self._wanted, [], 0
        try:
            self._table.fill(sorted(wanted, key=repr))  # in an order that no thread decides
        except BaseException:
            self._has_failed = True
            raise
        finally:
            self._batch += 1
            self._changed.notify_all()


def together(members: Sequence[Member], go: Callable[[Member], None], table: FilledTogether) -> None:
    """Let every member go at once, each in a thread; the first that fails ends all.

    Parameters
    ----------
    members
        As many as `table` was told.
    go
        What each does; it fills `table` as it needs.
    table
        Where they wait for one another.
    """

    def gone(member: Member) -> None:
        go(member)
        table.leave()

    with ThreadPoolExecutor(max(1, len(members))) as threads:
        running = [threads.submit(gone, member) for member in members]
        try:
            for each in as_completed(running):
                if not isinstance(error := each.exception(), GivenUp | None):
                    raise error
        finally:
            table.give_up()
