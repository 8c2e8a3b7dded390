"""Arrays that mean something: what is not finite is refused, with who made it so."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.errors import ContractBroken


def checked_samples(component: str, samples_dn: Any, like: NDArray[Any]) -> NDArray[Any]:
    """Samples or light that a component made of others, if they are of the shape of those and finite.

    `component`: its name in messages. `like`: (N, H, W, C) what it was given; the number of channels may have
    changed.

    Raises `ContractBroken` when they are not.
    """
    if not isinstance(samples_dn, np.ndarray):
        raise ContractBroken(f"{component} gives a {type(samples_dn).__name__} where an array is expected")
    if samples_dn.ndim != like.ndim or samples_dn.shape[:-1] != like.shape[:-1]:
        raise ContractBroken(
            f"{component} gives an array of the shape {samples_dn.shape} for one of {like.shape}"
        )
    try:
        check_finite(component, samples_dn, "samples")
    except ContractBroken:
        if np.isfinite(like).all():  # else they were so before
            raise
    return samples_dn


def check_finite(component: str, array: NDArray[Any], what: str, first_frame: int = 0) -> None:
    """Refuse an array of floats that is not finite."""
    if not np.issubdtype(array.dtype, np.inexact):
        return
    with np.errstate(all="ignore"):
        # One pass, without memory where they lie side by side; what overflows is looked at below.
        if np.isfinite(np.vdot(array, array)):
            return
    if not (finite := np.isfinite(array)).all():
        refuse(component, array, ~finite, what, first_frame)


def refuse(
    component: str, array: NDArray[Any], wrong: NDArray[np.bool_], what: str, first_frame: int = 0
) -> None:
    """Say how many values are wrong, and which is the first.

    `array`, `wrong`: the values, and which of them are wrong. `first_frame`: number of the first frame in its
    episode, for arrays of frames.
    """
    index = tuple(int(i) for i in np.unravel_index(int(wrong.argmax()), wrong.shape))
    place = f"index {index}"
    if 3 <= array.ndim <= 4:
        names = ("frame", "row", "column", "channel")
        numbers = (index[0] + first_frame, *index[1:])
        place = ", ".join(f"{name} {number}" for name, number in zip(names, numbers, strict=False))
    raise ContractBroken(
        f"{component} gives {array[index]:g} as {what} in {int(wrong.sum())} of {wrong.size} values, "
        f"the first at {place}"
    )
