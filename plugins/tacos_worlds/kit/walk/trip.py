"""A trip: stretches of as many walks as the frames need, one after another in an episode."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Crossing, Episode, Fault, Trajectory, UserError, World
from tacos_worlds.kit.walk.motion import KEY_RATE_HZ, Walk

_FIRST_THRESHOLD_ID = 1
"""Thresholds are the first objects after the background, in the order of the doors."""
_PAUSE_S = 1.0
"""Time between two stretches, in which no frame is taken [s]."""

_WALKS_IN_VAIN = 50
"""So many walks in a row without an approach mean that there is none; a few may start too near their door."""


@dataclass(frozen=True, eq=False)
class Stretch:
    """A part of a walk, and when frames are taken in it."""

    walk: Walk
    start_s: float  # where in the walk it begins, at or before its first frame [s]
    end_s: float  # where it ends, at or after its last frame [s]
    frames_s: NDArray[np.float64]  # (N,) times of the frames after its start, rising [s]
    crossings: tuple[tuple[float, int], ...]  # (time in the walk [s], door) of the doorways that count
    owned: bool = False
    """True if the crossings name this stretch as their walk, as they must where no frame follows them."""


def joined(world: World, stretches: Iterable[Stretch]) -> Episode:
    """An episode of stretches, each a walk of its own to those who follow things from frame to frame."""
    times, numbers, poses, key_times = [], [], [], []
    crossings: list[Crossing] = []
    clock_s = 0.0
    for number, stretch in enumerate(stretches):
        walk, start_s, end_s = stretch.walk, stretch.start_s, stretch.end_s
        kept = (walk.time_s >= start_s - 1 / KEY_RATE_HZ) & (walk.time_s <= end_s + 1 / KEY_RATE_HZ)
        shift_s = clock_s - start_s + 1 / KEY_RATE_HZ
        key_times.append(walk.time_s[kept] + shift_s)
        poses.append(walk.world_from_agent[kept])
        times.append(start_s + shift_s + stretch.frames_s)
        numbers.append(np.full(len(stretch.frames_s), number))
        crossings += [
            Crossing(_FIRST_THRESHOLD_ID + door, at_s + shift_s, number if stretch.owned else None)
            for at_s, door in stretch.crossings
        ]
        clock_s = float(key_times[-1][-1]) + _PAUSE_S
    return Episode(
        world=world,
        trajectory=Trajectory(np.concatenate(key_times), np.concatenate(poses)),
        time_s=np.concatenate(times),
        walk=np.concatenate(numbers),
        crossings=tuple(crossings),
    )


def along_walks(
    rng: np.random.Generator, walks: Iterator[Walk], *, frames: int, frame_rate_hz: float
) -> Iterator[Stretch]:
    """Exactly `frames` frames at a steady rate, over as many walks as they need.

    Where the frames cover less than a walk, they cover a random stretch of it around some doorway.
    """
    left = frames
    while left > 0:
        walk = next(walks)
        start_s = _start(rng, walk, (left - 1) / frame_rate_hz)
        count = min(left, int((walk.duration_s - start_s) * frame_rate_hz + 1e-9) + 1)
        end_s = start_s + (count - 1) / frame_rate_hz
        inside = tuple((at_s, door) for at_s, door in walk.crossings if start_s <= at_s <= end_s)
        yield Stretch(walk, start_s, end_s, np.arange(count) / frame_rate_hz, inside)
        left -= count


def _start(rng: np.random.Generator, walk: Walk, needed_s: float) -> float:
    """Beginning of the frames in a walk: its start, or before some doorway where they cover only a part."""
    spare_s = walk.duration_s - needed_s
    if spare_s <= 0:
        return 0.0
    if not walk.crossings:
        return float(rng.uniform(0, spare_s))
    at_s, _ = walk.crossings[int(rng.integers(len(walk.crossings)))]
    return float(np.clip(at_s - rng.uniform(0.4, 0.95) * needed_s, 0.0, spare_s))


def bursts(
    rng: np.random.Generator, walks: Iterator[Walk], *, frames: int, burst_frames: int, frame_rate_hz: float
) -> Iterator[Stretch]:
    """Exactly `frames` frames in bursts at a steady rate, as far apart on one walk as that allows.

    Where the frames are no multiple of `burst_frames`, the last burst is shorter.
    """
    walk = next(walks)
    count = -(-frames // burst_frames)
    length_s = (burst_frames - 1) / frame_rate_hz
    starts_s = (np.arange(count) + rng.uniform()) * max(walk.duration_s - length_s, 0.0) / count
    left = frames
    for start_s in starts_s.tolist():
        taken = min(burst_frames, left)
        frames_s = np.arange(taken) / frame_rate_hz
        yield Stretch(walk, start_s, start_s + length_s, frames_s, ())
        left -= taken


def approaches(
    rng: np.random.Generator,
    walks: Iterator[Walk],
    *,
    frames: int,
    before_s: Sequence[float],
    camera_height_m: tuple[float, float],
) -> Iterator[Stretch]:
    """Exactly `frames` frames in the approaches to doorways, each at times `before_s` its crossing.

    They are spread evenly over a walk, and over as many walks as they need; each has an eye height of its
    own. Where the frames are no multiple of the times, the last approach has those nearest its crossing.

    - `walks`: walks at an eye height of zero.
    - `before_s`: times before the crossing, falling [s].
    - `camera_height_m`: range of the eye's height [m].

    Raises UserError when walk after walk is shorter than an approach.
    """
    left, in_vain = frames, 0
    while left > 0:
        walk = next(walks)
        ahead = [(at_s, door) for at_s, door in walk.crossings if at_s >= before_s[0]]
        in_vain = 0 if ahead else in_vain + 1
        if in_vain == _WALKS_IN_VAIN:
            raise UserError(
                Fault(
                    "before_step_s",
                    f"none of {in_vain} walks comes to an obstacle as late as {before_s[0]:g} s",
                    "times that lie within a walk",
                    "Give shorter ones, a larger size_m, or a lower speed_m_s.",
                )
            )
        for at_s, door in spread(rng, ahead, -(-left // len(before_s))):
            taken_s = np.array(before_s[-left:])
            frames_s = before_s[0] - taken_s
            raised = walk.raised(float(rng.uniform(*camera_height_m)))
            yield Stretch(raised, at_s - before_s[0], at_s, frames_s, ((at_s, door),), owned=True)
            left -= len(taken_s)


def spread(
    rng: np.random.Generator, crossings: Sequence[tuple[float, int]], count: int
) -> list[tuple[float, int]]:
    """At most `count` of them, in order and evenly apart from a random start (systematic sampling)."""
    if len(crossings) <= count:
        return list(crossings)
    at = (np.arange(count) + rng.uniform()) * len(crossings) / count
    return [crossings[int(i)] for i in at]
