"""Known names that resemble an unknown one."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from difflib import SequenceMatcher
from types import MappingProxyType

MISSPELT = 0.8
"""Likeness in letters from which a name is the given one, misspelt."""

ALIKE = 0.6
"""Likeness in letters from which a name is suggested where nothing better is known; difflib's own."""

SHORTEST = 3
"""Letters of a word that tells anything: units and articles are shorter."""

MOST_SUGGESTED = 3
"""Names that share equally much with the given one are all told, up to so many."""


def suggestions(
    given: str, names: Sequence[str], also_called: Mapping[str, Collection[str]] = MappingProxyType({})
) -> list[str]:
    """Names that may be meant, the likeliest first; none where letters alike would be chance.

    A name that is misspelt comes before one of the same meaning, then those that share words, then those
    alike in letters. What names have in common before their last dot, or as a unit, tells nothing of which
    is meant.

    >>> tasks = ["task.faster-rcnn", "task.orb-features", "task.sgbm"]
    >>> suggestions("task.orb", tasks), suggestions("task.sbgm", tasks), suggestions("task.slam", tasks)
    (['task.orb-features'], ['task.sgbm'], [])
    >>> suggestions("effect.blur", ["effect.lens-blur", "effect.motion-blur", "effect.flare"])
    ['effect.lens-blur', 'effect.motion-blur']
    """
    alike = {name: _likeness(*_told_apart(given, name)) for name in names}
    ranked = sorted(alike, key=lambda name: -alike[name])
    if ranked and alike[ranked[0]] >= MISSPELT:
        return ranked[:1]
    if of_meaning := meant(given, {name: also_called[name] for name in names if name in also_called}):
        return of_meaning[:MOST_SUGGESTED]
    shared = {name: _shared(*_told_apart(given, name)) for name in ranked}
    most = max(shared.values(), default=0.0)
    if most > 0.5:
        return [name for name in ranked if shared[name] == most][:MOST_SUGGESTED]
    return [name for name in ranked[:1] if alike[name] >= ALIKE]


def meant(given: str, also_called: Mapping[str, Collection[str]]) -> list[str]:
    """The names that others call by a given word, or by the first of its parts that they use.

    >>> also_called = {"exposure_ms": ("shutter",), "gain_db": ("iso",), "speed": ("us",)}
    >>> meant("ISO", also_called), meant("shutter_speed_us", also_called), meant("zoom", also_called)
    (['gain_db'], ['exposure_ms'], [])
    """
    word = given.lower().rpartition(".")[2].replace("-", "_")
    for part in (word, word.replace("_", ""), *word.split("_")):
        if found := [name for name, words in also_called.items() if part in words]:
            return found
    return []


def _told_apart(given: str, name: str) -> tuple[str, str]:
    """Two names in lower case without the dotted beginning and the unit that they share.

    >>> _told_apart("task.orb", "task.sgbm"), _told_apart("roll_deg", "Pitch_deg")
    (('orb', 'sgbm'), ('roll', 'pitch'))
    """
    given, name = given.lower(), name.lower()
    head, tail = given.rpartition(".")[0], given.rpartition("_")[2]
    if head and name.startswith(f"{head}."):
        given, name = given[len(head) + 1 :], name[len(head) + 1 :]
    if given.endswith(f"_{tail}") and name.endswith(f"_{tail}"):
        given, name = given[: -len(tail) - 1], name[: -len(tail) - 1]
    return given, name


def _likeness(given: str, name: str) -> float:
    """Share of the letters that two names have in common, in order, 0..1."""
    return SequenceMatcher(None, name, given).ratio()


def _shared(given: str, name: str) -> float:
    """Share of the letters of the given words that are words of the name, or parts of them, 0..1."""
    words, of_name = ([word for word in re.split(r"[\W_]+", each) if word] for each in (given, name))
    letters = sum(
        max((min(len(word), len(other)) for other in of_name if _one_in_other(word, other)), default=0)
        for word in words
    )
    return letters / max(1, sum(map(len, words)))


def _one_in_other(word: str, other: str) -> bool:
    return min(len(word), len(other)) >= SHORTEST and (word in other or other in word)
