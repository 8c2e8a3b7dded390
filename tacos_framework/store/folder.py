"""A folder that one process writes into at a time: a database, and files that are whole."""

from __future__ import annotations

import errno
import fcntl
import json
import logging
import os
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load, save

from tacos_framework.contracts import State
from tacos_framework.errors import Fault, UserError
from tacos_framework.store.database import DATABASE, Database, damage
from tacos_framework.store.log import LogFile, logging_to
from tacos_framework.store.readers import FILES, digest, json_object, read_run_file
from tacos_framework.store.writers import replace_file

log = logging.getLogger(__name__)


def is_in_use(folder: Path) -> bool:
    """True if a process writes a run into a folder, and where the file system does not tell."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError:  # held, or a network file system without locks
        return True
    else:
        return False
    finally:
        os.close(descriptor)


class RunFolder:
    """A folder that is this process's alone until `close`; usable with ``with``."""

    def __init__(self, folder: Path):
        self.folder = Path(folder)
        self._lock: int | None = None
        self._database: Database | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    # whose it is -------------------------------------------------------------------------------------------

    def _hold(self) -> None:
        """Keep other runs out; the system lets go of it when this process ends, in whatever way."""
        self._lock = os.open(self.folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.close()
            raise UserError(
                Fault(
                    str(self.folder),
                    "another run is writing into this folder",
                    "a separate folder for each run",
                    "Wait for it or end it, or name another folder with --out.",
                )
            ) from None
        except OSError as error:  # some network file systems have no locks
            log.warning("the results folder cannot be locked: %s", error.strerror)

    def close(self) -> None:
        """Let other runs in; safe to call twice."""
        if self._database is not None:
            self._database.close()
        self._database = None
        lock, self._lock = self._lock, None
        if lock is not None:
            os.close(lock)

    @contextmanager
    def writing(
        self, remedy: str = "Make room or mend the folder, then go on with --resume."
    ) -> Iterator[None]:
        """Turns refusals of the system within into a `UserError` that says what to do.

        Transactions and files are there whole or not at all, so what was written before stays what it was.
        """
        try:
            yield
        except (OSError, sqlite3.Error) as error:
            if self._lock is not None and not self.folder.is_dir():
                fault = Fault(
                    str(self.folder), "the results folder was removed meanwhile", "", "Start again."
                )
            else:
                fault = Fault(
                    str(self.folder),
                    f"the results cannot be written: {getattr(error, 'strerror', None) or error}",
                    "a folder on a disk with room that you may write to",
                    remedy,
                )
            raise UserError(fault) from error

    def logging(self, packages: Iterable[str]) -> AbstractContextManager[None]:
        """Write the log of these packages to ``log.txt`` meanwhile."""
        with self.writing():
            file = LogFile(self.folder / "log.txt")
        return logging_to(file, packages)

    # the database -----------------------------------------------------------------------------------------

    @contextmanager
    def database(self) -> Iterator[Database]:
        """The database: that of this run, or one opened for this moment, as procedures need it."""
        with self.writing():
            if self._database is not None:
                yield self._database
                return
            self._check_is_there()
            with Database(self.folder / DATABASE) as database:
                yield database

    @contextmanager
    def transaction(self) -> Iterator[Database]:
        """The database, in which all that is written inside is there together or not at all."""
        with self.database() as database, database.transaction():
            yield database

    def append_line(self, name: str, line: Mapping[str, Any]) -> None:
        """Add plain data to the lines of a file, which is there to be read by others."""
        with self.database() as database:
            database.put(name, database.count(name), line)
            with (self.folder / name).open("ab") as file:
                file.write(lines_file([line]))

    def write_lines(self, name: str, lines: Iterable[Mapping[str, Any]]) -> None:
        kept = list(lines)
        with self.transaction() as database:
            database.remove(name)
            for number, line in enumerate(kept):
                database.put(name, number, line)
        self._replace(name, lines_file(kept))

    def read_lines(self, name: str) -> list[Any]:
        with self.database() as database:
            return list(database.all(name).values())

    # files ------------------------------------------------------------------------------------------------

    def write_text(self, name: str, text: str) -> Path:
        """Write a file whole or not at all."""
        return self._write(name, text.encode("utf-8"))

    def write_json(self, name: str, value: Mapping[str, Any]) -> Path:
        """Write plain data as JSON, whole or not at all; NaN is refused."""
        text = json.dumps(value, indent=1, allow_nan=False, ensure_ascii=False)
        return self.write_text(name, f"{text}\n")

    def read_json(self, name: str) -> dict[str, Any] | None:
        """The value that `write_json` has written; None if there is none.

        Raises `UserError` when it is not as it was written.
        """
        path = self.folder / name
        return read_run_file(path, json_object, self._recorded(name)) if path.exists() else None

    def _write(self, name: str, data: bytes) -> Path:
        """Replace a file and record its digest; a run that dies in between leaves it without one."""
        with self.database() as database:
            if database.get(FILES, name) is not None:
                database.remove(FILES, name)
            path = self._replace(name, data)
            database.put(FILES, name, digest(data))
        return path

    def _replace(self, name: str, data: bytes) -> Path:
        path = self.folder / name
        with self.writing():
            self._check_is_there()
            replace_file(path, data)
        return path

    def _check_is_there(self) -> None:
        if not self.folder.is_dir():
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(self.folder))

    def _recorded(self, name: str) -> str | None:
        with self.database() as database:
            found: str | None = database.get(FILES, name)
        return found

    def remove(self, name: str) -> None:
        with self.transaction() as database:
            database.remove(FILES, name)
            database.remove(name)
        with self.writing():
            (self.folder / name).unlink(missing_ok=True)

    def write_state(self, name: str, state: State, about: Mapping[str, str] | None = None) -> None:
        """Keep the state of a trainable task under ``weights/``.

        `name`: that of the file, without its ending. `about`: goes into the file's header.
        """
        arrays = {key: np.ascontiguousarray(value) for key, value in state.items()}
        self._write(_weights(name), save(arrays, metadata=dict(about) if about else None))

    def read_state(self, name: str) -> State:
        """A state kept by `write_state`.

        Raises `UserError` when the file is not as it was written.
        """
        path = self.folder / _weights(name)
        recorded = self._recorded(_weights(name))
        if recorded is None:
            raise UserError(damage(path, "the run has not recorded it"))
        data = read_run_file(path, bytes, recorded)
        try:
            return load(data)
        except SafetensorError as error:  # a digest that fits is no proof of good will
            raise UserError(damage(path, f"it holds no weights: {error}")) from error

    def keep_weights(self, names: Iterable[str]) -> None:
        """Remove states under ``weights/`` that nothing needs any more."""
        kept = {_weights(name) for name in names}
        with self.transaction() as database:
            for name in database.all(FILES):
                if name.startswith("weights/") and name not in kept:
                    database.remove(FILES, name)
        with self.writing():
            for path in (self.folder / "weights").glob("*.safetensors"):
                if f"weights/{path.name}" not in kept:
                    path.unlink(missing_ok=True)

    def write_sample(self, name: str, image: NDArray[np.uint8]) -> str:
        """Write an (H, W, 3) uint8 RGB picture to ``samples/NAME.png``; returns its relative path."""
        from PIL import Image

        encoded = BytesIO()
        Image.fromarray(image).save(encoded, "PNG", compress_level=1)
        relative = f"samples/{name}.png"
        self._write(relative, encoded.getvalue())
        return relative


def _weights(name: str) -> str:
    return f"weights/{name}.safetensors"


def lines_file(lines: Iterable[Mapping[str, Any]]) -> bytes:
    """A file of JSON lines, as others may read it."""
    return "".join(json.dumps(line, allow_nan=False, ensure_ascii=False) + "\n" for line in lines).encode()
