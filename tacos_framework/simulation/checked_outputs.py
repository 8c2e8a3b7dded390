"""Light and depth that mean something: what a component gives is looked at before others build on it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.errors import ContractBroken
from tacos_framework.values import Capture, View


def checked_output(component: str, value: Any) -> Any:
    """What a component gave, if it can be built on.

    Light must be finite and depth a number, where infinity means that nothing is there. Arrays of floats, and
    lists and mappings of them, must be finite too. Frames are whole numbers, which their own type checks; the
    values of plugins' own types are theirs to check.

    Parameters
    ----------
    component
        Its name in messages.
    value
        What it gave.

    Raises
    ------
    ContractBroken
        When it cannot; the message says what is wrong and where it begins.
    """
    match value:
        case Capture():
            for view in value.views:
                _check_view(component, view)
        case np.ndarray():
            _check_finite(component, value, "values")
        case list() | tuple():
            for each in value:
                checked_output(component, each)
        case dict():
            for each in value.values():
                checked_output(component, each)
        case None:
            raise ContractBroken(f"{component} gives nothing")
    return value


def checked_samples(component: str, samples_dn: Any, like: NDArray[Any]) -> NDArray[Any]:
    """Samples or light that a component made of others, if they are of the shape of those and finite.

    Parameters
    ----------
    component
        Its name in messages.
    samples_dn
        What it gave.
    like
        (N, H, W, C) what it was given; the number of channels may have changed.

    Raises
    ------
    ContractBroken
        When they are not.
    """
    if not isinstance(samples_dn, np.ndarray):
        raise ContractBroken(f"{component} gives a {type(samples_dn).__name__} where an array is expected")
    if samples_dn.ndim != like.ndim or samples_dn.shape[:-1] != like.shape[:-1]:
        raise ContractBroken(
            f"{component} gives an array of the shape {samples_dn.shape} for one of {like.shape}"
        )
    _check_finite(component, samples_dn, "samples")
    return samples_dn


def checked_scores(component: str, scores: Any) -> dict[str, float]:
    """The scores a task reports, if they are numbers by name.

    Raises
    ------
    ContractBroken
        When they are not, or one is not finite: a score without meaning in an episode is left out.
    """
    if not isinstance(scores, Mapping):
        raise ContractBroken(f"{component} reports {scores!r} where scores by name are expected")
    for name, value in scores.items():
        number = np.asarray(value)
        if number.ndim or number.dtype.kind not in "biuf":
            raise ContractBroken(f"{component} reports {value!r} as its score {name!r}, not a number")
        if not np.isfinite(number):
            raise ContractBroken(f"{component} reports {float(value)} as its score {name!r}")
    return {str(name): float(value) for name, value in scores.items()}


def _check_view(component: str, view: View) -> None:
    of = f" of camera {view.camera.name!r}"
    _check_finite(component, view.luminance_cd_m2, f"light{of}")
    if (
        view.depth_m.size and not view.depth_m.min() > -np.inf
    ):  # one pass: the least of numbers and NaN is NaN
        _refuse(component, view.depth_m, np.isnan(view.depth_m) | (view.depth_m == -np.inf), f"depth{of}")
    if not np.isfinite(view.world_from_camera).all():
        raise ContractBroken(f"{component} gives poses{of} that are not finite")


def _check_finite(component: str, array: NDArray[Any], what: str) -> None:
    if not np.issubdtype(array.dtype, np.inexact):
        return
    with np.errstate(all="ignore"):
        if np.isfinite(array.sum()):  # one pass without memory; sums that overflow are looked at below
            return
    if not (finite := np.isfinite(array)).all():
        _refuse(component, array, ~finite, what)


def _refuse(component: str, array: NDArray[Any], wrong: NDArray[np.bool_], what: str) -> None:
    """Say how many values are wrong, and which is the first."""
    first = tuple(int(i) for i in np.unravel_index(int(wrong.argmax()), wrong.shape))
    names = ("frame", "row", "column", "channel")
    place = ", ".join(f"{name} {i}" for name, i in zip(names, first, strict=False))
    if not 3 <= array.ndim <= 4:
        place = f"index {first}"
    raise ContractBroken(
        f"{component} gives {array[first]:g} as {what} in {int(wrong.sum())} of {wrong.size} values, "
        f"the first at {place}"
    )
