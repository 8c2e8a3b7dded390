"""Small captures in memory, real frames made by the simulator with effects that the diagnosis is to find."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from tacos_framework.formation import EpisodeDraws, PlacedEffect
from tacos_framework.plugins import Plugins
from tacos_framework.values import ImageContext, ImageGeometry
from tacos_gap.captures import Noise, RealCapture
from tacos_gap.simulation.formation import simulate

WIDTH, HEIGHT = 160, 120
BLACK_DN = 16.0


def effects_named(*names: str) -> dict[str, type[Any]]:
    plugins = Plugins.discover()
    return {name: plugins.resolve(f"effect.{name}") for name in names}


def capture(name: str, kind: str, expected: Any, frames: int = 2, exposure_ms: float = 10.0) -> RealCapture:
    """A capture whose real frames are still to come; `expected` is a level or an (H, W) image [DN]."""
    image = np.broadcast_to(np.asarray(expected, np.float32), (HEIGHT, WIDTH))
    return RealCapture(
        id=name,
        kind=kind,
        real_dn=np.zeros((frames, HEIGHT, WIDTH, 1), np.float32),
        expected_dn=np.ascontiguousarray(image)[None, :, :, None],
        valid=np.ones((HEIGHT, WIDTH), bool),
        geometry=ImageGeometry(WIDTH, HEIGHT, 333.0, ((WIDTH - 1) / 2, (HEIGHT - 1) / 2), 3.0),
        context=ImageContext(exposure_s=exposure_ms * 1e-3, black_level_dn=BLACK_DN, white_level_dn=255.0),
        noise=Noise((0.24,), (1.8,)),
    )


def squares() -> np.ndarray:
    """(H, W) slanted squares, dark and bright [DN]."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    tilted = ((rows + columns // 10) // 20 + (columns - rows // 10) // 20) % 2
    return np.asarray(BLACK_DN + 25 + 150 * tilted)


def bench() -> list[RealCapture]:
    """A dark at two exposure times, flats at three levels, and edges."""
    return [
        capture("dark_short", "dark", BLACK_DN),
        capture("dark_long", "dark", BLACK_DN, exposure_ms=1000),
        *(capture(f"flat_{level}", "flat", BLACK_DN + level) for level in (40, 100, 180)),
        capture("edges", "edge", squares()),
    ]


def placed(name: str, cls: type[Any], **settings: Any) -> PlacedEffect:
    """An effect as a recipe would place it."""
    return PlacedEffect(f"effect.{name}", f"effect.{name}", cls, cls.Config(**settings))


def taken(
    captures: Sequence[RealCapture], effects: Sequence[PlacedEffect] = (), seed: int = 5
) -> list[RealCapture]:
    """The captures with real frames that hold these effects."""
    return [
        replace(c, real_dn=simulate(c, effects, EpisodeDraws(seed, ("taken", i))))
        for i, c in enumerate(captures)
    ]
