"""Checking and freezing the arrays inside values."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike


def read_only(owner: Any, name: str, dtype: DTypeLike, shape: tuple[int | None, ...]) -> None:
    """Replace ``owner.name`` by a read-only array of `dtype`, or refuse it.

    `shape`: the expected shape; ``None`` stands for any length.

    Raises `ValueError` when the shape differs, with both shapes in the message.
    """
    array = np.asarray(getattr(owner, name), dtype=dtype)
    matches = array.ndim == len(shape) and all(
        want is None or want == have for want, have in zip(shape, array.shape, strict=True)
    )
    if not matches:
        wanted = ", ".join("any" if n is None else str(n) for n in shape)
        raise ValueError(f"{type(owner).__name__}.{name} has shape {array.shape}, expected ({wanted})")
    view = array.view()
    view.flags.writeable = False
    object.__setattr__(owner, name, view)
