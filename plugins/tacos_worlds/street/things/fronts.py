"""Depth of a front: bay windows, balconies, awnings, dormers, pipes; and windows lit by night."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tacos_plugins.lighting import white_at
from tacos_worlds.kit.finishes import Finish
from tacos_worlds.kit.mesh import Mesh, merged
from tacos_worlds.kit.shapes.boxes import slab
from tacos_worlds.street.finishes import GALVANISED, ROOF_TILES, STONE
from tacos_worlds.street.panels import panel

Parts = list[tuple[Mesh, Finish]]
Floats = np.ndarray

_BAY_OUT_M = 0.7
_BAY_SHARE = 0.74
"""Width of a bay window over that of its bay [1]."""
_CANVAS = ((0.35, 0.05, 0.05), (0.05, 0.16, 0.09), (0.55, 0.50, 0.38), (0.06, 0.11, 0.25))
_WINDOW = (0.34, 0.66, 0.32, 0.74)
"""Left, right, lower and upper edge of the panes of every kind of window, in shares of their cell [1]."""
_MULLION = 0.018
_OFF_WALL_M = 0.02
_LIT_CD_M2 = (4.0, 18.0)
"""Luminance of lit windows beside lamps of 7000 lm: rooms of 30 to 120 lux behind curtains [cd/m2]."""
_SHOP_CD_M2 = (25.0, 70.0)
_KELVIN = (2700.0, 3000.0, 4000.0)


def bay_windows(
    bays: int, width_m: float, ground_m: float, floors: int, floor_m: float, first: int, finish: Finish
) -> Parts:
    """A stack of bay windows up every third bay, below the highest floor.

    `first`: texture coordinate of the first bay: the windows of the bay go on as those of the front.
    """
    bay_m = width_m / bays
    wide, high = _BAY_SHARE * bay_m, (floors - 1) * floor_m
    fronts: list[Mesh] = []
    stone: list[Mesh] = []
    for bay in range(1, bays, 3):
        x = (bay + 0.5) * bay_m - wide / 2
        low, out = ground_m + 0.02, -_BAY_OUT_M
        u0 = first + bay + (1 - _BAY_SHARE) / 2
        span, floor_span = (u0, u0 + _BAY_SHARE), (0.0, floors - 1.0)
        fronts.append(panel((x, out, low), (wide, 0, 0), (0, 0, high), u=span, v=floor_span))
        sides = (((x, 0, low), (0, out, 0)), ((x + wide, out, low), (0, -out, 0)))
        for origin, along in sides:
            fronts.append(panel(origin, along, (0, 0, high), u=(u0, u0 + 0.2), v=floor_span))
        for z, thick in ((low - 0.18, 0.18), (low + high, 0.14)):
            stone.append(slab((wide + 0.12, _BAY_OUT_M + 0.06, thick), (x + wide / 2, out / 2, z)))
    return [(merged(fronts), finish), (merged(stone), STONE)] if fronts else []


def balconies(bays: int, width_m: float, ground_m: float, floors: int, floor_m: float) -> Parts:
    """A balcony at every other bay of the upper floors but the highest."""
    bay_m = width_m / bays
    slabs: list[Mesh] = []
    rails: list[Mesh] = []
    for floor in range(1, floors - 1):
        z = ground_m + floor * floor_m + 0.15
        for bay in range(0, bays, 2):
            x, wide = (bay + 0.5) * bay_m, 0.8 * bay_m
            slabs.append(slab((wide, 1.0, 0.14), (x, -0.5, z)))
            rails.append(slab((wide, 0.04, 0.05), (x, -0.98, z + 0.99)))
            for k in range(7):
                rails.append(
                    panel((x - wide / 2 + k * wide / 7 + 0.05, -0.98, z + 0.14), (0.1, 0, 0), (0, 0, 0.85))
                )
    metal = Finish("metal", (0.10, 0.11, 0.12), roughness=0.85)
    return [(merged(slabs), STONE), (merged(rails), metal)] if slabs else []


def awnings(rng: np.random.Generator, width_m: float) -> Parts:
    colour = _CANVAS[int(rng.integers(len(_CANVAS)))]
    pieces = []
    for x in np.arange(0.4, width_m - 3.0, 6.4):
        width = min(5.6, width_m - x - 0.4)
        high, low, out = 2.95, 2.45, 1.3
        top = panel((x, -out, low), (width, 0, 0), (0, out, high - low))
        under = panel((x + width, -out, low), (-width, 0, 0), (0, out, high - low))
        hem = panel((x, -out, low - 0.22), (width, 0, 0), (0, 0, 0.22))
        pieces += [top, under, hem]
    return [(merged(pieces), Finish("metal", colour, roughness=0.95))] if pieces else []


def dormers(
    rng: np.random.Generator, width_m: float, depth_m: float, eaves_m: float, finish: Finish
) -> Parts:
    rise = 0.38 * depth_m / (depth_m / 2)
    faces: list[Mesh] = []
    roofs: list[Mesh] = []
    for x in np.arange(2.4, width_m - 2.0, float(rng.uniform(3.6, 5.0))):
        y, wide, high = 1.3, 1.5, 1.5
        low = eaves_m + y * rise - 0.1
        back = y + (high + 0.1) / rise
        faces.append(panel((x - wide / 2, y, low), (wide, 0, 0), (0, 0, high), u=(0.2, 0.8), v=(0.2, 0.82)))
        roofs.append(slab((wide + 0.3, back - y + 0.3, 0.1), (x, (y + back) / 2 - 0.1, low + high)))
        for side in (-1, 1):
            at = x + side * wide / 2
            along = (0, y - back, 0) if side < 0 else (0, back - y, 0)
            start = (at, back, low) if side < 0 else (at, y, low)
            roofs.append(panel(start, along, (0, 0, high)))
    return [(merged(faces), finish), (merged(roofs), ROOF_TILES)] if faces else []


def downpipe(x_m: float, eaves_m: float) -> tuple[Mesh, Finish]:
    return slab((0.09, 0.09, eaves_m - 0.5), (x_m, -0.06, 0.0)), GALVANISED


def lit_windows(
    rng: np.random.Generator, origin: Floats, along: Floats, bay_m: float, bays: int, ground_m: float,
    floors: int, floor_m: float, *, share: float, panes: bool,
) -> Parts:  # fmt: skip
    """Panes of the upper floors behind which there is light.

    - `origin`, `along`: left end of the front at the ground, and the unit vector along it.
    - `share`: of the windows that are lit [1].
    - `panes`: in two panes, for those that are seen from near.
    """
    left, right, low, high = _WINDOW
    found: dict[int, list[Mesh]] = {}
    out = _OFF_WALL_M * np.array([along[1], -along[0], 0.0])
    for floor in range(floors):
        for bay in range(bays):
            if rng.uniform() >= share:
                continue
            tone = int(rng.integers(2 * len(_KELVIN)))
            middle = (left + right) / 2
            spans = [(left, middle - _MULLION), (middle + _MULLION, right)] if panes else [(left, right)]
            z = ground_m + (floor + low) * floor_m
            for start, end in spans:
                corner = origin + out + along * (bay + start) * bay_m + np.array([0, 0, z])
                pane = panel(corner, along * (end - start) * bay_m, (0, 0, (high - low) * floor_m))
                found.setdefault(tone, []).append(pane)
    return [(merged(meshes), _lit(tone, _LIT_CD_M2)) for tone, meshes in sorted(found.items())]


def lit_shops(rng: np.random.Generator, origin: Floats, along: Floats, bay_m: float, bays: int) -> Parts:
    """Shop windows with their light on: a glowing band above the goods on display."""
    out = _OFF_WALL_M * np.array([along[1], -along[0], 0.0])
    meshes = list(_shop_panes(rng, origin + out, along, bay_m, bays))
    return [(merged(meshes), _lit(int(rng.integers(2 * len(_KELVIN))), _SHOP_CD_M2))] if meshes else []


def _shop_panes(
    rng: np.random.Generator, origin: Floats, along: Floats, bay_m: float, bays: int
) -> Iterator[Mesh]:
    for bay in range(bays):
        if rng.uniform() < 0.65:
            corner = origin + along * (bay + 0.14) * bay_m + np.array([0, 0, 1.9])
            yield panel(corner, along * 0.7 * bay_m, (0, 0, 0.75))


def _lit(tone: int, range_cd_m2: tuple[float, float]) -> Finish:
    """One of a few tones of light: a temperature, dim or bright."""
    colour = white_at(_KELVIN[tone // 2]) * range_cd_m2[tone % 2]
    red, green, blue = colour.tolist()
    return Finish("", (0.1, 0.1, 0.1), roughness=0.9, emission_cd_m2=(red, green, blue))
