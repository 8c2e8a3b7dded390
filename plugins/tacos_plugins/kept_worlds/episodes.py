"""The store of episodes that simulations are offered."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from tacos_framework import (
    Crossing,
    Episode,
    Light,
    Material,
    MeshPart,
    Mover,
    Object,
    Settings,
    Trajectory,
    World,
    content_key,
)
from tacos_plugins.kept_worlds.fingerprints import code_key, settings_key
from tacos_plugins.kept_worlds.store import WorldStore

CLASSES = (Episode, World, MeshPart, Material, Object, Light, Trajectory, Crossing, Mover)
"""Classes that an episode consists of."""


class StoredEpisodes:
    """Episodes of all scenes in a `WorldStore`; see `tacos_framework.contracts.EpisodeStore`."""

    def __init__(self, store: WorldStore):
        self._store = store

    def episode(
        self, scene: type[Any], config: Settings, follows_from: Mapping[str, Any], make: Callable[[], Episode]
    ) -> Episode:
        """See `tacos_framework.contracts.EpisodeStore.episode`."""
        code = code_key(scene)
        if code is None:
            return make()
        name = f"{scene.__module__}.{scene.__qualname__}"
        key = content_key("episode", name, code, settings_key(config), follows_from)
        return self._store.get(key, make, CLASSES)
