"""Named tensors of safetensors files, whose reader runs nothing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from tacos_framework.errors import Fault, UserError
from tacos_framework.files.regular import read_bytes

EXPECTED = "a whole safetensors file"


def read_tensors(path: Path, *, where: str | None = None) -> dict[str, NDArray[Any]]:
    """The arrays of a safetensors file by name.

    Raises
    ------
    UserError
        When it cannot be read, is no such file, cut short or too large, or keeps types NumPy has not.
    """
    from safetensors import SafetensorError
    from safetensors.numpy import load

    content = read_bytes(path, "weights_mb", where=where)
    try:
        return dict(load(content))
    except (SafetensorError, KeyError, ValueError) as error:  # KeyError: a type such as bfloat16
        name = str(path) if where is None else where
        raise UserError(
            Fault(name, f"{path.name} is no safetensors file: {error}", EXPECTED, "Copy it anew.")
        ) from error
