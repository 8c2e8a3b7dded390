"""Blur along one direction is spoken of where edges of two directions could show it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tacos_plugins.effects.observations import edges_of_one_direction, edges_or_known_motion
from tests.gap.small_captures import HEIGHT, WIDTH, capture


def straight(across_deg: float):
    """A capture of an edge whose normal stands so from the columns."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    turn = np.radians(across_deg)
    distance = (x - WIDTH / 2) * np.cos(turn) + (y - HEIGHT / 2) * np.sin(turn)
    expected = (60 + 100 / (1 + np.exp(-distance))).astype(np.float32)
    return replace(capture(f"edge {across_deg}", "edge", expected, 1), edge_angle_deg=5.0)


@pytest.mark.parametrize(
    ("across_deg", "shown"), [((5,), False), ((5, -7, 178), False), ((5, -7, 97), True), ((85, 5), True)]
)
def test_straight_edges_show_motion_from_two_directions_on(across_deg, shown):
    captures = [straight(angle) for angle in across_deg]
    assert edges_or_known_motion(captures) == shown
    assert edges_of_one_direction(captures) != shown
