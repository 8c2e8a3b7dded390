"""Worlds shared by the tests of scene.indoor: each takes seconds to build."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_framework.values import Episode
from tacos_worlds.indoor.building import Building, draw_building
from tacos_worlds.indoor.furnishing.catalogue import Catalogue
from tacos_worlds.indoor.scene import IndoorScene

LUX = 20.0


def draw(seed: int, size_m: tuple[float, float] = (15.0, 15.0)) -> Building:
    """A furnished building, without light and textures."""
    return draw_building(
        np.random.default_rng(seed),
        size_m=size_m,
        ceiling_height_m=3.0,
        min_room_m=5.0,
        clutter=0.5,
        people=1.0,
        catalogue=Catalogue(),
    )


@pytest.fixture(scope="session")
def episode() -> Episode:
    """The default scene, 500 frames."""
    scene = IndoorScene(IndoorScene.Config())
    return scene.episode(rng=np.random.default_rng(7), illumination_lux=LUX)


@pytest.fixture(scope="session")
def buildings() -> list[Building]:
    """Buildings of several seeds."""
    return [draw(seed) for seed in range(4)]
