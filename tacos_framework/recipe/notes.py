"""Notes of a recipe that quote its settings, so that they stay true whatever ``--set`` has changed."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

_QUOTED = re.compile(r"\{([\w.-]+)\}")


def quoting(note: str, recipe: Mapping[str, Any]) -> str:
    """The note with every ``{dotted.key}`` replaced by the recipe's value.

    Raises `ValueError` where a key is not in the recipe, or stands for more than one value.

    >>> quoting("Averages {rig.binning} x {rig.binning} photosites.", {"rig": {"binning": 4}})
    'Averages 4 x 4 photosites.'
    """
    return _QUOTED.sub(lambda match: _value(match[1], recipe), note)


def _value(key: str, recipe: Mapping[str, Any]) -> str:
    found: Any = recipe
    for part in key.split("."):
        found = found.get(part) if isinstance(found, Mapping) else None
    if isinstance(found, bool) or not isinstance(found, str | int | float):
        raise ValueError(f"a note quotes {{{key}}}, which is no number or text of this recipe")
    return found if isinstance(found, str) else f"{found:g}"
