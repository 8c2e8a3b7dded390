"""Other owners of a setting, to suggest for a design variable that names the wrong one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from pydantic import BaseModel

from tacos_framework.errors import did_you_mean
from tacos_framework.plan.component import ConfiguredComponent
from tacos_framework.plan.targets import EXPOSURE
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Scenario
from tacos_framework.settings import also_called
from tacos_framework.suggestions import meant


@dataclass(frozen=True)
class KeyOfSetting:
    """The key under ``design:`` that sets a setting, and what others call that setting."""

    key: str
    also_called: tuple[str, ...]


def keys_of_recipe(
    rig: ConfiguredComponent | None,
    nodes: Mapping[str, ConfiguredComponent],
    effects: Mapping[str, ConfiguredComponent],
    exposure: ConfiguredComponent | None,
) -> dict[str, KeyOfSetting]:
    """Names of settings, and the keys under ``design:`` that set them; of several the likeliest."""
    named: dict[str, KeyOfSetting] = {}
    owners: list[tuple[str, type[BaseModel]]] = [("", rig.cls.Variables)] if rig else []
    owners += [("scenario.", Scenario)]
    owners += [(f"{EXPOSURE}.", exposure.cls.Config)] if exposure else []
    owners += [(f"effects.{name}.", part.cls.Config) for name, part in effects.items()]
    owners += [(f"{name}.", part.cls.Config) for name, part in nodes.items()]
    for owner, settings in owners:
        called = also_called(settings)
        for name in settings.model_fields:
            named.setdefault(name, KeyOfSetting(f"{owner}{name}", called.get(name, ())))
    return named


def remedy_for(
    setting: str, own: type[BaseModel], keys: Mapping[str, KeyOfSetting], plugins: Plugins, *, alone: bool
) -> str:
    """Advice about a design variable whose owner has no such setting.

    - `setting`: the name that is not known.
    - `own`: the settings that its owner does have.
    - `keys`: what the recipe has; see `keys_of_recipe`.
    - `plugins`: whose effects are looked through last: a camera may have them, and the recipe not.
    - `alone`: whether the name stood alone, with no owner: then a setting called so elsewhere is the
      likeliest.
    """
    near = did_you_mean(setting, own.model_fields, also_called(own))
    of_owner = near.startswith("Did you mean") and not (alone and setting in keys)
    name = _this_or_meant(setting, {name: key.also_called for name, key in keys.items()})
    if of_owner:
        return near
    if name is not None:
        return f"Did you mean {keys[name].key!r}?"
    known = [(use, _this_or_meant(setting, called)) for use, called in _effects(plugins)]
    having = [(use, name) for use, name in known if name is not None]
    if not having:
        return near
    named = " or ".join(f"'effects.{use.partition('.')[2]}.{name}'" for use, name in having)
    return f"Did you mean {named}? The recipe needs the effect: effects: [{{use: {having[0][0]}}}]."


def _this_or_meant(setting: str, called: Mapping[str, tuple[str, ...]]) -> str | None:
    """The setting, or the one that others call so; None where there is neither."""
    return setting if setting in called else next(iter(meant(setting, called)), None)


def _effects(plugins: Plugins) -> Iterator[tuple[str, Mapping[str, tuple[str, ...]]]]:
    """Effects that can be imported, with what others call their settings."""
    for registered in plugins:
        component = registered.component
        if component.kind != "effect" or component.missing_packages():
            continue
        try:
            config = plugins.resolve(component.use).Config
            yield component.use, {**dict.fromkeys(config.model_fields, ()), **also_called(config)}
        except Exception:  # noqa: BLE001 - one that is broken is told where it is asked for, not as a hint
            continue
