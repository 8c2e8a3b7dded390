"""A task that takes two things at a time, to be registered by hand."""

from __future__ import annotations

import sys
from typing import ClassVar

from tacos_framework.components import Component
from tacos_framework.contracts import Scores, State
from tacos_framework.hookspecs import hookimpl
from tacos_framework.plugins import Plugins
from tacos_framework.settings import Settings
from tacos_framework.values import Capture, FrameBatch
from tests.two_boxes import plugins_with_boxes


class Seen:
    """Counts frames that come with what the renderer gave."""

    class Config(Settings):
        """Settings."""

    scores: ClassVar[tuple[str, ...]] = ("count",)

    def __init__(self, config: Config) -> None:
        pass

    def begin(self, *, state: State | None) -> SeenScorer:
        """Begin an episode."""
        return SeenScorer()


class SeenScorer:
    def __init__(self) -> None:
        self.count = 0

    def update(self, capture: Capture, frames: FrameBatch) -> None:
        self.count += len(frames.episode)

    def scores(self) -> Scores:
        """How many there were."""
        return {"count": float(self.count)}


@hookimpl
def tacos_components() -> list[Component]:
    """The task."""
    return [Component("task", "seen", "tests.view.two_ports:Seen", summary="Counts.")]


def plugins_with_two_ports() -> Plugins:
    """The installed plugins, the boxes and the task."""
    plugins = plugins_with_boxes()
    plugins.register(sys.modules[__name__])
    return plugins
