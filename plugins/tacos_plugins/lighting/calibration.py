"""Scaling the light of a world to a given illuminance. Light is linear, so one factor does it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_framework import World
from tacos_plugins.lighting.emitters import photopic
from tacos_plugins.lighting.transport import LightTransport


def scale_light(world: World, factor: float, *, key: str) -> World:
    """The world with all light (sources, emission, indirect, ambient) multiplied by a factor.

    `factor`: by which luminances, fluxes and illuminances are multiplied [1].
    """
    indirect = world.indirect_lux
    return replace(
        world,
        key=key,
        lights=tuple(replace(light, flux_lm=light.flux_lm * factor) for light in world.lights),
        materials=tuple(
            replace(material, emission_cd_m2=material.emission_cd_m2 * factor)
            if material.emission_cd_m2.any()
            else material
            for material in world.materials
        ),
        indirect_lux=None if indirect is None else tuple(lux * np.float32(factor) for lux in indirect),
        ambient_cd_m2=world.ambient_cd_m2 * factor,
        sky_cd_m2=None if world.sky_cd_m2 is None else world.sky_cd_m2 * np.float32(factor),
        unscaled=None,
        light_factor=1.0,
    )


def with_illuminance(
    world: World, illumination_lux: float, plane_m: NDArray[np.float32], *, key: str, rays: int = 64
) -> World:
    """The world with indirect light baked, lit so that the mean illuminance on a plane is as given.

    - `illumination_lux`: mean illuminance, direct and indirect, over the points of the plane [lux].
    - `plane_m`: (N, 3) float32 points of a horizontal plane, spread evenly [m].
    - `key`: content key of the new world.
    - `rays`: rays per place for indirect light.

    Raises `ValueError` when no light reaches the plane.
    """
    transport = LightTransport(world, rays=rays)
    up = np.tile(np.array([0, 0, 1], np.float32), (len(plane_m), 1))
    reached = transport.direct_lux(plane_m, up) + transport.indirect_lux(plane_m, up)
    mean_lux = float(photopic(reached).mean())
    if not mean_lux > 0:
        raise ValueError("no light reaches the plane, so no factor gives it an illuminance")
    baked = replace(world, indirect_lux=transport.vertex_indirect_lux())
    return scale_light(baked, illumination_lux / mean_lux, key=key)
