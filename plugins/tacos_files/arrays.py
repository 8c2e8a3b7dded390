"""Arrays of numbers in NumPy's files; never one that runs code.

References
----------
The format: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
"""

from __future__ import annotations

import math
import zipfile
import zlib
from io import BytesIO
from pathlib import Path
from tokenize import TokenError
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from tacos_framework import Fault, UserError
from tacos_framework.files import limits, read_bytes, too_large

UNREADABLE = (
    ValueError,
    TypeError,
    EOFError,
    TokenError,
    SyntaxError,
    MemoryError,
    RecursionError,
    OverflowError,
)
"""What NumPy raises on a header, which is a Python literal: a broken one meets Python's own parser."""

BROKEN_ZIP = (
    zipfile.BadZipFile,
    zlib.error,
    NotImplementedError,
    RuntimeError,
    OSError,
    EOFError,
    ValueError,
)
"""What `zipfile` raises on archives that are damaged, encrypted, or packed in a way it does not know."""

_NUMBERS = "biuf"
_TEXT = "U"


def read_npy(path: Path, *, where: str | None = None, within: Path | None = None) -> NDArray[Any]:
    """The array of numbers of a ``.npy`` file: exactly as many as its header says.

    Parameters are those of `tacos_framework.files.regular.read_bytes`.

    Raises `UserError` when it cannot be read, holds no numbers, or fewer or more than its header says.
    """
    content = read_bytes(path, "array_mb", where=where, within=within)
    return _array(content, str(path) if where is None else where, path.name, _NUMBERS)


def read_npz(path: Path, *, where: str | None = None) -> dict[str, NDArray[Any]]:
    """The arrays of numbers or text of an ``.npz`` file by name.

    Raises `UserError` as for `read_npy`, and when the archive is damaged or unpacks to more than the limit.
    """
    name = str(path) if where is None else where
    content = read_bytes(path, "array_mb", where=where)
    try:
        with zipfile.ZipFile(BytesIO(content)) as archive:
            members = archive.infolist()
            whole = sum(member.file_size for member in members)
            if whole > limits().bytes_of("array_mb"):
                raise UserError(too_large(name, f"{path.name}, unpacked,", whole, "array_mb"))
            unpacked = {member.filename.removesuffix(".npy"): archive.read(member) for member in members}
    except BROKEN_ZIP as error:
        raise UserError(_no_array(name, path.name, error)) from error
    return {
        key: _array(data, name, f"{path.name}: {key}", _NUMBERS + _TEXT) for key, data in unpacked.items()
    }


def _array(content: bytes, where: str, name: str, kinds: str) -> NDArray[Any]:
    stream = BytesIO(content)
    try:
        version = npy.read_magic(stream)
        read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        shape, by_columns, dtype = read(stream)
    except UNREADABLE as error:
        raise UserError(_no_array(where, name, error)) from error
    if dtype.kind not in kinds:
        raise UserError(Fault(where, f"{name} holds {dtype}", "numbers"))
    if not dtype.itemsize:
        raise UserError(Fault(where, f"{name} holds texts of no letters", "numbers or texts"))
    start = stream.tell()
    wanted, there = math.prod(shape) * dtype.itemsize, len(content) - start
    if any(length < 0 for length in shape) or wanted != there:
        what = f"{name} holds {there} bytes of numbers, and its header says {shape} of {dtype}: {wanted}"
        raise UserError(Fault(where, what, "a whole .npy file", "Copy or save it anew."))
    flat: NDArray[Any] = np.frombuffer(content, dtype, math.prod(shape), start)
    return flat.reshape(shape[::-1]).T if by_columns else flat.reshape(shape)


def _no_array(where: str, name: str, error: Exception) -> Fault:
    return Fault(where, f"{name} is no array: {error}", "a .npy file of numbers")
