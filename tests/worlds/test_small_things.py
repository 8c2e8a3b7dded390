"""Small things: as large as they are in life, closed, and on top of what they stand on."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_worlds.indoor.building import Building
from tacos_worlds.indoor.furnishing.tabletops import THINGS
from tacos_worlds.kit.class_names import CLASS_NAMES, FURNITURE_CLASSES
from tacos_worlds.kit.finishes import draw_style
from tacos_worlds.kit.piece import Builder

BUILDERS = sorted({b for _, builders in THINGS.values() for b in builders}, key=lambda b: b.__name__)
SMALL = set(CLASS_NAMES) - {"background", "threshold", "person", *FURNITURE_CLASSES}


@pytest.mark.parametrize("builder", BUILDERS, ids=lambda b: b.__name__)
def test_small_things_stand_on_their_feet_and_have_their_size(builder: Builder) -> None:
    for seed in range(4):
        rng = np.random.default_rng(seed)
        made = builder(rng, draw_style(rng))
        low, high = made.bounds_m
        assert made.class_name in SMALL
        assert low[2] == pytest.approx(0, abs=1e-9)
        assert 0.002 < high[2] < 0.6
        assert 0.04 < max((high - low)[:2]) < 0.45
        assert sum(len(mesh.triangles) for mesh, _ in made.parts) < 700
        for mesh, _ in made.parts:
            assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(1, abs=1e-6)


def test_small_things_stand_within_tops_and_apart(buildings: list[Building]) -> None:
    for building in buildings:
        small = [m for m in building.furniture if m.piece.class_name in SMALL]
        assert len(small) > 8
        tops = [top for m in building.furniture for top in m.piece.tops]
        for m in small:
            low = m.piece.bounds_m[0][2]
            assert any(t.rect.contains(m.footprint) and low == pytest.approx(t.height_m) for t in tops)


def test_the_ten_classes_of_detectors_stay() -> None:
    assert (
        *("sofa", "bed", "table", "chair", "bathtub", "basin", "computer_tv", "plant", "lamp", "toy"),
    ) == FURNITURE_CLASSES
