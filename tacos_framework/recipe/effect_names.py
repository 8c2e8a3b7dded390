"""Names of a recipe's effects, by which design variables reach them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def effect_names(uses: Sequence[tuple[str, str | None]]) -> tuple[str, ...]:
    """A name for each effect: that it was given, or its component's without the kind, counted if it repeats.

    `uses`: for each effect its component, and its name where it has one.

    >>> effect_names([("effect.jpeg", None), ("effect.jpeg", None), ("effect.haze", "fog")])
    ('jpeg', 'jpeg_2', 'fog')
    """
    taken = {name for _, name in uses if name is not None}
    names = []
    for use, name in uses:
        if name is None:
            plain = use.partition(".")[2]
            name, count = plain, 1
            while name in taken:
                count += 1
                name = f"{plain}_{count}"
            taken.add(name)
        names.append(name)
    return tuple(names)


def find_effect(effects: Sequence[Any], called: str) -> int | None:
    """The index of the effect called so in a recipe's plain data, by name or index; None if there is none."""
    entries = [effect if isinstance(effect, dict) else {} for effect in effects]
    given = [effect.get("name") for effect in entries]
    names = effect_names(
        [
            (str(effect.get("use", "")), name if isinstance(name, str) else None)
            for effect, name in zip(entries, given, strict=True)
        ]
    )
    known = {name: i for i, name in enumerate(names)}
    index = int(called) if called.isdecimal() else known.get(called, len(effects))
    return index if index < len(effects) and isinstance(effects[index], dict) else None
