"""Targets of design variables: a variable of the rig, or a setting of a node, an effect, the exposure
control, or the scenario."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

EXPOSURE = "exposure"
"""The key of a recipe, and what design variables call the exposure control it names."""


@dataclass(frozen=True)
class Target:
    """The target of a design variable."""

    kind: Literal["rig", "scenario", "exposure", "node", "effect"]
    """Whose variable or setting it is."""
    owner: str
    """Name of the node, effect or scenario; empty for the rig, and for all scenarios together; ``exposure``
    for its control.
    """
    setting: str
    camera: str | None = None
    """The camera it is set for; None for all."""


def target_of(name: str, effects: Sequence[str]) -> Target:
    """The target that the name of a design variable describes, whether or not it exists.

    `name`: ``pitch_deg``, ``isp.gamma``, ``effects.jpeg.left.quality``, ``scenario.night.gain_db``.
    `effects`: names of the effects in the order of the recipe, which may also be counted:
    ``effects.0.quality``.

    >>> target_of("effects.0.left.quality", ["jpeg"])
    Target(kind='effect', owner='jpeg', setting='quality', camera='left')
    """
    head, dot, rest = name.partition(".")
    if not dot:
        return Target("rig", "", name)
    if head == "scenario":
        owner, _, setting = rest.rpartition(".")
        return Target("scenario", owner, setting)
    if head == EXPOSURE:
        return Target("exposure", EXPOSURE, rest)
    if head == "effects":
        owner, _, rest = rest.partition(".")
        if owner.isdecimal() and int(owner) < len(effects):
            owner = effects[int(owner)]
        return Target("effect", owner, *_setting(rest))
    return Target("node", head, *_setting(rest))


def _setting(rest: str) -> tuple[str, str | None]:
    """``quality`` or ``left.quality``: the setting, and the camera."""
    camera, _, setting = rest.rpartition(".")
    return setting, camera or None
