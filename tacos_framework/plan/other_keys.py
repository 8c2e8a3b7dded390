"""Where else a setting of some name is to be found: design variables are called by what they belong to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from tacos_framework.errors import did_you_mean
from tacos_framework.plan.component import ConfiguredComponent
from tacos_framework.plan.targets import EXPOSURE
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Scenario
from tacos_framework.synonyms import meant


def keys_of_recipe(
    rig: ConfiguredComponent | None,
    nodes: Mapping[str, ConfiguredComponent],
    effects: Mapping[str, ConfiguredComponent],
    exposure: ConfiguredComponent | None,
) -> dict[str, str]:
    """Names of settings, and the keys under ``design:`` that set them; of several the likeliest."""
    named: dict[str, str] = {}
    owners = [("", rig.cls.Variables.model_fields)] if rig else []
    owners += [("scenario.", Scenario.model_fields)]
    owners += [(f"{EXPOSURE}.", exposure.cls.Config.model_fields)] if exposure else []
    owners += [(f"effects.{name}.", part.cls.Config.model_fields) for name, part in effects.items()]
    owners += [(f"{name}.", part.cls.Config.model_fields) for name, part in nodes.items()]
    for owner, fields in owners:
        for name in fields:
            named.setdefault(name, f"{owner}{name}")
    return named


def remedy_for(
    setting: str, own: Mapping[str, object], keys: Mapping[str, str], plugins: Plugins, *, alone: bool
) -> str:
    """What to do about a design variable whose owner has no such setting.

    Parameters
    ----------
    setting
        The name that is not known.
    own
        What its owner does have.
    keys
        What the recipe has; see `keys_of_recipe`.
    plugins
        Whose effects are looked through last: a camera may have them, and the recipe not.
    alone
        Whether the name stood alone, with no owner: then a setting called so elsewhere is the likeliest.
    """
    near = did_you_mean(setting, own)
    of_owner = near.startswith("Did you mean") and not (alone and setting in keys)
    name = setting if setting in keys else meant(setting, keys)
    if of_owner:
        return near
    if name is not None:
        return f"Did you mean {keys[name]!r}?"
    known = [(use, setting if setting in has else meant(setting, has)) for use, has in _effects(plugins)]
    having = [(use, name) for use, name in known if name is not None]
    if not having:
        return near
    named = " or ".join(f"'effects.{use.partition('.')[2]}.{name}'" for use, name in having)
    return f"Did you mean {named}? The recipe needs the effect: effects: [{{use: {having[0][0]}}}]."


def _effects(plugins: Plugins) -> Iterator[tuple[str, Mapping[str, object]]]:
    """Effects that can be imported, with their settings."""
    for registered in plugins:
        component = registered.component
        if component.kind != "effect" or component.missing_packages():
            continue
        try:
            yield component.use, plugins.resolve(component.use).Config.model_fields
        except Exception:  # noqa: BLE001 - one that is broken is told where it is asked for, not as a hint
            continue
