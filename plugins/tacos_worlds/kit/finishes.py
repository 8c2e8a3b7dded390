"""Finishes: what surfaces are made of, and the materials that come of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Material
from tacos_worlds.kit.colours import Colour, linear, muted, whitish
from tacos_worlds.kit.textures import cloth, mineral, printed, wood
from tacos_worlds.kit.textures.texture import Texture


@dataclass(frozen=True)
class Finish:
    """Material of a surface. Equal finishes become one material."""

    texture: str  # name of a procedural texture (a key of :data:`TEXTURES`), or "" for none
    tint: Colour = (1.0, 1.0, 1.0)  # Linear-sRGB reflectance that multiplies the texture [1]
    variant: int = 0  # which draw of the texture; different variants look alike but not equal
    texture_size_m: float = 0.0  # edge of one tile [m]; 0 for the texture's own
    roughness: float = 0.8  # 0..1 [1]
    metallic: float = 0.0  # 0..1 [1]
    emission_cd_m2: Colour = (0.0, 0.0, 0.0)  # luminance of the surface's own light per channel [cd/m2]
    image: int = -1  # a texture of the user's own in place of `texture`: index into the images given beside

    def scaled_to(self, size_m: float) -> Finish:
        return replace(self, texture_size_m=size_m)


TEXTURES = {
    "abstract": (printed.abstract, 256),
    "blossoms": (cloth.blossoms, 256),
    "board": (wood.board, 256),
    "book_spines": (printed.book_spines, 512),
    "brushed": (mineral.brushed, 256),
    "desktop": (printed.desktop, 256),
    "floor_tiles": (mineral.floor_tiles, 512),
    "foliage": (printed.foliage, 256),
    "glaze": (mineral.glaze, 256),
    "knit": (cloth.knit, 256),
    "landscape": (printed.landscape, 256),
    "leather": (cloth.leather, 256),
    "linen": (cloth.linen, 256),
    "marble": (mineral.marble, 256),
    "mosaic": (mineral.mosaic, 256),
    "moulded": (mineral.moulded, 256),
    "parquet": (wood.parquet, 512),
    "photograph": (printed.photograph, 256),
    "pile": (cloth.pile, 256),
    "plaid": (cloth.plaid, 256),
    "planks": (wood.planks, 512),
    "plaster": (mineral.plaster, 512),
    "rug": (cloth.rug, 256),
    "soil": (printed.soil, 256),
    "stripes": (cloth.stripes, 256),
    "view_outside": (printed.view_outside, 256),
    "wall_tiles": (mineral.wall_tiles, 256),
    "wallpaper": (mineral.wallpaper, 256),
    "weave": (cloth.weave, 256),
    "wicker": (printed.wicker, 256),
    "woodchip": (mineral.woodchip, 256),
}
"""Function and size of each texture [px]."""

VARIANTS = 3
"""Draws kept of each texture, at most."""


class TextureLibrary:
    """The textures of one world, each synthesised on first use from its own stream of random numbers."""

    def __init__(self, rng: np.random.Generator) -> None:
        keys = [(name, variant) for name in sorted(TEXTURES) for variant in range(VARIANTS)]
        self._streams = dict(zip(keys, rng.spawn(len(keys)), strict=True))
        self._made: dict[tuple[str, int], Texture] = {}

    def __getitem__(self, key: tuple[str, int]) -> Texture:
        if key not in self._made:
            synthesise, size = TEXTURES[key[0]]
            self._made[key] = synthesise(self._streams[key], size)
        return self._made[key]


class Textures(Protocol):
    def __getitem__(self, key: tuple[str, int], /) -> Texture: ...


def materials_of(
    finishes: Iterable[Finish], library: Textures, images: Mapping[int, NDArray[np.uint8]]
) -> tuple[Material, ...]:
    """One material per finish, in order; materials with the same texture share its array."""
    return tuple(_material(finish, library, images) for finish in finishes)


def _material(finish: Finish, library: Textures, images: Mapping[int, NDArray[np.uint8]]) -> Material:
    colour, normal_map, size_m, name = None, None, 1.0, "plain"
    if finish.image >= 0:
        colour, name = images[finish.image], f"image-{finish.image}"
    elif finish.texture:
        made = library[finish.texture, finish.variant]
        colour, normal_map, size_m, name = made.colour, made.normal_map, made.size_m, finish.texture
    return Material(
        name=name,
        base_colour=np.array(finish.tint, np.float32),
        texture=colour,
        texture_size_m=finish.texture_size_m or size_m,
        normal_map=normal_map,
        roughness=finish.roughness,
        metallic=finish.metallic,
        emission_cd_m2=np.array(finish.emission_cd_m2, np.float32),
    )


GOLD = Finish("brushed", (1.0, 0.70, 0.22), roughness=0.42, metallic=0.35)
CHROME = Finish("brushed", (0.75, 0.76, 0.78), roughness=0.22, metallic=0.85)
STEEL = Finish("brushed", (0.42, 0.42, 0.43), roughness=0.4, metallic=0.7)
BLACK_METAL = Finish("moulded", (0.035, 0.035, 0.037), roughness=0.45)
BRASS = Finish("brushed", (0.62, 0.45, 0.20), roughness=0.35, metallic=0.8)
CERAMIC = Finish("glaze", (0.86, 0.86, 0.84), roughness=0.15)
WHITE_LACQUER = Finish("moulded", (0.82, 0.82, 0.80), roughness=0.4)
BLACK_PLASTIC = Finish("moulded", (0.03, 0.03, 0.032), roughness=0.4)
GREY_PLASTIC = Finish("moulded", (0.32, 0.33, 0.34), roughness=0.5)
DARK_GLASS = Finish("", (0.012, 0.013, 0.016), roughness=0.08)
SOIL = Finish("soil", roughness=0.95)

_STAINS: tuple[Colour, ...] = (
    (0.95, 0.95, 0.93),  # birch
    (0.80, 0.73, 0.63),  # oak
    (0.62, 0.46, 0.34),  # cherry
    (0.36, 0.28, 0.21),  # walnut
    (0.16, 0.13, 0.11),  # wenge
)


@dataclass(frozen=True)
class Style:
    """The finishes that belong together in one room."""

    wood: Finish
    second_wood: Finish
    upholstery: Finish
    accent: Finish
    bedding: Finish
    curtain: Finish
    metal: Finish
    wall: Finish
    floor: Finish
    trim: Finish
    rug: Finish


def draw_style(rng: np.random.Generator, *, wet: bool = False) -> Style:
    stains = rng.permutation(len(_STAINS))
    wood = [Finish("board", _STAINS[stain], variant=int(stain) % 2, roughness=0.55) for stain in stains]
    cloth_name = str(rng.choice(["weave", "weave", "knit", "leather", "linen"]))
    upholstery = Finish(
        cloth_name,
        linear(muted(rng, value=(0.3, 0.8))),
        roughness=0.5 if cloth_name == "leather" else 0.92,
    )
    accent = [
        Finish(
            str(rng.choice(["plaid", "stripes", "blossoms"])), variant=int(rng.integers(2)), roughness=0.92
        ),
        Finish("weave", linear(muted(rng, saturation=(0.3, 0.6))), roughness=0.92),
    ][int(rng.integers(2))]
    bedding = [
        Finish("linen", linear(muted(rng, saturation=(0.03, 0.3), value=(0.7, 0.95))), roughness=0.95),
        Finish(
            str(rng.choice(["plaid", "stripes", "blossoms"])), variant=int(rng.integers(2)), roughness=0.95
        ),
    ][int(rng.integers(2))]
    wall_choice = int(rng.choice(3, p=[0.45, 0.25, 0.30]))
    if wet:
        wall_choice = 0
        floor = Finish(
            "floor_tiles", linear(muted(rng, saturation=(0.0, 0.15), value=(0.65, 0.98))), roughness=0.35
        )
    else:
        floor = [
            Finish("planks", _FLOOR_STAINS[int(rng.integers(len(_FLOOR_STAINS)))], roughness=0.45),
            Finish("parquet", _FLOOR_STAINS[int(rng.integers(len(_FLOOR_STAINS)))], roughness=0.4),
            Finish("pile", linear(muted(rng, saturation=(0.04, 0.22), value=(0.5, 0.8))), roughness=0.98),
        ][int(rng.choice(3, p=[0.5, 0.3, 0.2]))]
    paint = linear(whitish(rng))
    if rng.uniform() < 0.35:
        paint = linear(muted(rng, saturation=(0.08, 0.28), value=(0.7, 0.9)))
    wall = [
        Finish("plaster", paint, roughness=0.92),
        Finish("woodchip", paint, roughness=0.92),
        Finish("wallpaper", linear(whitish(rng)), variant=int(rng.integers(2)), roughness=0.9),
    ][wall_choice]
    return Style(
        wood=wood[0],
        second_wood=wood[1],
        upholstery=upholstery,
        accent=accent,
        bedding=bedding,
        curtain=Finish(
            "linen", linear(muted(rng, saturation=(0.05, 0.4), value=(0.55, 0.92))), roughness=0.95
        ),
        metal=[CHROME, BLACK_METAL, BRASS, STEEL][int(rng.integers(4))],
        wall=wall,
        floor=floor,
        trim=[WHITE_LACQUER, WHITE_LACQUER, wood[0]][int(rng.integers(3))],
        rug=[
            Finish("rug", variant=int(rng.integers(3)), roughness=0.97),
            Finish("pile", linear(muted(rng, saturation=(0.1, 0.4), value=(0.4, 0.85))), roughness=0.98),
        ][int(rng.choice(2, p=[0.7, 0.3]))],
    )


_FLOOR_STAINS: tuple[Colour, ...] = (
    (0.95, 0.93, 0.90),
    (0.75, 0.67, 0.58),
    (0.58, 0.47, 0.37),
    (0.42, 0.34, 0.28),
)
