"""Components and rigs from their names and settings, outside of a graph."""

from __future__ import annotations

from typing import Any

from tacos_framework import (
    Episode,
    Fault,
    KeyPath,
    Plugins,
    Rig,
    Settings,
    Use,
    UserError,
    also_called,
    check,
    did_you_mean,
    signature_of,
)
from tacos_framework.plan import ConfiguredComponent


def part_of(use: Use, kind: str, plugins: Plugins) -> ConfiguredComponent:
    """A component class with its settings; raises a `UserError` with all that is wrong with them."""
    cls = plugins.resolve(use.use, kind, where=use.use)
    config = _checked(cls.Config, use.settings, use.use)
    return ConfiguredComponent(use.use, cls, config, plugins.distribution_of(use.use))


def build(use: Use, kind: str, plugins: Plugins) -> Any:
    """A component; raises as `part_of` does."""
    return part_of(use, kind, plugins).make()


def build_rig(use: Use, plugins: Plugins) -> Rig:
    """A rig from its settings and variables, told apart by name; raises as `part_of` does."""
    cls = plugins.resolve(use.use, "rig", where=use.use)
    variables, settings = cls.Variables.model_fields, cls.Config.model_fields
    if unknown := [name for name in use.settings if name not in variables and name not in settings]:
        known, called = [*variables, *settings], also_called(cls.Variables) | also_called(cls.Config)
        raise UserError(
            [
                Fault(use.use, f"unknown key {name!r}", "", did_you_mean(name, known, called))
                for name in unknown
            ]
        )
    of_variables = {name: value for name, value in use.settings.items() if name in variables}
    of_config = {name: value for name, value in use.settings.items() if name in settings}
    rig: Rig = cls(_checked(cls.Config, of_config, use.use)).build(
        _checked(cls.Variables, of_variables, use.use)
    )
    return rig


def episode_of(scene: Any, **offered: Any) -> Episode:
    """An episode of a scene, which is given what it asks for of what is offered."""
    wanted = signature_of(type(scene), "scene").supplied
    episode: Episode = scene.episode(**{name: value for name, value in offered.items() if name in wanted})
    return episode


def _checked(kind: type[Settings], settings: dict[str, Any], name: str) -> Settings:
    def where(path: KeyPath) -> str:
        return ".".join(map(str, (name, *path)))

    checked, faults, _ = check(kind, settings, where)
    if faults or checked is None:
        raise UserError(faults)
    return checked
