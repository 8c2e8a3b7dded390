"""Bytes of regular files: no pipe is waited for, no device read, no folder left through a link."""

from __future__ import annotations

import errno
import os
import stat
from io import BufferedReader
from pathlib import Path, PurePosixPath

from tacos_framework.errors import Fault, UserError
from tacos_framework.files.limits import MB, limits

_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a named pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)
_LFS_POINTER = b"version https://git-lfs.github.com/spec/"
# A pipe that nobody writes to would be waited for, and a terminal become ours: neither is a file to read.
_FLAGS = os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC


class NotAFile(OSError):
    """Raised for paths that are no regular file; ``strerror`` names the kind: a folder, a named pipe."""


def open_regular(path: Path) -> BufferedReader:
    """A regular file, open for reading.

    What is checked is what was opened: nothing can be exchanged between the check and the reading.

    Raises `NotAFile` when something else is there. Raises `OSError` when nothing is, or it cannot be opened.
    """
    descriptor = os.open(path, _FLAGS)
    mode = os.fstat(descriptor).st_mode
    if stat.S_ISREG(mode):
        return os.fdopen(descriptor, "rb")
    os.close(descriptor)
    raise NotAFile(errno.EINVAL, next((name for test, name in _KINDS if test(mode)), "no regular file"))


def read_bytes(path: Path, limit: str, *, where: str | None = None, within: Path | None = None) -> bytes:
    """All bytes of a regular file.

    - `path`: the file; links are followed.
    - `limit`: the one of `tacos_framework.files.limits.Limits` that holds for its size, in megabytes.
    - `where`: what names the file in messages; the path, when left out.
    - `within`: the folder the file must lie in, once all links are followed; None for any.

    Raises `UserError` when there is no such file, or it is no regular one, cannot be read, is too large or
    lies elsewhere.
    """
    where = str(path) if where is None else where
    try:
        file = open_regular(path)
    except NotAFile as error:
        raise UserError(Fault(where, f"{_shown(path)} is {error.strerror}", "a file")) from None
    except FileNotFoundError:
        expected = "" if where == str(path) else str(path)
        lacking = "" if path.parent.exists() else f": there is no folder {str(path.parent)!r} either"
        raise UserError(
            Fault(where, f"there is no file {path.name!r}", expected, f"Check the path{lacking}.")
        ) from None
    except ValueError as error:  # a NUL in the path
        raise UserError(Fault(where, f"{str(path)!r} is not a path: {error}")) from error
    except OSError as error:
        raise UserError(Fault(where, f"{_shown(path)} cannot be read: {error.strerror}")) from error
    try:
        with file:
            size_bytes = _checked_size(file.fileno(), path, where, limit, within)
            content = file.read(size_bytes + 1)
            if len(content) > size_bytes:  # it grows meanwhile; or it is one of /proc, which have no size
                content += file.read(limits().bytes_of(limit) + 1 - len(content))
    except OSError as error:
        raise UserError(Fault(where, f"{_shown(path)} cannot be read: {error.strerror}")) from error
    if len(content) > limits().bytes_of(limit):
        raise UserError(too_large(where, _shown(path), len(content), limit))
    if content.startswith(_LFS_POINTER):
        what = f"{_shown(path)} is a pointer of Git LFS in place of the file"
        raise UserError(Fault(where, what, "the file itself", "Fetch it: git lfs pull."))
    return content


def _checked_size(descriptor: int, path: Path, where: str, limit: str, within: Path | None) -> int:
    """The size of an open file that may be read [bytes]."""
    size_bytes = os.fstat(descriptor).st_size
    if within is not None and not _opened(descriptor, path).is_relative_to(within.resolve()):
        what = f"{_shown(path)} leads out of {within}"
        raise UserError(Fault(where, what, "a file inside", "Copy the file into it."))
    if size_bytes > limits().bytes_of(limit):
        raise UserError(too_large(where, _shown(path), size_bytes, limit))
    return size_bytes


def named_file(folder: Path, name: str) -> Path | None:
    """The file in a folder that a name stands for: as it stands, with ``\\`` for ``/``, or in other capitals.

    Names come from machines that do not tell capitals apart. None where there is no such file.
    """
    path = folder / PurePosixPath(name.replace("\\", "/"))
    if path.exists():
        return path
    others = sorted(path.parent.iterdir()) if path.parent.is_dir() else ()
    return next((each for each in others if each.name.casefold() == path.name.casefold()), None)


def too_large(where: str, what: str, size_bytes: int, limit: str) -> Fault:
    """The fault of what would take more bytes than a limit allows."""
    allowed = limits()
    return Fault(
        where,
        f"{what} is larger than {limits().bytes_of(limit)} bytes: {size_bytes}",
        f"at most {getattr(allowed, limit):g} MB",
        allowed.remedy(limit, size_bytes / MB),
    )


def _opened(descriptor: int, path: Path) -> Path:
    """Location of the open file itself (Linux), whatever a link points to meanwhile, or the path."""
    link = Path(f"/proc/self/fd/{descriptor}")
    return Path(os.readlink(link)) if link.is_symlink() else path.resolve()


def _shown(path: Path) -> str:
    """The name of a file, cut where it is longer than any file's."""
    return path.name if len(path.name) <= 255 else f"{path.name[:60]}..."
