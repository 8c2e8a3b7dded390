"""Pairs of effects that look alike until a further capture splits them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from tacos_validation.blind.generators import acquisitions as t
from tacos_validation.blind.generators.acquisitions import Acquisition
from tacos_validation.blind.generators.camera import IdealCamera

Make = Callable[[IdealCamera, np.random.Generator], list[Acquisition]]


@dataclass(frozen=True)
class Pair:
    """Two effects that few captures cannot tell apart."""

    truth: str
    other: str
    few: Make  # captures that leave them alike
    split: Make  # captures that tell them apart, beside the few


def _one_scene(camera: IdealCamera, rng: np.random.Generator) -> list[Acquisition]:
    return list(t.scenes(camera, rng, 1))


def _one_flat(camera: IdealCamera, rng: np.random.Generator) -> list[Acquisition]:
    return list(t.flats(camera, rng, (0.6,), frames=1))


def _flat_stacks(camera: IdealCamera, rng: np.random.Generator) -> list[Acquisition]:
    return [
        Acquisition(f"stack_{i}", each.kind, each.shots, 4)
        for i, each in enumerate(t.flats(camera, rng, (0.2, 0.6)))
    ]


PAIRS: Mapping[str, Pair] = {
    "curve or exposure": Pair(
        "tone-curve",
        "exposure-error",
        _one_scene,
        lambda c, r: list(t.picture_series(c, r, (5.0, 10.0, 20.0))),
    ),
    "lens or lamp": Pair("vignetting", "illumination-gradient", _one_flat, _flat_stacks),
    "lens or correction": Pair("vignetting", "lens-shading-correction", _one_flat, _flat_stacks),
    "pattern or noise": Pair("prnu", "conversion-gain-error", _one_flat, _flat_stacks),
    "offsets or noise": Pair(
        "dsnu",
        "read-noise",
        lambda c, r: list(t.darks(c, (10.0,), frames=1)),
        lambda c, r: [Acquisition("stack_0", "dark", each.shots, 4) for each in t.darks(c, (20.0,))],
    ),
    "glare or pedestal": Pair(
        "black-level",
        "veiling-glare",
        _one_scene,
        lambda c, r: list(t.darks(c, (10.0,))),
    ),
    "focal length or distance": Pair(
        "focal-length-error",
        "pose-error",
        lambda c, r: list(t.boards(c, r, 1, tilt_deg=0.0)),
        lambda c, r: [
            Acquisition(f"tilted_{i}", each.kind, each.shots, 1, board=each.board)
            for i, each in enumerate(t.boards(c, r, 4))
        ],
    ),
    "lens or bent board": Pair(
        "lens-distortion",
        "pose-error",
        lambda c, r: list(t.boards(c, r, 1)),
        lambda c, r: [
            Acquisition(f"further_{i}", each.kind, each.shots, 1, board=each.board)
            for i, each in enumerate(t.boards(c, r, 4))
        ],
    ),
}
"""The pairs, by name."""


def acquisitions_of(pair: str, with_split: bool) -> Make:
    chosen = PAIRS[pair]

    def made(camera: IdealCamera, rng: np.random.Generator) -> list[Acquisition]:
        few = chosen.few(camera, rng)
        return [*few, *chosen.split(camera, rng)] if with_split else few

    return made
