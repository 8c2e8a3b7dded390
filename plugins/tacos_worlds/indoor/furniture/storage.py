"""Furniture without a label: bookshelves, wardrobes, sideboards, machines."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from tacos_worlds.kit.finishes import DARK_GLASS, GREY_PLASTIC, STEEL, WHITE_LACQUER, Finish, Style
from tacos_worlds.kit.mesh import Mesh, merged, rotation_x
from tacos_worlds.kit.piece import BACKGROUND, Piece, Top, piece
from tacos_worlds.kit.rectangle import Rect
from tacos_worlds.kit.shapes import box, disc_stack, slab
from tacos_worlds.kit.textures.printed import SPINE_M, SPINES

_BOOKS = Finish("book_spines", roughness=0.7)
_PAPER = Finish("linen", (0.8, 0.76, 0.66), roughness=0.95)


def bookshelf(rng: np.random.Generator, style: Style) -> Piece:
    width, depth, height = rng.uniform(0.8, 1.2), rng.uniform(0.28, 0.34), float(rng.choice([1.1, 1.8, 2.0]))
    board = 0.022
    shelves = max(3, round(height / 0.36))
    parts: list[tuple[Mesh, Finish]] = [
        (slab((width - 2 * board, 0.008, height - 0.06), (0, -depth / 2 + 0.004, 0.05)), style.wood),
    ]
    for x in (-1, 1):
        parts.append((slab((board, depth, height), (x * (width - board) / 2, 0, 0)), style.wood))
    spacing = (height - 0.06 - board) / shelves
    for shelf in range(shelves + 1):
        low = 0.06 + shelf * spacing
        parts.append((slab((width - 2 * board, depth - 0.005, board), (0, 0, low)), style.wood))
        if shelf < shelves:
            inner = width - 2 * board - 0.01
            parts += _shelf_contents(rng, style, inner, depth, low + board, spacing - board)
    return piece(BACKGROUND, parts)


def _shelf_contents(
    rng: np.random.Generator, style: Style, width: float, depth: float, low: float, room: float
) -> list[tuple[Mesh, Finish]]:
    x, books = -width / 2 + 0.01, []
    found: list[tuple[Mesh, Finish]] = []
    while x < width / 2 - 0.08:
        if rng.uniform() < 0.08:
            gap = rng.uniform(0.08, 0.2)
            if rng.uniform() < 0.6 and x + 0.16 < width / 2:
                tall = room * rng.uniform(0.4, 0.75)
                vase = [(0.035, 0), (0.055, tall * 0.4), (0.025, tall * 0.8), (0.035, tall)]
                found.append(
                    (
                        disc_stack(vase, (x + 0.08, 0.02, low), sides=10),
                        style.accent if rng.uniform() < 0.3 else style.metal,
                    )
                )
                gap = 0.16
            x += gap
            continue
        thick = SPINE_M * rng.choice([0.7, 1.0, 1.0, 1.4])
        tall, deep = room * rng.uniform(0.6, 0.93), depth * rng.uniform(0.6, 0.75)
        volume = _book((thick - 0.001, deep, tall), (x + thick / 2, depth / 2 - 0.03 - deep / 2, low))
        # Each book shows one spine of the texture, whatever its place on the shelf.
        spine = (int(rng.integers(SPINES)) + 0.5) * SPINE_M
        u = spine + np.clip(
            (volume.vertices_m[:, 0] - x - thick / 2) * 0.9 * SPINE_M / thick, -0.45 * SPINE_M, 0.45 * SPINE_M
        )
        v = (volume.vertices_m[:, 2] - low) / tall * SPINES * SPINE_M * 0.98
        books.append(Mesh(volume.vertices_m, volume.normals, np.column_stack([u, v]), volume.triangles))
        x += thick
    if books:
        found.append((merged(books), _BOOKS))
    return found


def _book(size_m: tuple[float, float, float], at_m: tuple[float, float, float]) -> Mesh:
    """A book without the two faces that its shelf hides (8 triangles)."""
    full = slab(size_m, at_m)
    facing = full.normals[full.triangles[:, 0]]
    return replace(full, triangles=full.triangles[(facing[:, 1] > -0.5) & (facing[:, 2] > -0.5)])


def wardrobe(rng: np.random.Generator, style: Style) -> Piece:
    doors = int(rng.choice([2, 3]))
    width, depth, height = doors * rng.uniform(0.48, 0.55), rng.uniform(0.55, 0.62), rng.uniform(1.95, 2.2)
    return cupboard(style, width, depth, height, columns=doors, rows=1, plinth=0.07)


def sideboard(rng: np.random.Generator, style: Style) -> Piece:
    width, depth, height = rng.uniform(1.3, 1.7), rng.uniform(0.38, 0.45), rng.uniform(0.45, 0.6)
    rows = int(rng.choice([1, 2]))
    return _topped(cupboard(style, width, depth, height, columns=3, rows=rows, plinth=0.1))


def chest(rng: np.random.Generator, style: Style) -> Piece:
    width, height = rng.uniform(0.8, 1.1), rng.uniform(0.75, 0.95)
    return _topped(cupboard(style, width, 0.45, height, columns=2, rows=3, plinth=0.08))


def _topped(made: Piece) -> Piece:
    """A cupboard that things may stand on; its handles reach beyond its top."""
    width, depth, height = made.size_m
    free = Rect(-width / 2 + 0.02, -depth / 2 + 0.02, width / 2 - 0.02, depth / 2 - 0.05)
    return replace(made, tops=(Top(free, height, "board"),))


def fridge(rng: np.random.Generator, style: Style) -> Piece:
    skin = WHITE_LACQUER if rng.uniform() < 0.5 else STEEL
    height, split = rng.uniform(1.7, 1.9), 0.62
    parts: list[tuple[Mesh, Finish]] = [(box((0.6, 0.58, height), (0, -0.02, 0), bevel_m=0.01), skin)]
    for low, high in ((0.05, split - 0.005), (split + 0.005, height - 0.01)):
        parts.append((box((0.595, 0.05, high - low), (0, 0.295, low), bevel_m=0.014), skin))
        parts.append((box((0.02, 0.03, 0.3), (0.25, 0.33, max(low, high - 0.75)), bevel_m=0.006), STEEL))
    return piece(BACKGROUND, parts)


def washing_machine(rng: np.random.Generator, style: Style) -> Piece:
    parts: list[tuple[Mesh, Finish]] = [(box((0.6, 0.58, 0.85), bevel_m=0.012), WHITE_LACQUER)]
    upright = rotation_x(-math.pi / 2)
    ring = disc_stack([(0.19, 0), (0.19, 0.03), (0.15, 0.035), (0.145, 0.01)], sides=24).rotated(upright)
    glass = disc_stack([(0.146, 0), (0.12, 0.012), (0.05, 0.02)], sides=24).rotated(upright)
    parts.append((ring.moved(0, 0.29, 0.42), STEEL))
    parts.append((glass.moved(0, 0.29, 0.42), DARK_GLASS))
    parts.append((box((0.18, 0.01, 0.07), (-0.18, 0.292, 0.75), bevel_m=0.003), GREY_PLASTIC))
    knob = disc_stack([(0.035, 0), (0.032, 0.02)], sides=14).rotated(upright)
    parts.append((knob.moved(0.1, 0.29, 0.785), STEEL))
    return piece(BACKGROUND, parts)


def laundry_basket(rng: np.random.Generator, style: Style) -> Piece:
    height, radius = rng.uniform(0.5, 0.65), rng.uniform(0.2, 0.26)
    profile = [
        (radius * 0.85, 0),
        (radius, height),
        (radius * 1.03, height),
        (radius * 1.03, height + 0.03),
        (0.03, height + 0.06),
    ]
    return piece(BACKGROUND, [(disc_stack(profile, sides=20), Finish("wicker", roughness=0.9))])


def cupboard(
    style: Style, width: float, depth: float, height: float, *, columns: int, rows: int, plinth: float
) -> Piece:
    """A box on a plinth with doors, or drawers where there is more than one row [m]."""
    parts: list[tuple[Mesh, Finish]] = [
        (box((width, depth, height - plinth), (0, 0, plinth), bevel_m=0.005), style.wood),
        (slab((width - 0.06, depth - 0.08, plinth), (0, -0.01, 0)), style.second_wood),
    ]
    face_width, face_height = (width - 0.01) / columns, (height - plinth - 0.02) / rows
    for column in range(columns):
        for row in range(rows):
            x = (column - (columns - 1) / 2) * face_width
            low = plinth + 0.01 + row * face_height
            face = box(
                (face_width - 0.008, 0.018, face_height - 0.008),
                (x, depth / 2 + 0.006, low + 0.004),
                bevel_m=0.004,
            )
            parts.append(
                (
                    face.with_uv_offset(0.31 * column, 0.17 * row),
                    style.wood if rows == 1 else style.second_wood,
                )
            )
            if face_height > face_width:
                side = 1 if column % 2 == 0 else -1
                handle = box(
                    (0.012, 0.024, 0.14),
                    (x + side * (face_width / 2 - 0.04), depth / 2 + 0.022, low + face_height * 0.45),
                )
            else:
                handle = box((0.14, 0.024, 0.012), (x, depth / 2 + 0.022, low + face_height * 0.75))
            parts.append((handle, style.metal))
    return piece(BACKGROUND, parts)
