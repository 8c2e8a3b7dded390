"""Worlds, and trips through them."""

from __future__ import annotations

from typing import ClassVar, Protocol

import numpy as np

from tacos_framework.settings import Settings
from tacos_framework.values import Episode


class Scene(Protocol):
    """Makes worlds and the agent's trips through them.

    A further member is optional:

    ``carrier: ClassVar[str]``
        What carries the cameras through the world, in a word: ``person``, ``car``, ... Reports draw it.
    """

    Config: ClassVar[type[Settings]]

    def episode(self, *, rng: np.random.Generator, illumination_lux: float) -> Episode:
        """One trip; the same generator state gives the same episode, always.

        Illuminance is the mean on a horizontal plane 1 m above the floor (or ground) [lux].
        """
        ...
