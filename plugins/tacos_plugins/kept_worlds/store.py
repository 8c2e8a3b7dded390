"""Entries on disk by content key: made once, whoever asks, whatever happens to the disk."""

from __future__ import annotations

import fcntl
import logging
import os
import shutil
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from tacos_plugins.kept_worlds.entry_file import Damaged, packed, unpacked, write_whole
from tacos_plugins.kept_worlds.structures import CannotBeKept, put_together, taken_apart

log = logging.getLogger(__name__)

Made = TypeVar("Made")

FOLDER_VARIABLE = "TACOS_CACHE"
"""Environment variable that names the folder of the store; ``off`` keeps nothing."""

DEFAULT_LIMIT_BYTES = 10 * 10**9
WORTH_KEEPING_S = 0.2
"""Things made faster than this are not kept [s]."""

_SPARE_BYTES = 10**9  # left free on the disk
_ABANDONED_S = 3600.0  # a partial file this old is of a process that died
_SUFFIX, _LOCK, _LIMIT_FILE = ".world", ".lock", "limit"


@dataclass(frozen=True)
class Contents:
    entries: int
    size_bytes: int
    limit_bytes: int


class WorldStore:
    """Things that are costly to make, kept in a folder.

    Processes that ask for the same thing at the same time wait for the one that makes it. A damaged entry is
    said and made anew. Where the folder cannot be written, things are made as if there were no store. The
    entries that were used longest ago go when there is more than the limit.

    - `folder`: where entries lie; made when the first is written.
    """

    def __init__(self, folder: Path):
        self.folder = folder
        self._is_writable = True

    def get(self, key: str, make: Callable[[], Made], classes: Sequence[type[Any]]) -> Made:
        """The value under a key, or else that of `make`, then kept if it can be.

        `key`: content key of all that it follows from. `classes`: the frozen dataclasses it consists of,
        beside arrays and plain data.
        """
        found = self._read(key, classes)
        if found is None:
            with self._alone(key):
                found = self._read(key, classes)  # another process may have made it meanwhile
                if found is None:
                    began = time.perf_counter()
                    found = (make(),)
                    if time.perf_counter() - began >= WORTH_KEEPING_S:
                        self._write(key, found[0], classes)
        made: Made = found[0]
        return made

    @property
    def limit_bytes(self) -> int:
        """Its limit [bytes]."""
        try:
            return int((self.folder / _LIMIT_FILE).read_text())
        except (FileNotFoundError, ValueError):
            return DEFAULT_LIMIT_BYTES

    def set_limit(self, limit_bytes: int) -> None:
        """Let it hold so much, from now on [bytes]; raises `OSError` where that cannot be written."""
        self.folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        write_whole(self.folder / _LIMIT_FILE, str(limit_bytes).encode())
        self._make_room(0)

    def contents(self) -> Contents:
        """Its contents now."""
        sizes = [size for _, size, _ in self._entries()]
        return Contents(len(sizes), sum(sizes), self.limit_bytes)

    def clear(self) -> Contents:
        """Delete all entries; returns what it held."""
        held = self.contents()
        for pattern in (f"*{_SUFFIX}", "*.partial"):
            for path in self.folder.glob(pattern):
                path.unlink(missing_ok=True)
        self._remove_left_locks()
        return held

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}{_SUFFIX}"

    def _read(self, key: str, classes: Sequence[type[Any]]) -> tuple[Any] | None:
        """The value, in a tuple; None where there is none that can be used."""
        path = self._path(key)
        try:
            plain, arrays = unpacked(path.read_bytes())
        except FileNotFoundError:
            return None
        except OSError as error:
            self._give_up(error)
            return None
        except Damaged as damage:  # what is made anew takes its place
            log.warning("the kept world %s is damaged and made anew: %s", path, damage)
            return None
        with suppress(OSError):  # a store that can only be read needs no order to delete in
            os.utime(path)
        return (put_together(plain, arrays, classes),)

    def _write(self, key: str, value: Any, classes: Sequence[type[Any]]) -> None:
        if not self._is_writable:
            return
        try:
            data = packed(*taken_apart(value, classes))
        except CannotBeKept as reason:
            log.info("a world is not kept: %s", reason)
            return
        try:
            free = shutil.disk_usage(self.folder).free
            if len(data) > self.limit_bytes or free - len(data) < _SPARE_BYTES:
                log.info("a world of %d MB is not kept: too little room", len(data) // 10**6)
                return
            self._make_room(len(data))
            write_whole(self._path(key), data)
        except OSError as error:
            self._give_up(error)

    def _make_room(self, wanted_bytes: int) -> None:
        """Delete what was used longest ago until so much more fits; and what processes left that died."""
        limit = self.limit_bytes
        entries = sorted(self._entries())
        held = sum(size for _, size, _ in entries)
        for _, size, path in entries:
            if held + wanted_bytes <= limit:
                break
            path.unlink(missing_ok=True)
            held -= size
        for path in self.folder.glob("*.partial"):
            try:
                if time.time() - path.stat().st_mtime > _ABANDONED_S:
                    path.unlink()
            except FileNotFoundError:  # another process was faster
                continue
        self._remove_left_locks()

    def _remove_left_locks(self) -> None:
        """Delete the locks of processes that died: those that nobody holds."""
        for path in self.folder.glob(f"*{_LOCK}"):
            with suppress(OSError), path.open("rb") as lock:  # held, or gone already
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                path.unlink()

    def _entries(self) -> Iterator[tuple[float, int, Path]]:
        """When each entry was used last, its size [bytes], and its file."""
        for path in self.folder.glob(f"*{_SUFFIX}"):
            try:
                about = path.stat()
            except FileNotFoundError:  # another process has just deleted it
                continue
            yield about.st_mtime, about.st_size, path

    @contextmanager
    def _alone(self, key: str) -> Iterator[None]:
        """Be the only process that makes an entry; the system lets go where that process dies."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            lock = (self.folder / f"{key}{_LOCK}").open("wb")
        except OSError as error:
            self._give_up(error)
            yield
            return
        with lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX)
            except OSError as error:  # some network file systems have no locks: it is made twice at worst
                self._give_up(error)
            try:
                yield
            finally:
                Path(lock.name).unlink(missing_ok=True)  # those who wait hold it open, and look once more

    def _give_up(self, error: OSError) -> None:
        """Say once that nothing is kept."""
        if self._is_writable:
            log.warning("worlds are not kept in %s: %s", self.folder, error)
        self._is_writable = False


def store_of_user() -> WorldStore | None:
    """The store of this user on this machine; None where ``TACOS_CACHE`` is ``off``."""
    given = os.environ.get(FOLDER_VARIABLE, "")
    if given == "off":
        return None
    if given:
        return WorldStore(Path(given))
    home = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return WorldStore(Path(home) / "tacos" / "worlds")
