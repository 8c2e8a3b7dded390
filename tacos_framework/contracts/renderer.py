"""Light on each pixel."""

from __future__ import annotations

from typing import ClassVar, Protocol

from tacos_framework.settings import Settings
from tacos_framework.values import Capture, Episode, Exposure, Rig


class Renderer(Protocol):
    """Gives the light that reaches each pixel, and the truth behind it.

    `RendererBase` has an optional member.
    """

    Config: ClassVar[type[Settings]]

    def capture(self, episode: Episode, *, rig: Rig, exposure: Exposure) -> Capture:
        """One view per camera of the rig for every frame of the batch."""
        ...


class RendererBase:
    """Optional members of a `Renderer`, with their defaults."""

    averages_exposure: bool = False
    """True where its settings make light an average over the exposure time. Recipes that control the
    exposure refuse such a renderer: light is rendered before the time is known."""
    draws_lenses: bool = False
    """True where it draws every `Lens` by itself. To others the framework hands pinholes alone, and puts
    images through other lenses together from theirs."""
