"""Machine code of loops on disk, compiled anew where anything that it was made of has changed."""

from __future__ import annotations

from collections.abc import Callable
from types import CodeType
from typing import Any

import numpy as np
from numba.core.caching import FunctionCache
from numba.extending import is_jitted

from tacos_framework import content_key

_WRITTEN_IN = (bool, int, float, str, tuple, np.generic, np.ndarray)
"""Types of globals that numba writes into code as they stand."""


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
            parts += [name, *_instructions(value.py_func.__code__), _parts(value.py_func, known)]
        elif isinstance(value, _WRITTEN_IN):
            parts += [name, type(value).__name__, str(getattr(value, "dtype", "")), value]
    return parts


def _instructions(code: CodeType) -> list[Any]:
    """The instructions of a function, wherever it stands."""
    plain = [(type(each).__name__, each) for each in code.co_consts if isinstance(each, _WRITTEN_IN)]
    inner = [_instructions(each) for each in code.co_consts if isinstance(each, CodeType)]
    return [code.co_code.hex(), list(code.co_names), list(code.co_varnames), plain, inner]
