"""Studies of claims, the scorings they are run under, and the claims themselves."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from pydantic import JsonValue, model_validator

from tacos_framework import Settings, did_you_mean, setting
from tacos_framework.store import DESIGNED

Changes = dict[str, JsonValue]


class ClaimStudy(Settings):
    study: str = setting(help="Its recipe: a path, or the name of a shipped one.", is_path=True)
    change: Changes = setting(
        {}, help="Keys of that recipe to change, as with --set, over those of a scoring."
    )


class Claim(Settings):
    """A sentence, and the comparison that decides it."""

    says: str = setting(help="The claim in a sentence.", min_length=1)
    of: str = setting(help="The study that it is about.")
    over: tuple[str, ...] = setting(
        help="The studies it is compared with, each a name or NAME/CAMERA for a product that the study "
        "compares with; the claim holds if it holds over all of them.",
        min_length=1,
    )
    value: str = setting(
        "test.fitness",
        help="The figure compared: camera.VARIABLE, derived.QUANTITY, test.SCORE, or images: those rendered "
        "until a search is as good as the worse of the two ends.",
        pattern=r"^((camera|derived|test)\..+|images)$",
    )
    better: Literal["higher", "lower"] = setting("higher", help="Direction that supports the claim.")
    equal_within: float | None = setting(
        None, help="Difference up to which figures are equal, where equality is the claim.", gt=0
    )


class ClaimsConfig(Settings):
    seeds: int = setting(
        20, help="Runs of each study; each seed has scenes and unseen scenes of its own.", ge=2
    )
    confidence: float = setting(0.95, help="Confidence of the intervals that decide.", gt=0, lt=1)
    change: dict[str, Changes] = setting({}, help="For each recipe the keys to change throughout.")
    scorings: dict[str, dict[str, Changes]] = setting(
        {"as it stands": {}},
        help="Ways of scoring by name: for each recipe the keys that state it; all studies run under each.",
        min_length=1,
    )
    studies: dict[str, ClaimStudy] = setting(help="The studies by name.", min_length=1)
    optional: tuple[str, ...] = setting(
        (), help="Studies to leave out, with a note, where the packages they need are not installed."
    )
    claims: dict[str, Claim] = setting(help="The claims by name.", min_length=1)
    skip: tuple[str, ...] = setting(
        (), help="Claims and scorings to leave out by name, with the studies that no other claim names."
    )
    source: str = setting("", help="Origin of the claims, e.g. a paper.")

    @model_validator(mode="after")
    def _fits_together(self) -> ClaimsConfig:
        if wrong := list(self._misfits()):
            raise ValueError("; ".join(wrong))
        return self

    def without_skipped(self) -> ClaimsConfig:
        """The same without what `skip` names, and without studies that no claim is left to name."""
        claims = {name: claim for name, claim in self.claims.items() if name not in self.skip}
        named = {study_and_camera(each)[0] for claim in claims.values() for each in (claim.of, *claim.over)}
        return self.model_copy(
            update={
                "claims": claims,
                "scorings": {name: keys for name, keys in self.scorings.items() if name not in self.skip},
                "studies": {name: study for name, study in self.studies.items() if name in named},
            }
        )

    def _misfits(self) -> Iterator[str]:
        for name in (*self.studies, *self.scorings):
            if not name.replace("_", "").replace("-", "").replace(" ", "").isalnum():
                yield f"names of studies and scorings are parts of folders' names, so not {name!r}"
        recipes = {study.study for study in self.studies.values()}
        for place, changes in {"change": self.change, **self.scorings}.items():
            for recipe in sorted(changes.keys() - recipes):
                yield f"{place} has keys for {recipe!r}, which no study uses"
        for name in self.optional:
            if name not in self.studies:
                yield f"optional names no study {name!r}. {did_you_mean(name, self.studies)}".rstrip()
        names = [*self.claims, *self.scorings]
        for name in self.skip:
            if name not in names:
                yield f"skip names no claim and no scoring {name!r}. {did_you_mean(name, names)}".rstrip()
        for what, every in {"claim": set(self.claims), "scoring": set(self.scorings)}.items():
            if every <= set(self.skip):
                yield f"skip leaves no {what}"
        for name, claim in self.claims.items():
            for named in (claim.of, *claim.over):
                study, _ = study_and_camera(named)
                if study not in self.studies:
                    hint = did_you_mean(study, self.studies)
                    yield f"claims.{name} names no study {study!r}. {hint}".rstrip()


def study_and_camera(named: str) -> tuple[str, str]:
    """The study and the camera of it that a claim names.

    >>> study_and_camera("day/flea3"), study_and_camera("night")
    (('day', 'flea3'), ('night', 'designed'))
    """
    study, _, camera = named.partition("/")
    return study, camera or DESIGNED
