"""The textures of one town, and the finishes its things are made of."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from tacos_worlds.kit.finishes import Finish
from tacos_worlds.kit.textures.texture import Texture
from tacos_worlds.street.textures import facade, paving, printed

Synthesis = Callable[[np.random.Generator, int], Texture]

FRONTS: tuple[tuple[str, tuple[float, float, float]], ...] = (
    ("brick", (0.72, 0.40, 0.31)),
    ("brick", (0.78, 0.66, 0.50)),
    ("brick", (0.52, 0.33, 0.29)),
    ("render", (0.93, 0.87, 0.74)),
    ("render", (0.86, 0.72, 0.60)),
    ("render", (0.72, 0.79, 0.80)),
    ("ashlar", (0.95, 0.93, 0.90)),
    ("concrete", (0.95, 0.94, 0.92)),
)
"""Wall and tint (sRGB) of each kind of front; its upper floors, ground floor and blank wall go together."""

SHOP_VARIANTS = 3
OFFICE_VARIANTS = 2
POSTER_VARIANTS = 3

LARGEST_PX = 512
_SMALLEST_PX = 32

_TEXTURES: dict[str, tuple[Synthesis, int]] = {
    "asphalt": (paving.asphalt, 512),
    "bark": (printed.bark, 128),
    "car_paint": (printed.car_paint, 128),
    "crossing_ahead": (printed.crossing_ahead, 128),
    "grass": (paving.grass, 512),
    "gravel": (paving.gravel, 256),
    "kerbstone": (paving.kerbstone, 256),
    "leaves": (printed.leaves, 256),
    "metal": (printed.metal, 128),
    "no_entry": (printed.no_entry, 128),
    "number_plate": (printed.number_plate, 128),
    "office": (facade.office, 512),
    "paint": (paving.paint, 256),
    "poster": (printed.poster, 256),
    "roof_tiles": (paving.roof_tiles, 256),
    "shops": (facade.shops, 512),
    "slabs": (paving.slabs, 512),
    "speed_limit": (printed.speed_limit, 128),
    "stop": (printed.stop, 128),
    "street_name": (printed.street_name, 128),
    **{
        f"{name} {kind}": (partial(make, wall=wall, tint=tint), size)
        for name, make, size in (
            ("front", facade.front, 512),
            ("entrance", facade.entrance, 512),
            ("blank", facade.blank, 256),
        )
        for kind, (wall, tint) in enumerate(FRONTS)
    },
}
_VARIANTS = 3


class StreetTextures:
    """The textures of one town, each synthesised on first use from its own stream of random numbers."""

    def __init__(self, rng: np.random.Generator, largest_px: int = LARGEST_PX) -> None:
        self._largest_px = largest_px
        keys = [(name, variant) for name in sorted(_TEXTURES) for variant in range(_VARIANTS)]
        self._streams = dict(zip(keys, rng.spawn(len(keys)), strict=True))
        self._made: dict[tuple[str, int], Texture] = {}

    def __getitem__(self, key: tuple[str, int]) -> Texture:
        if key not in self._made:
            synthesise, size = _TEXTURES[key[0]]
            self._made[key] = synthesise(
                self._streams[key], max(size * self._largest_px // LARGEST_PX, _SMALLEST_PX)
            )
        return self._made[key]


MATTE = 0.95
ASPHALT = Finish("asphalt", roughness=MATTE)
SLABS = Finish("slabs", roughness=MATTE)
KERB = Finish("kerbstone", roughness=MATTE)
GRASS = Finish("grass", roughness=MATTE)
PAINT = Finish("paint", roughness=MATTE)
ROOF_FELT = Finish("gravel", roughness=MATTE)
ROOF_TILES = Finish("roof_tiles", roughness=MATTE)
BARK = Finish("bark", roughness=MATTE)
STONE = Finish("kerbstone", (1.0, 0.94, 0.84), roughness=MATTE)
GALVANISED = Finish("metal", (0.52, 0.53, 0.54), roughness=0.85)
DARK_METAL = Finish("metal", (0.07, 0.08, 0.085), roughness=0.85)
GREEN_METAL = Finish("metal", (0.05, 0.14, 0.08), roughness=0.85)
TYRE = Finish("", (0.025, 0.025, 0.027), roughness=0.9)
CAR_GLASS = Finish("", (0.015, 0.018, 0.022), roughness=0.08)
TRIM = Finish("", (0.03, 0.03, 0.032), roughness=0.8)
HEADLIGHT = Finish("", (0.78, 0.80, 0.82), roughness=0.3)
TAIL_LIGHT = Finish("", (0.5, 0.02, 0.02), roughness=0.5)
RIM = Finish("", (0.50, 0.51, 0.53), roughness=0.5)


def front(kind: int) -> Finish:
    """Upper floors of a kind of front; texture coordinates count bays and floors."""
    return Finish(f"front {kind}", roughness=MATTE)


def entrance(kind: int) -> Finish:
    """Ground floor of a kind of front; one floor is `walls.CELLS` high in texture coordinates."""
    return Finish(f"entrance {kind}", roughness=MATTE)


def blank(kind: int) -> Finish:
    """Side and back walls of a kind of front."""
    return Finish(f"blank {kind}", roughness=MATTE)
