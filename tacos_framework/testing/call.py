"""Calling a component as the framework does: with the keywords it asks for."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any


def supplied(method: Callable[..., Any], **offered: Any) -> dict[str, Any]:
    """Of the keyword arguments the framework offers, those the method has as keyword-only parameters.

    >>> def expose(capture, *, rng): ...
    >>> supplied(expose, rng=1, exposure=2)
    {'rng': 1}
    """
    parameters = inspect.signature(method).parameters
    return {
        name: value
        for name, value in offered.items()
        if name in parameters and parameters[name].kind is inspect.Parameter.KEYWORD_ONLY
    }
