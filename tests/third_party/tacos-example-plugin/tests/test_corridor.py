"""The corridor."""

from __future__ import annotations

import numpy as np
from tacos_framework.testing import SceneConformance

from tacos_example.corridor import Corridor


class TestCorridor(SceneConformance):
    component = Corridor


def test_the_agent_stops_a_metre_before_the_board() -> None:
    scene = Corridor(Corridor.Config(length_m=(8.0, 8.0)))
    episode = scene.episode(rng=np.random.default_rng(1), illumination_lux=20.0)
    end = episode.trajectory.at(np.array([1e3]))[0]
    board_x_m = min(part.vertices_m[:, 0].min() for part in episode.world.parts if part.object_id == 1)
    np.testing.assert_allclose(board_x_m - end[0, 3], 1.0, atol=0.01)
