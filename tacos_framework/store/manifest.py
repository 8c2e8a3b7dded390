"""Start of a run on record: code, versions and files, so that nothing changes under it unnoticed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import BaseModel, ConfigDict

from tacos_framework.errors import Fault, UserError
from tacos_framework.store.database import damage
from tacos_framework.store.run import MANIFEST, Results

NAMED = 5
"""Changed files and parts of a sort that a sentence names; of the others it says how many they are."""


class Manifest(BaseModel):
    """Dependencies of a run's results beside its recipe. Machine and place are no part of it."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    python: str
    packages: dict[str, str]
    """Versions of the packages that tacos-framework needs, and of the distributions of plugins."""
    code: dict[str, dict[str, str]]
    """For each Python package whose components are used, the checksums of its files."""
    catalogs: dict[str, dict[str, str]]
    """For each catalog that is chosen from, the content keys of its parts; for products theirs."""
    files: dict[str, str]
    """Checksums of the files that settings name (``detect.weights: FILE``), folders file by file."""
    accepted: tuple[tuple[str, ...], ...] = ()
    """Changes, in sentences, each time the run went on with ``--accept-changes``."""

    def changes(self, now: Manifest) -> list[str]:
        """Differences to now, a sentence each."""
        return [
            *([f"Python is {now.python}, and was {self.python}"] if self.python != now.python else []),
            *(
                f"{name} is {now.packages.get(name, 'not used')}, and was {self.packages.get(name, 'not')}"
                for name in sorted({*self.packages, *now.packages})
                if self.packages.get(name) != now.packages.get(name)
            ),
            *_changes("the code of", self.code, now.code),
            *_changes("the catalog", self.catalogs, now.catalogs),
            *_changes("the files of settings", {"": self.files}, {"": now.files}),
        ]


def settle_manifest(results: Results, now: Manifest, *, accept_changes: bool, begun: bool) -> Manifest:
    """Write the manifest of a run that begins, or hold one that goes on against what is there now.

    - `results`: the folder of the run.
    - `now`: what the run depends on as of now.
    - `accept_changes`: go on although something has changed; the manifest then says what.
    - `begun`: whether the run has been going on already, so that a manifest must be there.

    Raises `UserError` with a fault for each change, where these are not accepted.
    """
    data = results.read_json(MANIFEST)
    path = results.folder / MANIFEST
    if data is None and begun:
        raise UserError(damage(path, "it is not there"))
    if data is None:
        results.write_json(MANIFEST, now.model_dump(mode="json"))
        return now
    try:
        before = Manifest.model_validate(data)
    except ValueError as error:  # pydantic's
        raise UserError(damage(path, f"it is no manifest: {error}")) from error
    changes = before.changes(now)
    if not changes:
        return before
    if not accept_changes:
        raise UserError(
            Fault(
                str(results.folder),
                f"since the run began, {change}",
                "what the run was started with, as its scores would not compare otherwise",
                "Put it back; or go on all the same with --accept-changes, which results will say.",
            )
            for change in changes
        )
    accepted = now.model_copy(update={"accepted": (*before.accepted, tuple(changes))})
    results.write_json(MANIFEST, accepted.model_dump(mode="json"))
    return accepted


def _changes(
    what: str, before: Mapping[str, Mapping[str, Any]], now: Mapping[str, Mapping[str, Any]]
) -> Iterator[str]:
    """Sentences on sets of things with a key each."""
    for name in sorted({*before, *now}):
        old, new = before.get(name, {}), now.get(name, {})
        said = [
            f"{_listed(names)} {verb}"
            for verb, names in (
                ("changed", [key for key in old if key in new and old[key] != new[key]]),
                ("came", [key for key in new if key not in old]),
                ("went", [key for key in old if key not in new]),
            )
            if names
        ]
        if said:
            yield f"{what} {name}".strip() + f" is not the same: {', '.join(said)}"


def _listed(names: list[str]) -> str:
    more = len(names) - NAMED
    return ", ".join(names[:NAMED]) + (f" and {more} more" if more > 0 else "")
