"""Light and depth that mean something: what a component gives is looked at before others build on it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from tacos_framework.errors import ContractBroken
from tacos_framework.formation.checked import check_finite, refuse
from tacos_framework.values import Capture, View


def checked_output(component: str, value: Any) -> Any:
    """The output of a component, if it can be built on.

    Light must be finite and depth a number, where infinity means that nothing is there. Arrays of floats, and
    lists and mappings of them, must be finite too. Frames are whole numbers, which their own type checks; the
    values of plugins' own types are theirs to check.

    `component`: its name in messages.

    Raises `ContractBroken` when it cannot; the message says what is wrong and where it begins.
    """
    match value:
        case Capture():
            for view in value.views:
                _check_view(component, view, value.episode.first_frame)
        case np.ndarray():
            check_finite(component, value, "values")
        case list() | tuple():
            for each in value:
                checked_output(component, each)
        case dict():
            for each in value.values():
                checked_output(component, each)
        case None:
            raise ContractBroken(f"{component} gives nothing")
    return value


def checked_scores(component: str, scores: Any) -> dict[str, float]:
    """The scores a task reports, if they are numbers by name.

    Raises `ContractBroken` when they are not, or one is not finite: a score without meaning in an episode is
    left out.
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


def _check_view(component: str, view: View, first_frame: int) -> None:
    of = f" of camera {view.camera.name!r}"
    check_finite(component, view.luminance_cd_m2, f"light{of}", first_frame)
    if (
        view.depth_m.size and not view.depth_m.min() > -np.inf
    ):  # one pass: the least of numbers and NaN is NaN
        refuse(
            component,
            view.depth_m,
            np.isnan(view.depth_m) | (view.depth_m == -np.inf),
            f"depth{of}",
            first_frame,
        )
    if not np.isfinite(view.world_from_camera).all():
        raise ContractBroken(f"{component} gives poses{of} that are not finite")
