"""Photographs that an import leaves out, and why, in sentences."""

from __future__ import annotations

from collections.abc import Iterable

from tacos_framework import Fault
from tacos_gap.report.words import listed

_NAMED = 20
"""Files that are named before the rest are counted."""


def left_out(reasons: Iterable[tuple[str, str]]) -> list[str]:
    """Reasons why files are left out, those of one reason together.

    - `reasons`: name of each file, and what is said of it, without a full stop at its end.

    >>> left_out([("a.png", "has 8 bits"), ("b.png", "is empty"), ("c.png", "is empty")])
    ['a.png is left out: it has 8 bits.', 'b.png and c.png are left out: each is empty.']
    """
    names: dict[str, list[str]] = {}
    for name, why in reasons:
        names.setdefault(why, []).append(name)
    return [
        f"{those[0]} is left out: it {why}."
        if len(those) == 1
        else f"{_first_of(those)} are left out: each {why}."
        for why, those in names.items()
    ]


def why_unreadable(given_name: str, shown_name: str, fault: Fault) -> str:
    """A fault of a file, as what is said of it, with what to do.

    `given_name`, `shown_name`: the file's name on the disk, which the fault calls it by, and the one that can
    be printed. `fault`: what is wrong with it.
    """
    what = fault.what.removeprefix(f"{given_name} ")
    if what == fault.what:  # not said of the file itself
        what = f"cannot be used: {what.replace(given_name, shown_name)}"
    instead = fault.remedy or (fault.expected and f"Expected: {fault.expected}")
    return f"{what}. {instead}".rstrip(". ")


def _first_of(names: list[str]) -> str:
    rest = len(names) - _NAMED
    return listed([*names[:_NAMED], f"{rest} more"] if rest > 0 else names)
