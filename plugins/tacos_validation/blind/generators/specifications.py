"""Specification of a case, and the way it is made."""

from __future__ import annotations

import hashlib
import json
import secrets
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tacos_validation.blind.generators.acquisitions import SETS, new_camera
from tacos_validation.blind.generators.catalogue import CATALOGUE, Withheld
from tacos_validation.blind.generators.confounders import Make, acquisitions_of
from tacos_validation.blind.generators.folders import write_folder
from tacos_validation.blind.generators.injected_effect import InjectedEffect
from tacos_validation.blind.generators.nuisances import (
    NUISANCES,
    Nuisance,
    described,
    drawn,
    pipeline_of,
    without_pedestal,
)
from tacos_validation.blind.generators.severity import NoiseFloor, calibrated

CAPTURES, KEPT_BACK = "captures", "kept_back"
"""Folders of a case: what the solver sees, and fresh captures that its answer is scored on."""


@dataclass(frozen=True)
class CaseSpecification:
    case: str
    seed: int
    tier: str
    effects: tuple[str, ...] = ()
    severity: float | None = 8.0  # in units of the noise floor; None draws amplitudes as met in the field
    captures: str = "charts"
    width_px: int = 320
    height_px: int = 240
    removed: tuple[str, ...] = ()  # effects that the solver's catalogue lacks
    variants: Mapping[str, str] = field(default_factory=dict)
    """Other makers of an effect than the catalogue's, by name of the effect."""
    scored_on_fresh: bool = False  # true if fresh captures are made too
    nuisance: str = ""
    notes: Mapping[str, Any] = field(default_factory=dict)
    """Further facts for the report: of a pair, which and whether the splitting capture is there."""


def make(spec: CaseSpecification, folder: Path) -> dict[str, Any]:
    """Make a case below `folder`; what was withheld, and how much of it, is returned."""
    rng = np.random.default_rng(spec.seed)
    colour = any(entry_of(spec, name).colour for name in spec.effects) or rng.random() < 0.25
    nuisance = NUISANCES[spec.nuisance] if spec.nuisance else Nuisance()
    off_rng = np.random.default_rng([spec.seed, 1])  # its own, so that nuisances leave all else as it is
    camera = without_pedestal(new_camera(rng, spec.width_px, spec.height_px, 3 if colour else 1), nuisance)
    captures = _captures(spec)
    acquisitions = captures(camera, rng)
    sensor_seed = int(rng.integers(2**31))
    effects: list[InjectedEffect] = []
    withheld = []
    floor = NoiseFloor(acquisitions, camera, sensor_seed) if spec.effects else None
    for i, name in enumerate(spec.effects):
        assert floor is not None
        effect, units = _injected(entry_of(spec, name), spec, i, rng, floor)
        effects.append(effect)
        withheld.append({"effect": name, "parameters": effect.parameters, "units": round(units, 3)})
    pipeline, off = pipeline_of(nuisance, off_rng), drawn(nuisance, acquisitions, off_rng)
    effects += pipeline
    write_folder(folder / CAPTURES, camera, acquisitions, effects, rng, sensor_seed, off)
    if spec.scored_on_fresh:
        fresh = captures(camera, rng)
        write_folder(folder / KEPT_BACK, camera, fresh, effects, rng, sensor_seed)
    truth = {"specification": asdict(spec), "withheld": withheld, "camera": asdict(camera)}
    if not spec.nuisance:
        return truth
    return {**truth, "off": described(off, pipeline), "known": _known(spec, nuisance)}


def _known(spec: CaseSpecification, nuisance: Nuisance) -> dict[str, list[str]]:
    """Causes that may come first and that may stand beside it; without effects, either or nothing."""
    accept, beside = [*spec.effects, *nuisance.effects], list(nuisance.may_be_called)
    if accept:
        return {"accept": accept, "also": beside, "expect_verdict": ["explained", "partly_explained"]}
    return {"accept": beside, "also": beside, "expect_verdict": ["no_gap", "explained"]}


def _captures(spec: CaseSpecification) -> Make:
    pair = spec.notes.get("pair")
    return acquisitions_of(str(pair), bool(spec.notes["split"])) if pair else SETS[spec.captures]


def entry_of(spec: CaseSpecification, effect: str) -> Withheld:
    variant = spec.variants.get(effect)
    if variant is None:
        return CATALOGUE[effect]
    from tacos_validation.blind.generators.independent import VARIANTS

    return VARIANTS[variant].entry


def _injected(
    entry: Withheld, spec: CaseSpecification, place: int, rng: np.random.Generator, floor: NoiseFloor
) -> tuple[InjectedEffect, float]:
    seed = int(rng.integers(2**31))

    def build(amplitude: float) -> InjectedEffect:
        return entry.build(amplitude, np.random.default_rng([seed, place]))

    low, high = entry.field
    if spec.severity is None:
        effect = build(float(rng.uniform(low, high)))
        return effect, floor.severity([effect])
    if not floor.measures:  # boards alone: as strong as it gets in the field
        return build(high), 0.0
    usual = float(np.sqrt(max(low, 0.02 * high) * high))
    return calibrated(build, spec.severity, floor, usual, entry.largest)


@dataclass(frozen=True)
class Commitment:
    """A hash commitment to a truth: it cannot change unnoticed, as the digest is known before the solver
    starts.
    """

    case: str
    digest: str  # SHA-256 of the salt and the truth


def commit(case: str, truth: Mapping[str, Any], file: Path) -> Commitment:
    content = json.dumps({"salt": secrets.token_hex(16), "truth": truth}, sort_keys=True)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(content, "utf-8")
    return Commitment(case, hashlib.sha256(content.encode()).hexdigest())


def reveal(commitment: Commitment, file: Path) -> dict[str, Any]:
    """The truth behind a commitment. Raises ValueError when it is not what was committed to."""
    content = file.read_text("utf-8")
    if hashlib.sha256(content.encode()).hexdigest() != commitment.digest:
        raise ValueError(f"the truth of case {commitment.case} is not the one that was committed to")
    truth: dict[str, Any] = json.loads(content)["truth"]
    return truth


def make_and_commit(spec: CaseSpecification, cases: Path, truths: Path) -> Commitment:
    truth = make(spec, cases / spec.case)
    return commit(spec.case, truth, truths / f"{spec.case}.json")
