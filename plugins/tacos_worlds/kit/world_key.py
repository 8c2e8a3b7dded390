"""The content key of a world: what renderers upload and bake once for."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from tacos_framework import World, content_key


def world_key(name: str, world: World, *settled_later: float) -> str:
    """A name, and a key of everything that a world is made of but the light that is baked into it.

    `world`: before its light is baked, from which that follows. `settled_later`: what else decides the light,
    such as the illuminance it is scaled to [lux].
    """
    made_of = [
        _plain(each) for kind in (world.parts, world.materials, world.objects, world.lights) for each in kind
    ]
    around = (world.class_names, world.ambient_cd_m2, world.sky_cd_m2)
    return f"{name}-{content_key(made_of, around, settled_later)}"


def _plain(value: Any) -> tuple[Any, ...]:
    return tuple(getattr(value, each.name) for each in fields(value))
