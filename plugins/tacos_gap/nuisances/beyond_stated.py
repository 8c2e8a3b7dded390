"""Light that captures ask for beyond what was stated of it: allowed for, and said."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tacos_gap.captures import RealCapture

FAR = 2.0
"""Standard deviations of ``level_uncertainty`` from which on a gain is said to be unlikely."""


def light_beyond_stated(
    captures: Sequence[RealCapture], nuisances: Mapping[str, Mapping[str, Any]]
) -> list[str]:
    """In a sentence each for brighter and dimmer captures: by how much, and what would make it a cause.

    - `nuisances`: for each capture what its expectation is off by, as in ``diagnosis.json``.

    >>> from types import SimpleNamespace as Capture
    >>> lamp = {"id": "flat", "level_uncertainty": 0.05}
    >>> light_beyond_stated([Capture(**lamp)], {"flat": {"gain": 1.08}})
    []
    >>> print(*light_beyond_stated([Capture(**lamp)], {"flat": {"gain": 1.15}}))  # doctest: +ELLIPSIS
    flat: the light is 15 % above what is expected, more than twice ...
    """
    off = {
        capture.id: float(np.mean(nuisances[capture.id]["gain"])) - 1
        for capture in captures
        if "gain" in nuisances.get(capture.id, {})
    }
    stated = {capture.id: capture.level_uncertainty for capture in captures}
    said = []
    for side, way in ((1, "above"), (-1, "below")):
        far = {name: abs(gain) for name, gain in off.items() if side * gain > FAR * stated[name]}
        if far:
            percents = dict.fromkeys(f"{100 * end(far.values()):.0f}" for end in (min, max))
            said.append(
                f"{', '.join(far)}: the light is {' to '.join(percents)} % {way} what is expected, more than "
                f"twice the `level_uncertainty` that is stated, and is taken for the lamp's. If it is known "
                f"better, state a smaller one: then a cause is looked for."
            )
    return said
