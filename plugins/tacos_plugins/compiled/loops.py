"""Loops over pixels, compiled on first use (numba) and kept on disk for the next process."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any, TypeVar, cast

import numba
from numba.core.compiler import CompilerBase, DefaultPassBuilder

from tacos_plugins.compiled.kept_code import KeptCode

_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}  # division by zero is not looked for

Loop = TypeVar("Loop", bound=Callable[..., Any])


def compiled(loop: Loop) -> Loop:
    """A function of arrays and numbers as machine code.

    Sums keep their order (no `fastmath`), so every process gives the same bits. The code is kept beside the
    module, in the user's cache folder where that cannot be written, or where NUMBA_CACHE_DIR says; where none
    can be written, it is compiled anew in each process.

    Loops fill arrays that they are given, and give back numbers alone: to make an array or a named tuple,
    numba calls Python, and a Ctrl-C that is noticed there ends the process or is lost.
    """
    return _kept(loop)


def unaliased(loop: Loop) -> Loop:
    """A `compiled` loop of which no two arguments share memory; where they do, its numbers are wrong.

    What it writes is then never what it reads next from a table, so that LLVM makes wide instructions of it
    which fetch from several places of the table at once.
    """
    return _kept(loop, pipeline_class=_Unaliased)


def inlined(part: Loop) -> Loop:
    """A part of a `compiled` loop of the same module, written into it where it is called.

    For what is called for every row of pixels, where a call costs as much as the work.
    """
    return cast(Loop, numba.njit(part, inline="always", **_OPTIONS))


class _Unaliased(CompilerBase):
    """numba's compiler, which tells LLVM that arguments do not overlap."""

    def define_pipelines(self) -> list[Any]:
        self.state.flags.noalias = True
        return [DefaultPassBuilder.define_nopython_pipeline(self.state)]


def _kept(loop: Loop, **more: Any) -> Loop:
    code = numba.njit(loop, **_OPTIONS, **more)
    with suppress(RuntimeError):  # "no locator available": numba found no folder to write to
        code._cache = KeptCode(loop)  # type: ignore[attr-defined]
    return cast(Loop, code)
