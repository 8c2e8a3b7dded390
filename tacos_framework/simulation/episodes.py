"""Names of episodes and their blocks."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

from tacos_framework.errors import Fault, UserError
from tacos_framework.values import Episode


@dataclass(frozen=True)
class EpisodeSpec:
    """Names an episode: the same spec gives the same world, path and noise, in any process."""

    seed: int
    """Seed of the study or of its test scenes."""
    name: tuple[str | int, ...]
    """Purpose of the episode, e.g. ``("design", 3, 0)``."""
    frames: int | None = None
    """Number of frames; None leaves it to the scene."""
    block: tuple[int, int] = (0, 1)
    """Part of the episode to score by itself, counted from 0, and the number of equal parts."""
    scenario: str | None = None
    """The scenario it is seen in, where the recipe has several; None for each of them in turn. World, path
    and noise are the same in all, the light is not.
    """

    @property
    def world(self) -> Hashable:
        """The same for episodes in the same worlds."""
        return self.seed, self.name


def block_of(episode: Episode, index: int, count: int) -> Episode:
    """One of `count` nearly equal parts of an episode, counted from 0.

    Raises `UserError` when there are fewer frames than parts.
    """
    if count > len(episode):
        raise UserError(
            Fault(
                "study.blocks",
                f"an episode of {len(episode)} frames cannot be cut into {count} blocks",
                f"at most {len(episode)} blocks",
                "Set fewer blocks, or more frames.",
            )
        )
    start, stop = (len(episode) * i // count for i in (index, index + 1))
    return episode[start:stop] if count > 1 else episode
