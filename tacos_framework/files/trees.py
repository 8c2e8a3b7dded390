"""Checksums of files and of folders of files, to tell whether any of them has changed."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

from tacos_framework.files.regular import open_regular


def new_checksum(data: bytes = b"") -> hashlib.blake2b:
    """The checksum of data, to which more may be added (BLAKE2b, 32 hexadecimal digits)."""
    return hashlib.blake2b(data, digest_size=16)


def checksums_below(root: Path) -> Mapping[str, str]:
    """Checksums of a file, or of all files below a folder but byte code, by their paths below it, sorted.

    Raises `OSError` when one cannot be read, or is no regular file.
    """
    stats = [(path, os.stat(path)) for path in _files(root)]
    stamps = tuple((path, stat.st_mtime_ns, stat.st_size) for path, stat in stats)
    return _checksums_as_of(root, stamps)


@lru_cache(maxsize=32)
def _checksums_as_of(root: Path, stamps: tuple[tuple[str, int, int], ...]) -> Mapping[str, str]:
    folder = root.parent if root.is_file() else root
    found = {os.path.relpath(path, folder): _checksum_of_file(Path(path)) for path, _, _ in stamps}
    return MappingProxyType(found)


def _checksum_of_file(path: Path) -> str:
    with open_regular(path) as file:
        return hashlib.file_digest(file, new_checksum).hexdigest()


def _files(root: Path) -> Iterator[str]:
    """All files of a folder in order, or the file itself; as text, for `Path` takes longer than to look."""
    if root.is_file():
        yield str(root)
        return
    for folder, names, files in os.walk(root):
        names[:] = sorted(name for name in names if name != "__pycache__")
        yield from (path for name in sorted(files) if os.path.isfile(path := os.path.join(folder, name)))
