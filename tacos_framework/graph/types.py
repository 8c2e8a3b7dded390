"""Compatibility of the types of two ports."""

from __future__ import annotations

from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin


def fits(given: Any, taken: Any) -> bool:
    """True if a value of the type `given` may go where `taken` is expected.

    Classes fit their base classes, and a union takes what any of its members takes. Parameters of generic
    types must be equal. Types that plugins define are as good as any.

    >>> fits(bool, int), fits(int, bool), fits(int, int | str), fits(list[int], list[str])
    (True, False, True, False)
    """
    if get_origin(given) is Annotated:
        return fits(get_args(given)[0], taken)
    if get_origin(taken) is Annotated:
        return fits(given, get_args(taken)[0])
    if Any in (given, taken) or given == taken:
        return True
    if get_origin(given) in (Union, UnionType):
        return all(fits(member, taken) for member in get_args(given))
    if get_origin(taken) in (Union, UnionType):
        return any(fits(given, member) for member in get_args(taken))
    source, target = get_origin(given) or given, taken
    return isinstance(source, type) and isinstance(target, type) and issubclass(source, target)


def type_name(kind: Any) -> str:
    return kind.__name__ if isinstance(kind, type) and get_origin(kind) is None else str(kind)
