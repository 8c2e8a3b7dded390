"""Anything between what a camera delivers and what a task takes."""

from __future__ import annotations

from typing import Any, ClassVar, Protocol

from tacos_framework.settings import Settings


class Transform(Protocol):
    """Makes one value of others: a rectifier, an image processor, a visual-odometry front end.

    Its ports are those of its `transform`, as the class annotates them: positional parameters are input
    ports, the return annotation is the output port, and any class may be either, also one that a plugin
    defines. Of the keyword-only parameters ``rig``, ``exposure``, ``rng``, ``illumination_lux`` and
    ``memory`` it names those it asks for.

    The frames of an episode come in order, one or a few at a time. Candidates are evaluated in any order and
    process, so the object itself keeps nothing between calls. What it must know of earlier frames it keeps in
    ``memory``, a dictionary that is empty at the start of each episode and its own.
    """

    Config: ClassVar[type[Settings]]

    def transform(self, *inputs: Any, **supplied: Any) -> Any:
        """The output for the inputs of a batch of consecutive frames, whose arrays are left as they are."""
        ...
