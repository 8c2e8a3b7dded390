"""Every part that can be had, each at its own best optics, with what is not known of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tacos_decision.model import DRAWS, TIME, Array, CameraModel, interval
from tacos_decision.optimum import BestOfParts
from tacos_decision.pool import Pool, joined, part_names
from tacos_framework import CatalogChoice, CatalogPart, StudiedCamera, Values

PLACES = 64
"""Settings of what a product leaves free that are looked at."""

SCORED_AGAIN = ("final", "test", "analysis")
"""Stages that score a camera on scenes it was not chosen by."""


def ranking(model: CameraModel, pool: Pool, found: BestOfParts, margin: float) -> list[dict[str, Any]]:
    """The key ``ranking``: parts, or where there is no catalog the cameras of the study, best first.

    - `model`: what is known of the fitness.
    - `pool`: the cameras of the design space.
    - `found`: the best camera of each combination of parts.
    - `margin`: a camera of the same parts that was scored again stands for them where it is no further behind
      the best optics that were found for them [fitness].
    """
    products = {
        product.name: (product.camera, at_its_best(model, product, product.camera, margin))
        for product in model.record.products
        if product.camera is not None
    }
    entries = _entries_of_parts(model, pool, found, margin) if pool.catalogs else _entries_of_cameras(model)
    if not entries:
        return []
    cameras = [camera for _, camera in entries]
    at_their_best = [best for _, best in products.values()]
    measured = _ahead_on_test_scenes(model, list(products))
    tested = _tested(model, list(measured))
    draws = model.draws([*cameras, *at_their_best, *tested])  # together, so that what is the same cancels
    designed = len(cameras) + len(at_their_best)
    ahead = {
        name: difference - (draws[:, designed] - draws[:, designed + j])
        for j, (name, difference) in enumerate(measured.items(), 1)
    }
    low, high = interval(draws)
    mean = draws.mean(axis=0)
    unknown = _unknown(model, cameras)
    rows = []
    for i, (name, camera) in enumerate(entries):
        scored = model.episodes_of(camera)
        rows.append(
            {
                "part": name,
                "camera": dict(camera),
                "fitness": float(mean[i]),
                "ci": [float(low[i]), float(high[i])],
                "p_better": {
                    name: float((draws[:, i] - draws[:, len(entries) + j] + ahead.get(name, 0.0) > 0).mean())
                    for j, (name, own) in enumerate(products.items())
                    if camera not in own
                },
                "rescored": any(each.stage in SCORED_AGAIN for each in scored),
                "episodes": len(scored),
                "unknown": unknown[i],
            }
        )
    return sorted(rows, key=lambda row: -row["fitness"])


def _ahead_on_test_scenes(model: CameraModel, products: Sequence[str]) -> dict[str, Array]:
    """(DRAWS,) what the test tells of the designed camera less each product that was scored on its scenes.

    A scene where one of two cameras fails has a tail that the model's Gaussians lack. So that a probability
    says what the verdict beside it says, the difference of the two that were tested is the test's own, and
    the model carries it to other parts and optics.
    """
    record, rng = model.record, np.random.default_rng(model.record.recipe.seed)
    shares = (np.arange(DRAWS) + 0.5) / DRAWS
    measured = {}
    for name in products:
        found = record.comparisons.get(name)
        if found is not None and (quantiles := found.quantiles(shares)) is not None:
            measured[name] = rng.permutation(quantiles)
    return measured


def _tested(model: CameraModel, products: Sequence[str]) -> list[Values]:
    """The designed camera and the products, as they were tested; none without products."""
    camera_of = {each.name: each.camera for each in model.record.cameras}
    names = [model.record.designed, *products] if products else []
    return [camera for name in names if (camera := camera_of[name]) is not None]


def at_its_best(model: CameraModel, product: StudiedCamera, camera: Values, margin: float) -> Values:
    """A product with what it leaves free where the model likes it best, as each part is compared.

    Its own short search may have ended elsewhere. What it was scored with stands where it is no further
    behind than `margin`.
    """
    space = model.record.space
    free = Pool(space.fix([name for name in space.names if name not in product.free]))
    if not free.space.variables:
        return camera
    places = free.spread(PLACES)
    tried = [{**camera, **free.camera(parts, place)} for parts in free.parts for place in places]
    own, *means = model.posterior([camera, *tried]).mean.tolist()
    best = int(np.argmax(means))
    return tried[best] if means[best] > own + margin else camera


def left_out(model: CameraModel, pool: Pool, found: BestOfParts) -> list[dict[str, str]]:
    """The key ``ranking_left_out``: parts that cannot keep a constraint, and parts too little is known of."""
    rows = []
    for i, choice in enumerate(pool.catalogs):
        possible = {names[i] for names in found.cameras}
        for part in choice.rows:
            if part.name in possible:
                continue
            broken = [amounts for names, amounts in found.impossible.items() if names[i] == part.name]
            nearest = min(broken, key=lambda amounts: sum(amounts.values()), default={})
            rows.append({"part": part.name, "why": _impossible(nearest)})
        rows += [
            {"part": part.name, "why": _excluded(model, choice, part, found)}
            for part in sorted(choice.catalog.rows, key=lambda part: part.name)
            if part.name in choice.excluded
        ]
        rows += [
            {"part": part.name, "why": f"its {', '.join(missing)} is not known, which the design needs"}
            for part in choice.left_out
            if (missing := [each for each in choice.design_columns if part.values.get(each) is None])
        ]
    return rows


def _unknown(model: CameraModel, cameras: Sequence[Values]) -> list[list[str]]:
    """Quantities that are bounded or matter, and are known of some cameras and not of others."""
    unknown = []
    for camera in cameras:
        known = model.record.coordinates(camera)
        unlocated = [name for name in model.box.system.names if name not in known and name != TIME]
        unknown.append(dict.fromkeys([*model.record.unknown(camera), *unlocated]))
    everywhere = set.intersection(*map(set, unknown))  # a rig without a lens has no image circle
    return [[name for name in names if name not in everywhere] for names in unknown]


def _entries_of_parts(
    model: CameraModel, pool: Pool, found: BestOfParts, margin: float
) -> list[tuple[str, Values]]:
    """Of each part of each catalog its best combination with others, once."""
    chosen: dict[tuple[str, ...], None] = {}
    ranked = sorted(found.means, key=lambda names: -found.means[names])
    for i in range(len(pool.catalogs)):
        for part in dict.fromkeys(names[i] for names in ranked):
            chosen[next(names for names in ranked if names[i] == part)] = None
    again = _scored_again(model, pool.catalogs)
    entries = []
    for names in chosen:
        camera = found.cameras[names]
        if (known := again.get(names)) is not None and known[1] >= found.means[names] - margin:
            camera = known[0]
        entries.append((joined(names), camera))
    return entries


def _scored_again(
    model: CameraModel, catalogs: Sequence[CatalogChoice]
) -> dict[tuple[str, ...], tuple[Values, float]]:
    """For parts of which a camera was scored again, the best such camera and its posterior mean."""
    cameras = [
        camera
        for camera in model.scored.values()
        if any(each.stage in SCORED_AGAIN for each in model.episodes_of(camera))
    ]
    best: dict[tuple[str, ...], tuple[Values, float]] = {}
    if not cameras:
        return best
    for camera, mean in zip(cameras, model.posterior(cameras).mean.tolist(), strict=True):
        names = part_names(catalogs, camera)
        if names not in best or mean > best[names][1]:
            best[names] = camera, mean
    return best


def _entries_of_cameras(model: CameraModel) -> list[tuple[str, Values]]:
    def entry(camera: StudiedCamera) -> list[tuple[str, Values]]:
        return [] if camera.camera is None else [(camera.name, camera.camera)]

    return [each for camera in model.record.cameras for each in entry(camera)]


def _excluded(model: CameraModel, choice: CatalogChoice, part: CatalogPart, found: BestOfParts) -> str:
    """Constraints on columns of its own that a part breaks, whatever stands beside it."""
    beside = next(iter(found.cameras.values()), {})
    broken = model.record.broken({**beside, choice.name: part.as_dict()})
    own = [name for name in broken if name.startswith(f"{choice.name}.")]
    own = own or [name for name in model.record.recipe.constraints if name.startswith(f"{choice.name}.")]
    return f"ruled out by the constraint{'s' if len(own) > 1 else ''} on {' and '.join(own)}"


def _impossible(broken: Mapping[str, float]) -> str:
    if not broken:
        return "no camera with it could be built"
    amounts = ", ".join(f"{name} by {amount:.3g}" for name, amount in broken.items())
    return f"no camera with it keeps all constraints: the nearest breaks {amounts}"
