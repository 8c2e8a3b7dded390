"""Classes that are components, one of each kind, and what is said where a member is changed."""

from __future__ import annotations

from typing import Any, ClassVar

from tacos_framework.components import Component
from tacos_framework.plugins.contract_check import contract_faults
from tacos_framework.settings import Settings, setting
from tacos_framework.values import Capture, Episode, FrameBatch


class Built:
    class Config(Settings):
        blur_px: float = setting(0.0, help="Blur.", unit="px")

    def __init__(self, config: Config) -> None:
        self.config = config


class SoundScorer:
    def update(self, frames: FrameBatch) -> None: ...

    def scores(self) -> dict[str, float]: ...


class SoundTask(Built):
    scores: ClassVar[tuple[str, ...]] = ("inliers",)

    def begin(self, *, state: Any) -> SoundScorer: ...


class SoundEffect(Built):
    stage = "optics"
    neutral: ClassVar[dict[str, Any]] = {"blur_px": 0.0}

    def on_array(self, samples: Any, *, geometry: Any, context: Any, rng: Any) -> Any: ...


class SoundRenderer(Built):
    def capture(self, episode: Episode, *, rig: Any, exposure: Any) -> Capture: ...


class SoundExecutor(Built):
    def map(self, evaluate: Any, jobs: Any) -> Any: ...

    def close(self) -> None: ...


class SoundRig(Built):
    class Variables(Settings):
        """None."""

    derived_quantities: ClassVar[dict[str, str]] = {"hfov_deg": "deg"}

    def build(self, variables: Any) -> Any: ...

    def derived(self, variables: Any) -> Any: ...


class SoundOptimizer(Built):
    expected_candidates = None

    def __init__(self, config: Any, *, space: Any, rng: Any) -> None: ...

    def ask(self) -> Any: ...

    def tell(self, evaluated: Any) -> None: ...

    def stop(self) -> Any: ...

    def state(self) -> Any: ...

    def restore(self, state: Any) -> None: ...


SOUND = {
    "task": SoundTask,
    "effect": SoundEffect,
    "renderer": SoundRenderer,
    "executor": SoundExecutor,
    "rig": SoundRig,
    "optimizer": SoundOptimizer,
}


def faults(kind: str, cls: Any) -> list[str]:
    return contract_faults(Component(kind, "mine", "mine:Mine", summary="Mine."), cls)


def changed(kind: str, **members: Any) -> list[str]:
    """The faults of a sound component with members changed; None removes one."""
    cls = type("Mine", (SOUND[kind],), members)
    return faults(kind, cls)
