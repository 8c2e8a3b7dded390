"""Colours of vertices, which multiply the colour of a material."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_worlds.kit.models.atlas import painted
from tacos_worlds.kit.models.model import Skin
from tacos_worlds.kit.models.patch import Patch

_SAME = 1 / 512
_STEP = 1 / 16
"""Colours over a texture are drawn in such steps, as square roots of reflectance [1]."""
_DEEPEST, _MOST_TRIANGLES = 4, 60_000


def tinted(
    patches: Sequence[Patch], skins: Sequence[Skin]
) -> tuple[list[Patch], list[Skin], dict[int, NDArray[np.uint8]]]:
    """Patches without colours of their own, in skins that have them, and atlases by index of a skin.

    One colour all over goes into the skin. Others are painted into an atlas; where there is a texture, which
    an atlas would be too coarse for, the surface is cut into steps of colour.
    """
    all_skins, made = list(skins), list[Patch]()
    to_paint: list[int] = []
    known: dict[tuple[int, bytes], int] = {}

    def skin_of(index: int, colour: NDArray[np.float64]) -> int:
        key = index, np.round(colour * 1024).astype(np.int64).tobytes()
        if key not in known:
            known[key] = len(all_skins)
            all_skins.append(replace(all_skins[index], base_colour=all_skins[index].base_colour * colour))
        return known[key]

    for patch in patches:
        if patch.colours is None or not len(patch.triangles):
            made.append(replace(patch, colours=None))
        elif (np.ptp(patch.colours, axis=0) <= _SAME).all():
            colour = patch.colours.mean(axis=0)
            white = (colour >= 1 - _SAME).all()
            skin = patch.skin if white else skin_of(patch.skin, colour)
            made.append(replace(patch, skin=skin, colours=None))
        elif skins[patch.skin].texture is not None and patch.uv is not None:
            made += [
                replace(part, skin=skin_of(part.skin, colour), colours=None) for part, colour in _steps(patch)
            ]
        else:
            to_paint.append(len(made))
            made.append(replace(patch, colours=patch.colours * skins[patch.skin].base_colour))
    atlases: dict[int, NDArray[np.uint8]] = {}
    if to_paint:
        textured, atlas = painted([made[index] for index in to_paint])
        of_skin: dict[int, int] = {}
        for index, patch in zip(to_paint, textured, strict=True):
            if patch.skin not in of_skin:
                of_skin[patch.skin] = len(all_skins)
                atlases[len(all_skins)] = atlas
                plain = replace(all_skins[patch.skin], base_colour=np.ones(3), texture=None, normal_map=None)
                all_skins.append(plain)
            made[index] = replace(patch, skin=of_skin[patch.skin])
    return made, all_skins, atlases


def _steps(patch: Patch) -> list[tuple[Patch, NDArray[np.float64]]]:
    """A patch in parts of nearly one colour, each with that."""
    for _ in range(_DEEPEST):
        assert patch.colours is not None
        spread = np.ptp(np.sqrt(patch.colours[patch.triangles]), axis=1).max(axis=1)
        if not (spread > 2 * _STEP).any() or 4 * len(patch.triangles) > _MOST_TRIANGLES:
            break
        patch = _quartered(patch, spread > 2 * _STEP)
    assert patch.colours is not None
    mean = np.sqrt(patch.colours[patch.triangles].mean(axis=1))
    step = np.round(mean / _STEP).astype(np.int64)
    _, group = np.unique(step, axis=0, return_inverse=True)
    group = group.reshape(-1)
    return [
        (patch.with_triangles(patch.triangles[group == each]), mean[group == each].mean(axis=0) ** 2)
        for each in range(int(group.max()) + 1)
    ]


def _quartered(patch: Patch, which: NDArray[np.bool_]) -> Patch:
    """Some triangles cut into four at the middles of their edges."""
    a, b, c = patch.triangles[which].T
    first = len(patch.vertices_m) + 3 * np.arange(len(a))
    ab, bc, ca = first, first + 1, first + 2

    def more(values: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
        if values is None:
            return None
        middles = np.stack([values[a] + values[b], values[b] + values[c], values[c] + values[a]], axis=1) / 2
        return np.concatenate([values, middles.reshape(-1, values.shape[1])])

    vertices = more(patch.vertices_m)
    assert vertices is not None
    corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return replace(
        patch,
        vertices_m=vertices,
        triangles=np.concatenate([patch.triangles[~which], *(np.column_stack(each) for each in corners)]),
        normals=more(patch.normals),
        uv=more(patch.uv),
        colours=more(patch.colours),
    )
