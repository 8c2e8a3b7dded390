"""Frames do not depend on how an episode is cut, on the order of its parts, or on who else works."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_framework.formation import EpisodeDraws, ImageFormation, PlacedSensor
from tacos_framework.testing.forming import placed
from tacos_framework.testing.samples import part_of, sample_capture, sample_exposure, sample_rig
from tacos_plugins.effects.dark_current import DarkCurrent
from tacos_plugins.effects.flicker import Flicker
from tacos_plugins.effects.read_noise import ReadNoise
from tacos_plugins.effects.row_noise import RowNoise
from tacos_plugins.sensors.affine_noise import AffineNoise
from tacos_plugins.sensors.emva import Emva

EFFECTS = [
    placed(ReadNoise, sigma_dn=3.0, tail=0.1),
    placed(RowNoise, sigma_dn=2.0, column_sigma_dn=2.0),
    placed(Flicker, depth=0.3, period_rows=20.0),
    placed(DarkCurrent, rate_dn_s=50.0, hot_share=0.01),
]
FRAMES = 6
KNOWN = {"quantum_efficiency": 0.6, "full_well_e": 1e4, "read_noise_e": 3.0, "dark_current_e_s": 10.0}
SENSORS = {"affine-noise": AffineNoise(AffineNoise.Config()), "emva": Emva(Emva.Config(**KNOWN))}
WHOLE = sample_capture(sample_rig("left", "right"), FRAMES)


def files(sensor: str, parts: list[tuple[int, int]]) -> list[np.ndarray]:
    """Both cameras' frames of parts of the episode, each part formed anew as another worker would."""
    found = {}
    for start, stop in parts:
        formation, draws = ImageFormation(sample_exposure(), EFFECTS), EpisodeDraws(7, ("test", 0))
        lit = formation.light(part_of(WHOLE, start, stop), draws)
        found[start] = formation.expose(lit, PlacedSensor("sensor", "frames", SENSORS[sensor]), draws).images
    return [np.concatenate([found[start][camera] for start in sorted(found)]) for camera in range(2)]


@pytest.mark.parametrize("sensor", SENSORS)
@settings(max_examples=12, deadline=None)
@given(cuts=st.sets(st.integers(1, FRAMES - 1)), order=st.randoms(use_true_random=False))
def test_frames_are_the_same_bits_however_an_episode_is_cut(sensor, cuts, order):
    parts = list(pairwise([0, *sorted(cuts), FRAMES]))
    order.shuffle(parts)
    for whole, cut in zip(files(sensor, [(0, FRAMES)]), files(sensor, parts), strict=True):
        np.testing.assert_array_equal(cut, whole)


@pytest.mark.parametrize("sensor", SENSORS)
def test_no_two_frames_or_cameras_share_their_noise(sensor):
    left, right = files(sensor, [(0, FRAMES)])
    assert (left != right).mean() > 0.3
    assert (left[0].astype(int) - left[1] != right[0].astype(int) - right[1]).mean() > 0.3
