"""What a case is to be, and how it is made."""

from __future__ import annotations

import hashlib
import json
import secrets
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tacos_validation.blind.generators.catalogue import CATALOGUE, Withheld
from tacos_validation.blind.generators.confounders import Make, takings_of
from tacos_validation.blind.generators.flaw import Flaw
from tacos_validation.blind.generators.folders import write_folder
from tacos_validation.blind.generators.severity import Floor, calibrated
from tacos_validation.blind.generators.takings import SETS, new_camera

CAPTURES, KEPT_BACK = "captures", "kept_back"
"""Folders of a case: what the solver gets, and fresh captures that its answer is judged on."""


@dataclass(frozen=True)
class Order:
    """A case to be made.

    Parameters
    ----------
    case
        Its random name.
    seed
        Draws everything in it.
    tier
        ``T0`` to ``T6``.
    effects
        What is withheld; nothing in T0.
    severity
        In floor units; None draws amplitudes as met in the field.
    captures
        Name of a set of captures.
    width_px, height_px
        Size of the files.
    removed
        Effects that the solver's catalogue lacks.
    variants
        Other makers of an effect than the catalogue's, by name of the effect.
    judged
        Whether fresh captures are made too.
    notes
        Further facts for the report: of a pair, which and whether the splitting capture is there.
    """

    case: str
    seed: int
    tier: str
    effects: tuple[str, ...] = ()
    severity: float | None = 8.0
    captures: str = "charts"
    width_px: int = 320
    height_px: int = 240
    removed: tuple[str, ...] = ()
    variants: Mapping[str, str] = field(default_factory=dict)
    judged: bool = False
    notes: Mapping[str, Any] = field(default_factory=dict)


def make(order: Order, folder: Path) -> dict[str, Any]:
    """Make a case below `folder`; what was withheld, and how much of it, is returned."""
    rng = np.random.default_rng(order.seed)
    colour = any(entry_of(order, name).colour for name in order.effects) or rng.random() < 0.25
    camera = new_camera(rng, order.width_px, order.height_px, 3 if colour else 1)
    captures = _captures(order)
    takings = captures(camera, rng)
    sensor_seed = int(rng.integers(2**31))
    flaws, withheld = [], []
    floor = Floor(takings, camera, sensor_seed) if order.effects else None
    for i, name in enumerate(order.effects):
        assert floor is not None
        flaw, units = _flaw(entry_of(order, name), order, i, rng, floor)
        flaws.append(flaw)
        withheld.append({"effect": name, "parameters": flaw.parameters, "units": round(units, 3)})
    write_folder(folder / CAPTURES, camera, takings, flaws, rng, sensor_seed)
    if order.judged:
        fresh = captures(camera, rng)
        write_folder(folder / KEPT_BACK, camera, fresh, flaws, rng, sensor_seed)
    return {"order": asdict(order), "withheld": withheld, "camera": asdict(camera)}


def _captures(order: Order) -> Make:
    pair = order.notes.get("pair")
    return takings_of(str(pair), bool(order.notes["split"])) if pair else SETS[order.captures]


def entry_of(order: Order, effect: str) -> Withheld:
    """The maker of an effect in an order."""
    variant = order.variants.get(effect)
    if variant is None:
        return CATALOGUE[effect]
    from tacos_validation.blind.generators.independent import VARIANTS

    return VARIANTS[variant].entry


def _flaw(
    entry: Withheld, order: Order, place: int, rng: np.random.Generator, floor: Floor
) -> tuple[Flaw, float]:
    seed = int(rng.integers(2**31))

    def build(amplitude: float) -> Flaw:
        return entry.build(amplitude, np.random.default_rng([seed, place]))

    low, high = entry.field
    if order.severity is None:
        flaw = build(float(rng.uniform(low, high)))
        return flaw, floor.severity([flaw])
    if not floor.measures:  # boards alone: as strong as it gets in the field
        return build(high), 0.0
    usual = float(np.sqrt(max(low, 0.02 * high) * high))
    return calibrated(build, order.severity, floor, usual, entry.largest)


@dataclass(frozen=True)
class Seal:
    """A truth nobody can change unnoticed: the digest is known before the solver starts.

    Parameters
    ----------
    case
        Name of the case.
    digest
        SHA-256 of the salt and the truth.
    """

    case: str
    digest: str


def sealed(case: str, truth: Mapping[str, Any], file: Path) -> Seal:
    """Write the truth with a salt, and return its seal."""
    content = json.dumps({"salt": secrets.token_hex(16), "truth": truth}, sort_keys=True)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(content, "utf-8")
    return Seal(case, hashlib.sha256(content.encode()).hexdigest())


def opened(seal: Seal, file: Path) -> dict[str, Any]:
    """The truth behind a seal.

    Raises
    ------
    ValueError
        When it is not what was sealed.
    """
    content = file.read_text("utf-8")
    if hashlib.sha256(content.encode()).hexdigest() != seal.digest:
        raise ValueError(f"the truth of case {seal.case} is not the one that was sealed")
    truth: dict[str, Any] = json.loads(content)["truth"]
    return truth


def make_sealed(order: Order, cases: Path, truths: Path) -> Seal:
    """Make a case and seal its truth: all that the generator's process does."""
    truth = make(order, cases / order.case)
    return sealed(order.case, truth, truths / f"{order.case}.json")
