"""Tiers of the check, and the cases of each."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import cycle, islice
from typing import Any

import numpy as np

from tacos_framework import Settings, setting
from tacos_validation.blind.generators.catalogue import CATALOGUE
from tacos_validation.blind.generators.confounders import PAIRS
from tacos_validation.blind.generators.independent import VARIANTS, available
from tacos_validation.blind.generators.nuisances import NUISANCES
from tacos_validation.blind.generators.specifications import CaseSpecification

APART = (
    frozenset({"vignetting", "illumination-gradient", "lens-shading-correction"}),
    frozenset({"defocus", "lens-blur", "motion-blur", "denoise"}),
    frozenset({"lens-distortion", "focal-length-error", "pose-error"}),
    frozenset({"exposure-error", "tone-curve", "nonlinearity"}),
    frozenset({"dsnu", "prnu", "read-noise", "row-noise", "defect-lines"}),
)
"""Effects of one group never stand together in a case: two of them at once are no clear truth."""


class Counts(Settings):
    """Number of cases of each tier; the defaults take two hours on two cores."""

    t0: int = setting(20, help="T0, nothing withheld; 150 in full.", ge=0)
    ladder: tuple[float, ...] = setting(
        (1.0, 4.0, 8.0), help="T1, severities of every effect; 0.5, 1, 2, 4, 8 in full.", unit="floor"
    )
    charts: int = setting(1, help="T1, cases of each effect and severity with charts; 3 in full.", ge=0)
    field: int = setting(0, help="T1, cases of each effect at amplitudes met in the field; 1 in full.", ge=0)
    natural: int = setting(1, help="T1, cases of each effect with natural scenes alone; 3 in full.", ge=0)
    t2: int = setting(16, help="T2, two or three effects; 150 in full.", ge=0)
    t3: int = setting(12, help="T3, an effect whose class is removed; 99 in full, three of each.", ge=0)
    t4: int = setting(1, help="T4, cases of each independent maker; 3 in full.", ge=0)
    t6: int = setting(1, help="T6, cases of each pair of confounders; 5 in full.", ge=0)
    t7: int = setting(
        3, help="T7, cases of each nuisance with one effect, of severity 4 and 8 by turns; 16 in full.", ge=0
    )
    t7_quiet: int = setting(1, help="T7, cases of each nuisance with nothing withheld; 8 in full.", ge=0)
    speed: int = setting(1, help="Cases of 640 x 480 that are timed alone.", ge=0)
    effects: tuple[str, ...] = setting((), help="Effects to withhold; all of the catalogue if empty.")


def case_specifications(
    counts: Counts, seed: int, size_px: tuple[int, int], full_set: str = "charts"
) -> list[CaseSpecification]:
    """All cases, in random order and with random names, so that neither tells what is in them."""
    rng = np.random.default_rng([seed, 1])
    drafts = list(_drafts(counts, rng, full_set))
    named = []
    for draft in drafts:
        name = rng.bytes(6).hex()
        width, height = draft.get("notes", {}).get("size_px", size_px)
        named.append(
            CaseSpecification(
                case=name, seed=int(rng.integers(2**62)), width_px=width, height_px=height, **draft
            )
        )
    return [named[i] for i in rng.permutation(len(named))]


def _drafts(counts: Counts, rng: np.random.Generator, full_set: str) -> Iterator[dict[str, Any]]:
    effects = counts.effects or tuple(CATALOGUE)
    strongest = max(counts.ladder, default=8.0)
    full = {"severity": strongest, "captures": full_set}
    for _ in range(counts.speed):
        yield {"tier": "speed", "captures": full_set, "notes": {"size_px": (640, 480)}}
    for _ in range(counts.t0):
        yield {"tier": "T0", "captures": full_set}
    for name in effects:
        for severity in counts.ladder:
            for _ in range(counts.charts):
                asked = {"severity": severity, "scored_on_fresh": severity == strongest}
                yield {"tier": "T1", "effects": (name,), "captures": _shows(name, full_set), **asked}
        for _ in range(counts.field):
            yield {
                "tier": "T1",
                "effects": (name,),
                "severity": None,
                "captures": _shows(name, full_set),
            }
        for _ in range(counts.natural if CATALOGUE[name].natural else 0):
            yield {"tier": "T1", "effects": (name,), "severity": strongest, "captures": "natural"}
    for name in islice(cycle(rng.permutation(effects).tolist()), counts.t3):
        own = {**full, "captures": _shows(name, full_set)}
        yield {"tier": "T3", "effects": (name,), "removed": (name,), **own}
    effects = tuple(name for name in effects if not CATALOGUE[name].captures)
    for _ in range(counts.t2 if effects else 0):
        mixed = _mixture(effects, rng)
        yield {"tier": "T2", "effects": mixed, "scored_on_fresh": True, **full}
    for maker in available():
        effect = VARIANTS[maker].effect
        for _ in range(counts.t4 if effect in effects else 0):
            yield {"tier": "T4", "effects": (effect,), "variants": {effect: maker}, **full}
    for pair, members in PAIRS.items():
        for split in (False, True) if members.truth in effects else ():
            for _ in range(counts.t6):
                notes = {"pair": pair, "split": split}
                yield {"tier": "T6", "effects": (members.truth,), "severity": strongest, "notes": notes}

    yield from _beside_nuisances(counts, effects, rng, full_set)


def _shows(effect: str, full_set: str) -> str:
    """The set of captures for an effect."""
    return CATALOGUE[effect].captures or full_set


def _beside_nuisances(
    counts: Counts, effects: tuple[str, ...], rng: np.random.Generator, full_set: str
) -> Iterator[dict[str, Any]]:
    for name, nuisance in NUISANCES.items():
        common = {"tier": "T7", "captures": full_set, "nuisance": name}
        for _ in range(counts.t7_quiet):
            yield common
        told = rng.permutation(np.array(nuisance.bears(effects), dtype=object)).tolist()
        for i in range(counts.t7 if told else 0):
            yield {**common, "effects": (told[i % len(told)],), "severity": (4.0, 8.0)[i % 2]}


def _mixture(effects: tuple[str, ...], rng: np.random.Generator) -> tuple[str, ...]:
    """Two or three effects that do not veil one another."""
    wanted = int(rng.integers(2, 4))
    chosen: list[str] = []
    for i in rng.permutation(len(effects)):
        name = effects[i]
        if all(not (name in group and set(chosen) & group) for group in APART):
            chosen.append(name)
        if len(chosen) == wanted:
            break
    return tuple(chosen)
