"""Content keys, and a small store of what is costly to make again."""

from __future__ import annotations

import ctypes
import hashlib
import json
import math
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from typing import Any, Generic, TypeVar

import numpy as np

Made = TypeVar("Made")


def content_key(*parts: Any) -> str:
    """A key that is equal for equal content: 32 hexadecimal digits, the same in every process.

    Takes JSON values, tuples, numpy arrays and numbers, and mappings of them, nested.

    Raises `TypeError` for anything whose content is not plain data, rather than keying it by identity.
    """
    digest = hashlib.blake2b(digest_size=16)
    _feed(digest, parts)
    return digest.hexdigest()


def _feed(digest: hashlib.blake2b, value: Any) -> None:
    if isinstance(value, np.ndarray):
        digest.update(f"a{value.dtype.str}{value.shape}".encode())
        digest.update(np.ascontiguousarray(value).tobytes())
    elif isinstance(value, np.generic):
        _feed(digest, value.item())
    elif isinstance(value, Mapping):
        digest.update(f"m{len(value)}".encode())
        for key in sorted(value, key=str):
            _feed(digest, str(key))
            _feed(digest, value[key])
    elif isinstance(value, list | tuple):
        digest.update(f"l{len(value)}".encode())
        for item in value:
            _feed(digest, item)
    elif value is None or isinstance(value, str | bool | int | float):
        text = json.dumps(value)
        digest.update(f"v{len(text)}:{text}".encode())
    else:
        raise TypeError(f"cannot make a content key of a {type(value).__name__}")


def _give_back_memory() -> None:
    """Return what was freed to the system, where glibc would keep it in pieces.

    A world is some hundred thousand allocations; without this, memory creeps up by about ten megabytes with
    each new one, although nothing holds on to it.
    """
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)


class LRUCache(Generic[Made]):
    """The most recently used things, made when first asked for.

    - `size`: how many at most.
    - `most_bytes`: memory they may take together; a thing larger than that is held alone [bytes].
    - `bytes_of`: memory a thing takes; without it, any number of bytes will do [bytes].
    - `let_go`: told of each thing that is held no longer.

    >>> squares = LRUCache(size=2)
    >>> squares.get(3, lambda: 9)
    9
    >>> squares.get(3, lambda: 0)
    9
    """

    def __init__(
        self,
        size: int,
        most_bytes: float = math.inf,
        bytes_of: Callable[[Made], int] = lambda _: 0,
        let_go: Callable[[Made], object] = lambda _: None,
    ):
        if size < 1:
            raise ValueError(f"an LRU cache of size {size} holds nothing")
        self._size, self.most_bytes = size, most_bytes
        self._bytes_of, self._let_go = bytes_of, let_go
        self._held: OrderedDict[Hashable, Made] = OrderedDict()

    def get(self, key: Hashable, make: Callable[[], Made]) -> Made:
        """The entry under `key`, made by `make` and kept if it is not there yet."""
        if key in self._held:
            self._held.move_to_end(key)
        else:
            while self._held and not self._has_room():  # let go first: one more may not fit
                self._let_go(self._held.popitem(last=False)[1])
                _give_back_memory()
            self._held[key] = make()
        return self._held[key]

    def _has_room(self) -> bool:
        """True if one more entry as large as the largest fits."""
        sizes = [self._bytes_of(each) for each in self._held.values()]
        return len(sizes) < self._size and sum(sizes) + max(sizes) <= self.most_bytes
