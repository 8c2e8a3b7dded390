"""A candidate's values, sorted by what they set: nodes, effects, scenarios."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from tacos_framework.plan import ConfiguredComponent, target_of


@dataclass(frozen=True)
class SettingOverrides:
    """Settings that a candidate replaces, by the name of a node or effect."""

    settings: dict[str, dict[str, Any]] = field(default_factory=dict)
    """``{name: {setting: value}}``, for all cameras."""
    by_camera: dict[str, dict[str, dict[str, Any]]] = field(default_factory=dict)
    """``{name: {camera: {setting: value}}}``, for one camera on top of those."""

    def parts(
        self, name: str, part: ConfiguredComponent
    ) -> tuple[ConfiguredComponent, dict[str, ConfiguredComponent]]:
        """A component with the candidate's settings, and that of each camera that has settings of its own."""
        settings = self.settings.get(name, {})
        own = self.by_camera.get(name, {})
        return part.with_settings(settings), {
            camera: part.with_settings({**settings, **values}) for camera, values in own.items()
        }


@dataclass(frozen=True)
class Overrides:
    """Settings of a candidate beside the variables of the rig."""

    nodes: SettingOverrides = field(default_factory=SettingOverrides)
    effects: SettingOverrides = field(default_factory=SettingOverrides)
    exposure: SettingOverrides = field(default_factory=SettingOverrides)
    """Settings of nodes, of the effects of the recipe, and of its exposure control."""
    scenarios: dict[str, dict[str, Any]] = field(default_factory=dict)
    """``{name: {key: value}}``; what holds for all of them stands under ``""``."""

    def of_scenario(self, name: str) -> dict[str, Any]:
        """Settings of a scenario; its own take precedence over those of all."""
        return {**self.scenarios.get("", {}), **self.scenarios.get(name, {})}


def overrides_of(values: Mapping[str, Any], effects: Sequence[str]) -> Overrides:
    """Sort a candidate's values by what they set.

    `values`: plain values by the names of design variables. `effects`: names of the recipe's effects, in its
    order.

    >>> overrides = overrides_of({"pitch_deg": 3, "isp.gamma": 2.2, "effects.0.left.quality": 50}, ["jpeg"])
    >>> overrides.nodes.settings, overrides.effects.by_camera
    ({'isp': {'gamma': 2.2}}, {'jpeg': {'left': {'quality': 50}}})
    """
    found = Overrides()
    groups = {"node": found.nodes, "effect": found.effects, "exposure": found.exposure}
    for name, value in values.items():
        target = target_of(name, effects)
        if target.kind == "scenario":
            found.scenarios.setdefault(target.owner, {})[target.setting] = value
        elif target.kind in groups:
            group = groups[target.kind]
            if target.camera is None:
                place = group.settings.setdefault(target.owner, {})
            else:
                place = group.by_camera.setdefault(target.owner, {}).setdefault(target.camera, {})
            place[target.setting] = value
    return found
