"""Machine code of loops on disk, compiled anew where anything that it was made of has changed."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numba.core.caching import FunctionCache
from numba.extending import is_jitted

from tacos_framework.cache import content_key


class KeptCode(FunctionCache):
    """numba's code on disk, under a key of what was written into it from other files too.

    numba itself looks at the file of the loop alone. Constants of others are written into the code as they
    are, and so are the loops it calls: with another layout of memory than that of the day, it would write
    beyond its arrays.
    """

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        return (*super()._index_key(sig, codegen), made_of(self._py_func))


def made_of(loop: Callable[..., Any]) -> str:
    """A key of the constants and the compiled loops, with theirs, that a loop reads from its module.

    Examples
    --------
    >>> width = 3
    >>> def area(height):
    ...     return width * height
    >>> key = made_of(area)
    >>> width = 4
    >>> made_of(area) == key
    False
    """
    return content_key(*_parts(loop, set()))


def _parts(loop: Callable[..., Any], known: set[int]) -> list[Any]:
    known.add(id(loop))
    module: dict[str, Any] = loop.__globals__
    parts: list[Any] = []
    for name in sorted(set(loop.__code__.co_names) & module.keys()):
        value = module[name]
        if is_jitted(value) and id(value.py_func) not in known:
            parts += [name, _text(value.py_func.__code__.co_filename), _parts(value.py_func, known)]
        elif isinstance(value, bool | int | float | str | tuple | np.generic | np.ndarray):
            parts += [name, type(value).__name__, str(getattr(value, "dtype", "")), value]
    return parts


@cache
def _text(path: str) -> str:
    """What a source file holds; nothing where there is none, as for what was typed in."""
    file = Path(path)
    return file.read_text(encoding="utf-8") if file.is_file() else ""
