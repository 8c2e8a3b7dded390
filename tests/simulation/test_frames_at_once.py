"""However many frames pass at a time, and however an episode is cut, they are the same bits."""

from __future__ import annotations

import numpy as np
import toy_plugin
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from toy_study import toy_recipe

from tacos_framework.plan import make_plan
from tacos_framework.simulation import EpisodeSpec, Simulation

VALUES = {"focal_length_mm": 1.0, "pitch_deg": 0.0}
FRAMES = 6
NOISY = {
    "effects": [
        {"use": "effect.read-noise", "sigma_dn": 3.0, "tail": 0.1},
        {"use": "effect.row-noise", "sigma_dn": 2.0},
        {"use": "effect.flicker", "depth": 0.2, "period_rows": 7.0},
    ]
}


def frames_of(simulation: Simulation, spec: EpisodeSpec) -> tuple[list[int], np.ndarray]:
    """How many frames came at a time, and all of them together."""
    batches = list(simulation.batches("width", VALUES, spec))
    return [len(b.episode) for b in batches], np.concatenate([b.images[0] for b in batches])


@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(at_once=st.integers(1, 8), blocks=st.integers(1, FRAMES))
def test_frames_depend_neither_on_how_many_pass_at_a_time_nor_on_blocks(
    toys, monkeypatch, at_once: int, blocks: int
) -> None:
    simulation = Simulation(make_plan(toy_recipe(**NOISY), toys))
    monkeypatch.setattr(toy_plugin.WidthTask, "frames_per_update", 1, raising=False)
    spec = EpisodeSpec(3, ("design", 0, 0), FRAMES)
    counts, one_by_one = frames_of(simulation, spec)
    assert counts == [1] * FRAMES
    monkeypatch.setattr(toy_plugin.WidthTask, "frames_per_update", at_once)
    parts = [
        frames_of(simulation, EpisodeSpec(3, ("design", 0, 0), FRAMES, (block, blocks)))
        for block in range(blocks)
    ]
    assert max(count for counts, _ in parts for count in counts) == min(at_once, -(-FRAMES // blocks))
    np.testing.assert_array_equal(np.concatenate([frames for _, frames in parts]), one_by_one)
