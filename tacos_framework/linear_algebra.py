"""Number of threads of the linear algebra libraries."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, wraps
from typing import Any, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., Any])


def in_one_thread(function: Function) -> Function:
    """A function during which linear algebra (BLAS) has one thread, in the whole process.

    For matrices of some hundred rows, where threads take longer to wait for one another than to compute, and
    for whatever works side by side already. On two cores that other processes used as well, the analysis of
    a study took thirty times as long with two threads as with one.

    >>> import numpy as np
    >>> from threadpoolctl import threadpool_info
    >>> @in_one_thread
    ... def threads():
    ...     return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}
    >>> threads()
    {1}
    """

    @wraps(function)
    def limited(*args: Any, **kwargs: Any) -> Any:
        with _libraries().limit(limits=1, user_api="blas"):
            return function(*args, **kwargs)

    return cast(Function, limited)


@lru_cache(maxsize=1)
def _libraries() -> Any:
    """The libraries of linear algebra of this process; to find them takes milliseconds."""
    import numpy  # noqa: F401 - they are found once they are loaded
    import scipy.linalg  # noqa: F401
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
