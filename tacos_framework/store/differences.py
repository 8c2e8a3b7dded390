"""Differences of two recipes, key by key."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from itertools import zip_longest
from typing import Any

_ABSENT = object()
_LONGEST = 60
"""Characters of a value that a sentence shows."""


def differences(before: Any, now: Any, name: str = "") -> Iterator[str]:
    """Sentences on the values that differ, each with its dotted key.

    `before`, `now`: plain data, such as recipes. `name`: what it is called, where it is not the top.

    >>> before = {"seed": 7, "effects": [{"use": "effect.jpeg"}]}
    >>> for sentence in differences(before, {"seed": 8, "effects": [], "study": {"blocks": 3}}):
    ...     print(sentence)
    effects.0 was {"use": "effect.jpeg"}, and is not given
    seed was 7, and is 8 now
    study was not given, and is {"blocks": 3} now
    """
    if before == now:
        return
    if isinstance(before, Mapping) and isinstance(now, Mapping):
        for key in sorted({*before, *now}):
            yield from differences(before.get(key, _ABSENT), now.get(key, _ABSENT), _below(name, key))
    elif isinstance(before, list | tuple) and isinstance(now, list | tuple):
        for index, (old, new) in enumerate(zip_longest(before, now, fillvalue=_ABSENT)):
            yield from differences(old, new, _below(name, index))
    else:
        yield f"{name} was {_shown(before)}, and is {_shown(now)}{'' if now is _ABSENT else ' now'}"


def _below(name: str, key: str | int) -> str:
    return f"{name}.{key}" if name else str(key)


def _shown(value: Any) -> str:
    if value is _ABSENT:
        return "not given"
    shown = json.dumps(value, default=str)
    return shown if len(shown) <= _LONGEST else f"{shown[: _LONGEST - 3]}..."
