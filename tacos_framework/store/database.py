"""The database of a run: a transaction is there whole or not at all, and any damage shows."""

from __future__ import annotations

import json
import os
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from tacos_framework.errors import Fault, UserError
from tacos_framework.files import limits
from tacos_framework.files.regular import NotAFile, open_regular
from tacos_framework.files.trees import new_checksum

DATABASE = "run.sqlite"
FORMAT = 5
"""Format of the database (``user_version``); another one cannot be resumed."""

PARTS = tuple(f"{DATABASE}{end}" for end in ("", "-wal", "-shm", "-journal"))
"""The database, and the files that sqlite has beside it while a process writes or after it was killed."""

PAGE_BYTES = 4096
"""Size of a page; a database with anything in it has more than one."""

PATIENCE_S = 60.0
"""Time to wait for another process that reads or writes at this moment."""

_SCHEMA = (
    "CREATE TABLE entries (kind TEXT, key, value TEXT NOT NULL, digest TEXT NOT NULL, "
    "PRIMARY KEY (kind, key)) WITHOUT ROWID"
)

Key = str | int


class Database:
    """Values by kind and key, each with a digest over all three; usable with ``with``.

    A commit is on the disk when it returns (WAL, ``synchronous=FULL``), so that it outlives the machine's
    power. Where the file system has no shared memory, sqlite writes a rollback journal instead.

    Raises `UserError` when it is no regular file, no database of a run, of another version, or cannot be
    read. Raises `OSError` or `sqlite3.Error` when it cannot be written.

    - `path`: its file; created where it is missing, unless it is only read.
    - `read_only`: whether nothing is written, which needs no permission to.
    """

    def __init__(self, path: Path, *, read_only: bool = False) -> None:
        self.path = path
        if new := not read_only and not path.exists():
            self._connection = self._connected(read_only)
        else:
            with self._reading():
                open_regular(path).close()
                self._connection = self._connected(read_only)
        self._connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, limits().bytes_of("lines_mb"))
        try:
            if not read_only:
                self._prepare(new)
            self._check_format()
        except BaseException:
            self.close()
            raise

    def _connected(self, read_only: bool) -> sqlite3.Connection:
        uri = self.path.absolute().as_uri()
        if read_only:
            if not self.path.with_name(PARTS[1]).exists():
                uri += "?mode=ro&immutable=1"  # what stands alone needs no lock, and no shared memory
            elif os.access(self.path.parent, os.W_OK):
                uri += "?mode=rw"  # sqlite recovers what a killed run has not moved into the database
            else:
                uri += "?mode=ro"
        return sqlite3.connect(
            uri, uri=True, timeout=PATIENCE_S, isolation_level=None, check_same_thread=False
        )

    def _prepare(self, new: bool) -> None:
        run = self._connection.execute
        if new:
            run("PRAGMA journal_mode = WAL")
            with self.transaction():
                run(_SCHEMA)
                run(f"PRAGMA user_version = {FORMAT}")
        with self._reading():
            run("PRAGMA synchronous = FULL")

    def _check_format(self) -> None:
        with self._reading():
            ((found,),) = self._connection.execute("PRAGMA user_version")
        if found != FORMAT:
            raise UserError(other_version(self.path, f"format {found}", f"format {FORMAT}"))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: object, trace: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the file; safe to call twice."""
        self._connection.close()

    # writing ----------------------------------------------------------------------------------------------

    @contextmanager
    def transaction(self) -> Iterator[None]:
        """All that is written inside is there, or nothing of it; one inside another is part of it."""
        if self._connection.in_transaction:
            yield
            return
        self._connection.execute("BEGIN IMMEDIATE")
        try:
            yield
            self._connection.execute("COMMIT")
        finally:
            if self._connection.in_transaction:
                self._connection.execute("ROLLBACK")

    def put(self, kind: str, key: Key, value: Any) -> None:
        """Keep plain data, in place of what had that key; NaN is refused (ValueError)."""
        data = json.dumps(value, allow_nan=False, ensure_ascii=False)
        row = (kind, key, data, _digest(kind, key, data))
        self._connection.execute("INSERT OR REPLACE INTO entries VALUES (?, ?, ?, ?)", row)

    def remove(self, kind: str, key: Key | None = None) -> None:
        """Forget what has a key, or all of a kind."""
        condition, given = ("", (kind,)) if key is None else (" AND key = ?", (kind, key))
        self._connection.execute(f"DELETE FROM entries WHERE kind = ?{condition}", given)

    # reading ----------------------------------------------------------------------------------------------

    def get(self, kind: str, key: Key) -> Any:
        """The value under a key; None if there is none."""
        return next(iter(self._values("kind = ? AND key = ?", (kind, key)).values()), None)

    def all(self, kind: str) -> dict[Any, Any]:
        """Everything of a kind by its key, in the order of the keys."""
        return self._values("kind = ?", (kind,))

    def count(self, kind: str) -> int:
        with self._reading():
            ((count,),) = self._connection.execute("SELECT count(*) FROM entries WHERE kind = ?", (kind,))
        return int(count)

    def kinds(self) -> list[str]:
        with self._reading():
            return [kind for (kind,) in self._connection.execute("SELECT DISTINCT kind FROM entries")]

    def check(self) -> None:
        """Check the whole of it.

        Raises `UserError` with the first thing that is not as it was written.
        """
        with self._reading():
            ((found,),) = self._connection.execute("PRAGMA quick_check(1)")
        if found != "ok":
            raise UserError(damage(self.path, str(found)))
        for kind in self.kinds():
            self.all(kind)

    def _values(self, condition: str, given: Sequence[Key]) -> dict[Any, Any]:
        found: dict[Any, Any] = {}
        with self._reading():
            for kind, key, value, digest in self._connection.execute(
                f"SELECT * FROM entries WHERE {condition} ORDER BY kind, key", given
            ):
                if digest != _digest(kind, key, value):
                    raise UserError(damage(self.path, f"the digest of {kind} {key} does not fit its content"))
                try:
                    found[key] = json.loads(value)
                except (ValueError, RecursionError) as error:  # a digest that fits is no proof of good will
                    raise UserError(damage(self.path, f"{kind} {key} is no JSON: {error}")) from error
        return found

    @contextmanager
    def _reading(self) -> Iterator[None]:
        """Have what sqlite cannot read be damage."""
        try:
            yield
        except NotAFile as error:
            raise UserError(damage(self.path, f"it is {error.strerror}")) from error
        except OSError as error:
            raise UserError(damage(self.path, f"it cannot be read: {error.strerror or error}")) from error
        except sqlite3.Error as error:
            raise UserError(damage(self.path, str(error))) from error


def _digest(kind: Any, key: Any, value: Any) -> str:
    return new_checksum(f"{kind}\0{key}\0{value}".encode()).hexdigest()


def damage(path: Path, what: str) -> Fault:
    """The fault of a file that is not as the run left it."""
    return Fault(
        str(path),
        f"the file is damaged: {what}",
        "the file as the run left it",
        f"Restore it from a copy, or start a new run; `tacos verify {path.parent}` looks at all files.",
    )


def other_version(path: Path, found: str, expected: str) -> Fault:
    """The fault of a run that another version of the framework wrote."""
    return Fault(
        str(path),
        f"it is of another version of tacos-framework: {found}",
        expected,
        "Resume with the version of tacos-framework it was written by.",
    )
