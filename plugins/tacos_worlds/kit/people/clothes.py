"""Clothes, and the colours of skin and hair."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tacos_worlds.kit.colours import Colour, linear, muted
from tacos_worlds.kit.finishes import Finish

_SKINS: tuple[Colour, ...] = (
    (0.58, 0.37, 0.28),
    (0.50, 0.30, 0.21),
    (0.40, 0.23, 0.15),
    (0.24, 0.13, 0.08),
    (0.12, 0.065, 0.042),
)
_HAIRS: tuple[Colour, ...] = (
    (0.02, 0.017, 0.015),
    (0.05, 0.03, 0.018),
    (0.12, 0.065, 0.03),
    (0.32, 0.21, 0.10),
    (0.38, 0.37, 0.36),
)
_TROUSERS: tuple[Colour, ...] = (
    (0.035, 0.055, 0.11),
    (0.08, 0.12, 0.21),
    (0.025, 0.025, 0.028),
    (0.10, 0.10, 0.105),
    (0.36, 0.29, 0.19),
    (0.14, 0.11, 0.07),
)
_SHOES: tuple[Colour, ...] = ((0.03, 0.03, 0.03), (0.10, 0.055, 0.03), (0.66, 0.66, 0.64))
_BRIGHT: tuple[Colour, ...] = (
    (0.45, 0.04, 0.04),
    (0.62, 0.60, 0.56),
    (0.03, 0.12, 0.30),
    (0.55, 0.36, 0.04),
    (0.04, 0.20, 0.12),
)


@dataclass(frozen=True)
class Clothes:
    """The finishes of a dressed body."""

    skin: Finish
    hair: Finish
    top: Finish
    trousers: Finish
    shoes: Finish
    coat: bool  # true if the top reaches down over the hips
    short_sleeves: bool  # true if the forearms are bare
    skirt: bool  # true if a skirt is worn in place of trousers
    long_hair: bool  # true if the hair reaches to the shoulders


def draw_clothes(rng: np.random.Generator, *, outdoors: bool, cloth: str) -> Clothes:
    def pick(colours: tuple[Colour, ...]) -> Colour:
        return colours[int(rng.integers(len(colours)))]

    dyed = pick(_BRIGHT) if rng.uniform() < 0.45 else linear(muted(rng, value=(0.3, 0.85)))
    womanly = bool(rng.uniform() < 0.5)
    return Clothes(
        skin=Finish("", pick(_SKINS), roughness=0.85),
        hair=Finish("", pick(_HAIRS), roughness=0.85),
        top=Finish(cloth, dyed, roughness=0.95),
        trousers=Finish(cloth, pick(_TROUSERS), roughness=0.95),
        shoes=Finish("", pick(_SHOES), roughness=0.85),
        coat=bool(rng.uniform() < (0.4 if outdoors else 0.05)),
        short_sleeves=bool(rng.uniform() < (0.2 if outdoors else 0.5)),
        skirt=womanly and bool(rng.uniform() < 0.3),
        long_hair=womanly and bool(rng.uniform() < 0.75),
    )
