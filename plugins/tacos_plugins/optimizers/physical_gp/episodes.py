"""Episodes to score a candidate on: few, by turns."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np


def by_turns(first: int, episodes: int, seed: int) -> Iterator[int]:
    """Episodes from turn `first` on, for ever; each comes once in so many turns as there are.

    Every time round they come in another order, so that no episode falls to every second candidate.
    """
    turn = first
    while True:
        order = np.random.default_rng([seed, turn // episodes]).permutation(episodes)
        yield int(order[turn % episodes])
        turn += 1


def next_episodes(count: int, first: int, episodes: int, seed: int, done: Collection[int]) -> tuple[int, ...]:
    """The next `count` different episodes by turns that are not done; fewer where so many are not left."""
    left = min(count, episodes - len(done))
    chosen: list[int] = []
    for episode in by_turns(first, episodes, seed):
        if len(chosen) == left:
            break
        if episode not in done and episode not in chosen:
            chosen.append(episode)
    return tuple(sorted(chosen))
