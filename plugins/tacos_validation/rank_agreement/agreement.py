"""Agreement of two orders of the same cameras, with its certainty."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FitnessOn = Callable[[str, Sequence[int]], float | None]
"""Fitness of a camera, by name, on scenes, by number; None where it has none."""


@dataclass(frozen=True)
class Agreement:
    tau: float | None  # Kendall's tau-b; None where one of the orders has all cameras equal
    interval: tuple[float, float] | None  # its bootstrap interval over scenes; None where that cannot be told


@dataclass(frozen=True)
class DecidedPairs:
    """Pairs of cameras whose order the scenes settle in one study, and how many the other orders alike."""

    pairs: int
    alike: int


def tau_b(first: Sequence[float], second: Sequence[float]) -> float | None:
    """Kendall's tau-b, which takes ties into account: 1 for equal orders, -1 for opposite ones.

    None where all values of one sequence are equal, so that there is no order.

    >>> tau_b([1, 2, 3, 4], [1, 2, 4, 3])
    0.666666666667
    """
    from scipy.stats import kendalltau

    value = float(kendalltau(first, second, variant="b").statistic)
    return None if np.isnan(value) else round(value, 12)  # equal orders give 1, not 1 less the rounding


def places(fitness: Mapping[str, float]) -> dict[str, float]:
    """The place of each camera, 1 for the highest fitness; equal ones share the mean of theirs.

    >>> places({"a": 0.5, "b": 0.9, "c": 0.5})
    {'a': 2.5, 'b': 1.0, 'c': 2.5}
    """
    from scipy.stats import rankdata

    ranks = rankdata([-value for value in fitness.values()])
    return {name: float(rank) for name, rank in zip(fitness, ranks, strict=True)}


def agreement(
    cameras: Sequence[str],
    first: FitnessOn,
    second: FitnessOn,
    scenes: int,
    *,
    resamples: int,
    confidence: float,
    rng: np.random.Generator,
) -> Agreement:
    """Tau-b of two studies of the same cameras on the same scenes.

    Both studies see the same draw of scenes each time: how sure the agreement is depends on which scenes were
    seen, not on how well one study knows a scene that the other has not seen.

    `scenes`: how many there are. With one alone there is no interval. `resamples`, `confidence`: draws of
    scenes, and the share of them that the interval holds.
    """
    tau = _tau_on(range(scenes), cameras, first, second)
    if tau is None or scenes < 2:
        return Agreement(tau, None)
    draws: NDArray[np.int64] = rng.integers(scenes, size=(resamples, scenes))
    found = [value for draw in draws.tolist() if (value := _tau_on(draw, cameras, first, second)) is not None]
    if not found:
        return Agreement(tau, None)
    low, high = np.quantile(found, [(1 - confidence) / 2, (1 + confidence) / 2])
    return Agreement(tau, (float(low), float(high)))


def agreement_of_halves(
    cameras: Sequence[str], fitness: FitnessOn, scenes: int, *, resamples: int, rng: np.random.Generator
) -> float | None:
    """Agreement of a study with itself on other scenes: the median tau-b of its orders on two halves.

    What two studies on the same scenes share, the luck of the scenes, is in their tau; it is not in this one.
    A half is less than the study, so this says too little rather than too much. None below two scenes.

    `scenes`: how many there are; of an odd number one is left out of each draw.
    """
    half = scenes // 2
    if half == 0:
        return None
    draws = (rng.permutation(scenes).tolist() for _ in range(resamples))
    found = [_tau_between(cameras, fitness, draw[:half], fitness, draw[half : 2 * half]) for draw in draws]
    known = [tau for tau in found if tau is not None]
    return float(np.median(known)) if known else None


def decided_pairs(
    cameras: Sequence[str],
    judged: FitnessOn,
    trusted: FitnessOn,
    scenes: int,
    *,
    resamples: int,
    confidence: float,
    rng: np.random.Generator,
) -> DecidedPairs | None:
    """Pairs that the trusted study orders alike in nearly all draws of scenes, and the judged one's order.

    None below two scenes, which settle nothing.

    `scenes`: how many there are. `confidence`: the share of draws that must order a pair alike.
    """
    if scenes < 2:
        return None
    own, other = (_fitness_on(range(scenes), cameras, study) for study in (trusted, judged))
    draws = rng.integers(scenes, size=(resamples, scenes)).tolist()
    drawn = np.array([_fitness_on(draw, cameras, trusted) for draw in draws])
    first, second = np.triu_indices(len(cameras), 1)
    order = np.sign(own[first] - own[second])
    settled = np.mean(np.sign(drawn[:, first] - drawn[:, second]) == order, axis=0) >= confidence
    settled &= order != 0
    alike = np.sign(other[first] - other[second]) == order
    return DecidedPairs(int(settled.sum()), int((settled & alike).sum()))


def _fitness_on(scenes: Sequence[int], cameras: Sequence[str], study: FitnessOn) -> NDArray[np.float64]:
    """(cameras,) fitness; not a number where there is none."""
    return np.array([study(name, scenes) for name in cameras], np.float64)


def _tau_on(
    scenes: Sequence[int], cameras: Sequence[str], first: FitnessOn, second: FitnessOn
) -> float | None:
    return _tau_between(cameras, first, scenes, second, scenes)


def _tau_between(
    cameras: Sequence[str],
    first: FitnessOn,
    first_scenes: Sequence[int],
    second: FitnessOn,
    second_scenes: Sequence[int],
) -> float | None:
    pairs = [(first(name, first_scenes), second(name, second_scenes)) for name in cameras]
    known = [(a, b) for a, b in pairs if a is not None and b is not None]
    if len(known) < 2:
        return None
    return tau_b([a for a, _ in known], [b for _, b in known])
