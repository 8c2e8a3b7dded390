"""Light of worlds, kept on disk by world, fineness and renderer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from tacos_framework import World, content_key
from tacos_plugins.kept_worlds.fingerprints import code_key
from tacos_plugins.kept_worlds.store import store_of_user
from tacos_plugins.renderers.light.baked_mesh import BakedMesh, SurfaceLight
from tacos_plugins.renderers.light.flatten import Chunks, FlatMesh
from tacos_plugins.renderers.light.probe_map import ProbeMap
from tacos_plugins.renderers.light.probes import Probe
from tacos_plugins.renderers.moderngl.context import describe_gl

Made = TypeVar("Made")

CLASSES: Sequence[type[Any]] = (BakedMesh, FlatMesh, Chunks, SurfaceLight, Probe, ProbeMap)
"""Classes that light consists of."""


def kept(what: str, world: World, texel_m: float, make: Callable[[], Made]) -> Made:
    """The light made of a world before, in whatever process, or else that of `make`.

    `texel_m`: distance of light map texels [m]. `make`: makes it of `CLASSES`, tuples and arrays.
    """
    store, code = store_of_user(), code_key(BakedMesh)
    if store is None or code is None:
        return make()
    return store.get(content_key(what, world.key, texel_m, str(describe_gl()), code), make, CLASSES)
