"""How carriers shake cameras, against the rates that their sources state."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tacos_framework.testing.samples import sample_world
from tacos_framework.values import Episode, Trajectory
from tacos_worlds.kit.carried import KEY_STEP_S, SHAKING, CarriedSettings, carried, integrated_noise

STILL = Episode(
    sample_world(), Trajectory(np.array([0.0, 60.0]), np.tile(np.eye(4), (2, 1, 1))), np.zeros(1), np.zeros(1)
)


def shaken(carrier, seed=1, **more):
    return carried(np.random.default_rng(seed), STILL, CarriedSettings(motion=carrier, **more))


def rates(episode):
    """(N, 3) angular rates in the agent's frame [deg/s], and linear ones [m/s]."""
    time_s, poses = episode.trajectory.time_s, episode.trajectory.world_from_agent
    turned = Rotation.from_matrix(np.swapaxes(poses[:-1, :3, :3], 1, 2) @ poses[1:, :3, :3]).as_rotvec()
    step_s = np.diff(time_s)[:, None]
    return np.degrees(turned) / step_s, np.diff(poses[:, :3, 3], axis=0) / step_s


@pytest.mark.parametrize("carrier", SHAKING)
def test_rates_are_those_of_the_carrier(carrier):
    found = [rates(shaken(carrier, seed)) for seed in range(6)]
    turning, moving = (np.sqrt(np.mean([each[k] ** 2 for each in found], axis=(0, 1))) for k in (0, 1))
    np.testing.assert_allclose(turning, SHAKING[carrier].turning_deg_s, rtol=0.15)
    np.testing.assert_allclose(moving, SHAKING[carrier].moving_m_s, rtol=0.15)


def test_averages_are_those_of_published_recordings():
    for carrier, least, most in (("handheld", 23.0, 30.0), ("drone", 12.0, 38.0)):
        turning, _ = rates(shaken(carrier))
        assert least < np.linalg.norm(turning, axis=1).mean() < most
    turning, _ = rates(shaken("head"))
    assert np.linalg.norm(turning, axis=1).max() < 90


def test_noise_keeps_to_its_band():
    time_s = np.arange(0, 60, KEY_STEP_S)
    noise = integrated_noise(np.random.default_rng(2), time_s, 1.0, (1.0, 4.0))
    power = np.abs(np.fft.rfft(noise * np.hanning(len(noise)))) ** 2
    frequency_hz = np.fft.rfftfreq(len(noise), KEY_STEP_S)
    inside = (frequency_hz > 0.9) & (frequency_hz < 4.1)
    assert power[inside].sum() > 0.999 * power.sum()


def test_one_generator_state_is_one_shake_and_none_is_none():
    one, same, other = (shaken("drone", seed).trajectory.world_from_agent for seed in (1, 1, 2))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)
    assert shaken("none") is STILL
    assert shaken("drone", motion_scale=0.0) is STILL


def test_the_way_itself_is_kept():
    way = Trajectory(
        np.array([0.0, 0.333, 7.0]), np.stack([np.eye(4), np.eye(4) + np.eye(4, k=3), np.eye(4)])
    )
    episode = Episode(sample_world(), way, np.zeros(1), np.zeros(1))
    little = carried(np.random.default_rng(1), episode, CarriedSettings(motion="car", motion_scale=1e-9))
    time_s = np.linspace(0, 7, 50)
    np.testing.assert_allclose(little.trajectory.at(time_s), way.at(time_s), atol=1e-9)
