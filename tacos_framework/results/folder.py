"""A folder that one process writes into at a time: files that are whole and carry checksums."""

from __future__ import annotations

import errno
import fcntl
import logging
import os
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
from tacos_framework.results.checksums import (
    Lines,
    checked_json,
    checked_lines,
    checksum,
    json_with_checksum,
    line_with_checksum,
    lines_with_checksums,
)
from tacos_framework.results.log import LogFile, logging_to
from tacos_framework.results.reading import checked_file, damage, read_recorded
from tacos_framework.results.writing import append_to_file, replace_file

log = logging.getLogger(__name__)


def is_in_use(folder: Path) -> bool:
    """Whether a process writes a run into a folder; True too where the file system does not tell."""
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
        self.samples: dict[str, str] = {}
        self._lock: int | None = None
        self._ends: dict[str, dict[str, Any]] = {}

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
        lock, self._lock = self._lock, None
        if lock is not None:
            os.close(lock)

    @contextmanager
    def writing(
        self, remedy: str = "Make room or mend the folder, then go on with --resume."
    ) -> Iterator[None]:
        """What the system refuses inside becomes a `UserError` that says what to do.

        Files are replaced whole, so the last checkpoint stays what it was.
        """
        try:
            yield
        except OSError as error:
            if self._lock is not None and not self.folder.is_dir():
                fault = Fault(
                    str(self.folder), "the results folder was removed meanwhile", "", "Start again."
                )
            else:
                fault = Fault(
                    str(self.folder),
                    f"the results cannot be written: {error.strerror or error}",
                    "a folder on a disk with room that you may write to",
                    remedy,
                )
            raise UserError(fault) from error

    def logging(self, packages: Iterable[str]) -> AbstractContextManager[None]:
        """Write the log of these packages to ``log.txt`` meanwhile."""
        with self.writing():
            file = LogFile(self.folder / "log.txt")
        return logging_to(file, packages)

    # files ------------------------------------------------------------------------------------------------

    def write_text(self, name: str, text: str) -> Path:
        """Write a file whole or not at all."""
        return self._write(name, text.encode("utf-8"))

    def write_json(self, name: str, value: Mapping[str, Any]) -> Path:
        """Write plain data as JSON with its checksum, whole or not at all; NaN is refused."""
        return self._write(name, json_with_checksum(value))

    def read_json(self, name: str) -> dict[str, Any] | None:
        """What `write_json` has written; None where that is not there.

        Raises
        ------
        UserError
            When it is not as it was written.
        """
        path = self.folder / name
        return checked_file(path, checked_json) if path.exists() else None

    def _write(self, name: str, data: bytes) -> Path:
        path = self.folder / name
        with self.writing():
            if not self.folder.is_dir():
                raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(self.folder))
            replace_file(path, data)
        return path

    def write_lines(self, name: str, lines: Iterable[Mapping[str, Any]]) -> None:
        """Replace a file of JSON lines."""
        self._ends.pop(name, None)
        self._write(name, lines_with_checksums(lines))

    def append_line(self, name: str, line: Mapping[str, Any]) -> None:
        """Add one JSON line to a file, which must not end in one that was cut short."""
        end = self.end_of(name)
        data, last = line_with_checksum(line, end["checksum"])
        with self.writing():
            append_to_file(self.folder / name, data)
        self._ends[name] = {"lines": end["lines"] + 1, "checksum": last}

    def end_of(self, name: str) -> dict[str, Any]:
        """How far a file of lines goes, as `Lines.end` has it."""
        if name not in self._ends:
            self._ends[name] = self.lines_of(name).end
        return self._ends[name]

    def lines_of(self, name: str) -> Lines:
        """The lines of a file with their checksums; none when it is not there.

        Raises
        ------
        UserError
            When one is damaged; a last line cut short is none.
        """
        path = self.folder / name
        return checked_file(path, checked_lines) if path.exists() else Lines()

    def read_lines(self, name: str) -> list[Any]:
        """The JSON lines of a file; empty when it is not there. One that was cut short is left out."""
        lines = self.lines_of(name)
        if lines.torn:
            log.warning("%s: the last line was cut short and is left out", name)
        return list(lines.values)

    def remove(self, name: str) -> None:
        """Remove a file, if it is there."""
        self._ends.pop(name, None)
        with self.writing():
            (self.folder / name).unlink(missing_ok=True)

    def write_state(self, name: str, state: State, about: Mapping[str, str] | None = None) -> str:
        """Keep the state of a trainable task under ``weights/``; returns its checksum.

        Parameters
        ----------
        name
            That of the file, without its ending.
        state
            What the task knows.
        about
            Goes into the file's header.
        """
        arrays = {key: np.ascontiguousarray(value) for key, value in state.items()}
        data = save(arrays, metadata=dict(about) if about else None)
        self._write(f"weights/{name}.safetensors", data)
        return checksum(data)

    def read_state(self, name: str, recorded: str) -> State:
        """A state kept by `write_state`, which has returned the checksum.

        Raises
        ------
        UserError
            When the file is not as it was written.
        """
        path = self.folder / "weights" / f"{name}.safetensors"
        data = read_recorded(path, recorded)
        try:
            return load(data)
        except SafetensorError as error:  # a checksum that fits is no proof of good will
            raise UserError(damage(path, f"it holds no weights: {error}")) from error

    def keep_weights(self, names: Iterable[str]) -> None:
        """Remove states under ``weights/`` that no checkpoint needs any more."""
        kept = {f"{name}.safetensors" for name in names}
        with self.writing():
            for path in (self.folder / "weights").glob("*.safetensors"):
                if path.name not in kept:
                    path.unlink(missing_ok=True)

    def write_sample(self, name: str, image: NDArray[np.uint8]) -> str:
        """Write an (H, W, 3) uint8 RGB picture to ``samples/NAME.png``; returns its relative path."""
        from PIL import Image

        encoded = BytesIO()
        Image.fromarray(image).save(encoded, "PNG", compress_level=1)
        relative = f"samples/{name}.png"
        self._write(relative, encoded.getvalue())
        self.samples[relative] = checksum(encoded.getvalue())
        return relative
