"""The furniture a room can ask for, by kind."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tacos_worlds.indoor.furniture import (
    bathroom,
    bed,
    chair,
    computer_tv,
    kitchen,
    lamp,
    plant,
    sofa,
    storage,
    table,
    toy,
)
from tacos_worlds.kit.finishes import Style
from tacos_worlds.kit.piece import Builder, Piece

BUILDERS: Mapping[str, tuple[str, Builder]] = {
    "sofa": ("sofa", sofa.sofa),
    "armchair": ("sofa", sofa.armchair),
    "bed": ("bed", bed.bed),
    "single_bed": ("bed", bed.single_bed),
    "dining_table": ("table", table.dining_table),
    "desk": ("table", table.desk),
    "coffee_table": ("table", table.coffee_table),
    "side_table": ("table", table.side_table),
    "dining_chair": ("chair", chair.dining_chair),
    "office_chair": ("chair", chair.office_chair),
    "bathtub": ("bathtub", bathroom.bathtub),
    "basin": ("basin", bathroom.basin),
    "television": ("computer_tv", computer_tv.television),
    "computer": ("computer_tv", computer_tv.computer),
    "floor_plant": ("plant", plant.floor_plant),
    "small_plant": ("plant", plant.small_plant),
    "floor_lamp": ("lamp", lamp.floor_lamp),
    "table_lamp": ("lamp", lamp.table_lamp),
    "toy": ("toy", toy.toy),
    "toilet": ("background", bathroom.toilet),
    "bookshelf": ("background", storage.bookshelf),
    "wardrobe": ("background", storage.wardrobe),
    "sideboard": ("background", storage.sideboard),
    "chest": ("background", storage.chest),
    "kitchen_unit": ("background", kitchen.kitchen_unit),
    "fridge": ("background", storage.fridge),
    "washing_machine": ("background", storage.washing_machine),
    "laundry_basket": ("background", storage.laundry_basket),
}
"""Class and builder of each kind."""


LONGEST_EDGE_M: Mapping[str, tuple[float, float]] = {
    "sofa": (1.4, 2.6),
    "armchair": (0.8, 1.1),
    "bed": (1.9, 2.2),
    "single_bed": (1.9, 2.1),
    "dining_table": (1.1, 2.0),
    "desk": (1.1, 1.7),
    "coffee_table": (0.6, 1.2),
    "side_table": (0.4, 0.6),
    "dining_chair": (0.8, 1.05),
    "office_chair": (0.9, 1.2),
    "bathtub": (1.5, 1.8),
    "basin": (0.6, 1.1),
    "television": (0.8, 1.4),
    "computer": (0.35, 0.7),
    "floor_plant": (0.7, 1.7),
    "small_plant": (0.2, 0.4),
    "floor_lamp": (1.3, 1.8),
    "table_lamp": (0.35, 0.6),
    "toy": (0.15, 0.4),
}
"""Plausible range of the longest edge of each labelled kind [m]; user models are scaled into it."""


class Catalogue:
    """Makes furniture by kind: procedural, or from models of the user's own."""

    def __init__(self, models: Mapping[str, Sequence[Piece]] | None = None) -> None:
        self._models = dict(models or {})

    def make(self, kind: str, rng: np.random.Generator, style: Style) -> Piece:
        class_name, builder = BUILDERS[kind]
        if models := self._models.get(class_name):
            model = models[int(rng.integers(len(models)))]
            longest, (low, high) = max(model.size_m), LONGEST_EDGE_M[kind]
            return model if low <= longest <= high else model.scaled(rng.uniform(low, high) / longest)
        return builder(rng, style)
