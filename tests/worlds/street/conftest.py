"""A town shared by the tests of scene.street: it takes seconds to build."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_framework.values import Episode
from tacos_worlds.street.scene import StreetScene


@pytest.fixture(scope="session")
def small_drive() -> Episode:
    """Four streets around one block, and 40 frames between them."""
    scene = StreetScene(StreetScene.Config(blocks=1, reach_m=100, frames=40, driving_cars=4, texture_px=128))
    return scene.episode(rng=np.random.default_rng(5), illumination_lux=20_000.0)
