"""Draws and memory along an episode: every frame has generators of its own."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tacos_framework.randomness import generator


@dataclass(frozen=True)
class EpisodeDraws:
    """Generators by frame and name, so that no draw depends on batches, workers or order.

    >>> draws = EpisodeDraws(7, ("design", 0))
    >>> bool(draws.rng(3, "noise").random() == EpisodeDraws(7, ("design", 0)).rng(3, "noise").random())
    True
    """

    seed: int
    names: tuple[str | int, ...]
    """Name of the episode: the same seed and names draw the same noise."""
    _memories: dict[Any, Any] = field(default_factory=dict, repr=False, compare=False)

    @property
    def key(self) -> tuple[int | str, ...]:
        """Seed and names: what is drawn once for the whole episode follows from them."""
        return self.seed, *self.names

    def rng(self, frame: int, *what: str) -> np.random.Generator:
        """The generator of one thing in one frame, counted in the whole episode."""
        return generator(self.seed, *self.names, frame, *what)

    def memory(self, *what: str) -> dict[str, Any]:
        """Memory of one thing from frame to frame."""
        memory: dict[str, Any] = self._memories.setdefault(what, {})
        return memory

    def at(self, node: str) -> EpisodeDraws:
        """The same draws with a memory of one node: an effect that holds for all images acts at several.

        >>> draws = EpisodeDraws(7, ("design", 0))
        >>> draws.at("left").memory("effect")["frames"] = 3
        >>> draws.at("left").memory("effect"), draws.at("right").memory("effect")
        ({'frames': 3}, {})
        """
        return replace(self, _memories=self.memory("node", node))

    def as_now(self) -> EpisodeDraws:
        """The same draws with all that is remembered by now, from which an episode may be gone on with.

        >>> draws = EpisodeDraws(7, ("design", 0))
        >>> draws.memory("effect")["frames"] = 3
        >>> then = draws.as_now()
        >>> draws.memory("effect")["frames"] = 4
        >>> then.memory("effect")
        {'frames': 3}
        """
        return replace(self, _memories=deepcopy(self._memories))
