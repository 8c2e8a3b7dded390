"""Shake of a camera on its carrier: smooth angular and linear motion on top of an agent's way.

Rates about and along each axis are band-limited Gaussian noise of a stated deviation; angles and places are
their integrals. What the sources measured, and what follows from it by an assumption, stands at each carrier.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Episode, Settings, Trajectory, setting

Carrier = Literal["none", "head", "handheld", "wheels", "drone", "car"]
"""What carries the camera; none moves along its way and no more."""

KEY_STEP_S = 0.005
"""From pose to pose: what shakes at 8 Hz lies within 1 % of its chord [s]."""

_LEAST_S = 20.0
"""Noise is drawn for at least this long, which holds several periods of the slowest [s]."""


class CarriedSettings(Settings):
    """Carrier of the cameras of a scene."""

    motion: Carrier = setting(
        "none",
        help="Carrier of the cameras, which shakes them on their way: a head, a hand, a robot on wheels, a "
        "drone or a car.",
        also=("shake", "vibration", "carrier"),
    )
    motion_scale: float = setting(1.0, help="Factor on the rates of that motion.", ge=0, le=10)


@dataclass(frozen=True)
class Shaking:
    """Deviation of the rates about (along) x, y and z of the agent, and the bands they lie in."""

    turning_deg_s: tuple[float, float, float]
    """Standard deviation about x (roll), y (pitch) and z (yaw); then the lowest and highest frequency."""
    turning_hz: tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
    moving_m_s: tuple[float, float, float]
    """Along x (ahead), y (left) and z (up), likewise."""
    moving_hz: tuple[float, float]


SHAKING: Mapping[str, Shaking] = {
    # Grossman, Leigh, Abel, Lanska and Thurston 1988, "Frequency and velocity of rotational head
    # perturbations during locomotion", Exp. Brain Res. 70: pitch at twice the frequency of yaw or more, the
    # largest velocity within 90 deg/s walking or running (medians). Assumed: a walker's largest is half of it
    # and four deviations; roll is half of pitch. Glances to a side are the walk's own.
    "head": Shaking((6.0, 12.0, 12.0), ((0.5, 2.0), (1.0, 4.0), (0.5, 2.0)), (0.03, 0.03, 0.05), (0.5, 3.0)),
    # Sturm et al. 2012, "A benchmark for the evaluation of RGB-D SLAM systems", IROS: hand-held in an office
    # (fr1/desk, fr1/room) 23 and 30 deg/s on average, which is 1.6 deviations of three equal axes. Assumed:
    # the band, and that a third of its 0.3 to 0.4 m/s is shaking, the rest the way.
    "handheld": Shaking((16.0,) * 3, ((0.3, 4.0),) * 3, (0.1, 0.1, 0.1), (0.5, 3.0)),
    # Ibid., a robot on wheels (fr2/pioneer) 12 to 13 deg/s on average, turns included. Assumed: half of it is
    # steering about the way, and floors tilt it by a tenth.
    "wheels": Shaking((1.2, 1.2, 6.0), ((1.0, 8.0), (1.0, 8.0), (0.3, 2.0)), (0.01, 0.01, 0.01), (1.0, 8.0)),
    # Burri et al. 2016, "The EuRoC micro aerial vehicle datasets", IJRR 35: 0.21 to 0.66 rad/s on average, of
    # which 0.4 is taken. Assumed: the band of the attitude control; rotors shake faster; mounts damp it.
    "drone": Shaking((14.0,) * 3, ((0.3, 4.0),) * 3, (0.1, 0.1, 0.1), (0.3, 2.0)),
    # ISO 2631-1:1997: 0.315 m/s2 upwards is the end of comfort; at the body's 1.3 Hz (Gillespie 1992,
    # "Fundamentals of vehicle dynamics") that is 0.04 m/s. Axles 2.7 m apart that move so by themselves pitch
    # it by 1.2 deg/s. Assumed: roll alike, yaw half of it.
    "car": Shaking((1.2, 1.2, 0.6), ((0.8, 2.5),) * 3, (0.02, 0.02, 0.04), (0.8, 2.5)),
}
"""What shakes how; turns and bobs of the way itself come on top."""


def motion_words(config: CarriedSettings, speed_m_s: float) -> str:
    """Motion of a scene's cameras in words, for its `moves`.

    >>> motion_words(CarriedSettings(motion="head"), 1.0)
    '1 m/s, shaken as on a head (turning by 18 deg/s rms)'
    """
    along = f"{speed_m_s:g} m/s"
    if config.motion == "none" or config.motion_scale == 0:
        return f"{along}, not shaken"
    turning = config.motion_scale * float(np.linalg.norm(SHAKING[config.motion].turning_deg_s))
    return f"{along}, shaken as {_ON[config.motion]} (turning by {turning:.2g} deg/s rms)"


_ON = {
    "head": "on a head",
    "handheld": "in a hand",
    "wheels": "on a robot with wheels",
    "drone": "on a drone",
    "car": "on a car",
}


def carried(rng: np.random.Generator, episode: Episode, config: CarriedSettings) -> Episode:
    """An episode whose agent shakes as its carrier does; the episode itself where nothing does."""
    if config.motion == "none" or config.motion_scale == 0:
        return episode
    way = episode.trajectory
    start_s, end_s = float(way.time_s[0]), float(way.time_s[-1])
    time_s = np.union1d(way.time_s, np.arange(start_s, end_s, KEY_STEP_S))
    keep = np.append(np.diff(time_s) > 1e-9, True)  # a key of the way may lie a rounding from one of ours
    shaken = _shaken(rng, way.at(time_s[keep]), time_s[keep], SHAKING[config.motion], config.motion_scale)
    return replace(episode, trajectory=Trajectory(time_s[keep], shaken))


def _shaken(
    rng: np.random.Generator,
    poses: NDArray[np.float64],
    time_s: NDArray[np.float64],
    shaking: Shaking,
    scale: float,
) -> NDArray[np.float64]:
    from scipy.spatial.transform import Rotation  # late: checking a recipe shakes nothing

    turns = np.stack(
        [
            integrated_noise(rng, time_s, scale * np.radians(deviation), band)
            for deviation, band in zip(shaking.turning_deg_s, shaking.turning_hz, strict=True)
        ],
        axis=1,
    )
    steps = [integrated_noise(rng, time_s, scale * each, shaking.moving_hz) for each in shaking.moving_m_s]
    shake = np.tile(np.eye(4), (len(time_s), 1, 1))
    shake[:, :3, :3] = Rotation.from_rotvec(turns).as_matrix()
    shake[:, :3, 3] = np.stack(steps, axis=1)
    return np.asarray(poses @ shake)


def integrated_noise(
    rng: np.random.Generator, time_s: NDArray[np.float64], deviation: float, band_hz: tuple[float, float]
) -> NDArray[np.float64]:
    """(N,) the integral of band-limited noise at rising times.

    `deviation`: standard deviation of the noise, in units of the integral per second. `band_hz`: lowest and
    highest frequency; all between are alike strong [Hz].
    """
    span_s = max(float(time_s[-1] - time_s[0]), _LEAST_S)
    low, high = band_hz
    number = np.arange(max(1, int(np.ceil(low * span_s))), int(high * span_s) + 1)
    angular = 2 * np.pi * number / span_s
    waves = (rng.standard_normal(len(number)) - 1j * rng.standard_normal(len(number))) / angular
    # The sum of waves, on an even grid of the span, twice as fine as the poses.
    count = 2 * int(np.ceil(span_s / KEY_STEP_S))
    spectrum = np.zeros(count // 2 + 1, complex)
    spectrum[number] = waves * deviation / np.sqrt(len(number)) * count / 2
    grid = np.fft.irfft(spectrum, count)
    return np.interp(time_s - time_s[0], np.arange(count) * span_s / count, grid, period=span_s)
