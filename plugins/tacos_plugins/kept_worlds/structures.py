"""Frozen dataclasses of arrays as plain data and a list of arrays, and back: nothing is pickled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


class CannotBeKept(TypeError):
    """A value holds something that is neither plain data, an array, nor a class that is known."""


def taken_apart(value: Any, classes: Sequence[type[Any]]) -> tuple[Any, list[Array]]:
    """Plain data that JSON can hold, and the arrays it refers to by number, each once.

    `value`: dataclasses of `classes`, tuples, lists, numbers, text, None and arrays, nested. `classes`: the
    dataclasses that may occur; subclasses of theirs may not, as they may hold what is not a field.

    Raises `CannotBeKept` when anything else occurs in it.

    >>> taken_apart((1.5, None), [])
    ({'tuple': [1.5, None]}, [])
    """
    names = {cls: cls.__qualname__ for cls in classes}
    arrays: list[Array] = []
    known: dict[tuple[Any, ...], int] = {}

    def plain(part: Any) -> Any:
        match part:
            case np.ndarray():
                return {"array": number_of(part), "transposed": _is_transposed(part)}
            case np.generic():
                return {"scalar": number_of(np.asarray(part))}
            case None | bool() | int() | float() | str():
                return part
            case tuple():
                return {"tuple": [plain(each) for each in part]}
            case list():
                return {"list": [plain(each) for each in part]}
        if type(part) in names and is_dataclass(part):
            of = {field.name: plain(getattr(part, field.name)) for field in fields(part)}
            return {"class": names[type(part)], "fields": of}
        raise CannotBeKept(f"a {type(part).__name__} cannot be kept")

    def number_of(array: Array) -> int:
        if array.dtype.kind not in "biuf":
            raise CannotBeKept(f"an array of {array.dtype} cannot be kept")
        place = (array.__array_interface__["data"][0], array.shape, array.strides, array.dtype.str)
        if array.size == 0 or place not in known:  # empty arrays may share an address with anything
            known[place] = len(arrays)
            arrays.append(np.asarray(array.T if _is_transposed(array) else array, order="C"))
        return known[place]

    return plain(value), arrays


def put_together(plain: Any, arrays: Sequence[Array], classes: Sequence[type[Any]]) -> Any:
    """Undoes `taken_apart`; arrays that were one are one again."""
    by_name = {cls.__qualname__: cls for cls in classes}

    def whole(part: Any) -> Any:
        match part:
            case {"array": number, "transposed": transposed}:
                return arrays[number].T if transposed else arrays[number]
            case {"scalar": number}:
                return arrays[number].reshape(())[()]
            case {"tuple": parts}:
                return tuple(whole(each) for each in parts)
            case {"list": parts}:
                return [whole(each) for each in parts]
            case {"class": name, "fields": Mapping() as of}:
                return by_name[name](**{field: whole(each) for field, each in of.items()})
        return part

    return whole(plain)


def _is_transposed(array: Array) -> bool:
    """True if it lies in memory column by column: the order of sums, and so their bits, follows it."""
    return bool(array.flags.f_contiguous and not array.flags.c_contiguous)
