"""What a run was started with: code, versions and files, so that nothing changes under it unnoticed."""

from __future__ import annotations

import importlib.util
import platform
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Self

from pydantic import BaseModel, ConfigDict

from tacos_framework.cache import content_key
from tacos_framework.environment import package_versions
from tacos_framework.errors import Fault, UserError
from tacos_framework.packaged_resources import shipped_folder
from tacos_framework.plan import ConfiguredComponent, Plan
from tacos_framework.results import Results
from tacos_framework.results.reading import MANIFEST, checksum_of_file, damage
from tacos_framework.variables import CatalogChoice

FRAMEWORK = "tacos_framework"
NAMED = 5
"""Changed files and parts of a sort that a sentence names; of the others it says how many they are."""


class Manifest(BaseModel):
    """What the results of a study depend on, beside its recipe. Where it runs is no part of it.

    Parameters
    ----------
    python
        Version of Python.
    packages
        Versions of the packages that tacos-framework needs, and of the distributions of plugins.
    code
        For each Python package whose components are used, the checksums of its files.
    catalogs
        For each catalog that is chosen from, the content keys of its parts; for products theirs.
    files
        Checksums of the files that settings name (``detect.weights: FILE``), folders file by file.
    accepted
        What had changed, in sentences, each time the study went on with ``--accept-changes``.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    python: str
    packages: dict[str, str]
    code: dict[str, dict[str, str]]
    catalogs: dict[str, dict[str, str]]
    files: dict[str, str]
    accepted: tuple[tuple[str, ...], ...] = ()

    @classmethod
    def of(cls, plan: Plan) -> Self:
        """The manifest of a study that starts now."""
        parts = dict(_parts(plan))
        distributions = {part.distribution for part in parts.values() if part.distribution}
        packages = {part.cls.__module__.partition(".")[0] for part in parts.values()}
        return cls(
            python=platform.python_version(),
            packages=package_versions() | {name: _version(name) for name in distributions},
            code={name: _code_of(name) for name in sorted({FRAMEWORK, *packages})},
            catalogs=_catalogs(plan),
            files=dict(_files(parts)),
        )

    def changes(self, now: Manifest) -> list[str]:
        """What is different now, a sentence each."""
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


def settle_manifest(results: Results, plan: Plan, *, accept_changes: bool, begun: bool) -> Manifest:
    """Write the manifest of a run that begins, or hold one that goes on against what is there now.

    Parameters
    ----------
    results
        The folder of the run.
    plan
        What is run.
    accept_changes
        Go on although something has changed; the manifest then says what.
    begun
        Whether the run has been going on already, so that a manifest must be there.

    Raises
    ------
    UserError
        With a fault for each change, where these are not accepted.
    """
    now = Manifest.of(plan)
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


def _parts(plan: Plan) -> Iterator[tuple[str, ConfiguredComponent]]:
    """The components that results depend on, by the name of their place."""
    yield from plan.nodes.items()
    yield "rig", plan.rig
    yield "optimizer", plan.optimizer
    for number, effect in enumerate(plan.effects):
        yield f"effects.{effect.name or number}", effect


def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return "not installed"


@cache
def _code_of(package: str) -> dict[str, str]:
    """Checksums of a package's files by their names; read once, as this process keeps what it imported."""
    spec = importlib.util.find_spec(package) if package != "__main__" else None
    if spec is None:
        return {}
    if not spec.submodule_search_locations:
        return _tree(Path(spec.origin)) if spec.origin and Path(spec.origin).is_file() else {}
    return {
        name: found
        for folder in spec.submodule_search_locations
        for name, found in _tree(Path(folder)).items()
    }


def _tree(path: Path) -> dict[str, str]:
    """Checksums of a file, or of the files in a folder, by names below it; shipped data are kept apart."""
    if path.is_file():
        return {path.name: checksum_of_file(path)}
    data = [shipped_folder("catalogs"), shipped_folder("recipes")]
    return {
        str(file.relative_to(path)): checksum_of_file(file)
        for file in sorted(path.rglob("*"))
        if file.is_file() and "__pycache__" not in file.parts and not any(map(file.is_relative_to, data))
    }


def _catalogs(plan: Plan) -> dict[str, dict[str, str]]:
    choices = [variable for variable in plan.space.variables if isinstance(variable, CatalogChoice)]
    found = {
        choice.catalog.name: {row.name: content_key(row.values) for row in choice.catalog.rows}
        for choice in choices
    }
    if plan.cameras:
        found["products"] = {camera.name: content_key(camera.fixes) for camera in plan.cameras}
    return found


def _files(parts: Mapping[str, ConfiguredComponent]) -> Iterator[tuple[str, str]]:
    """Checksums of the files that settings name: by a path, or as data that are shipped."""
    for place, part in parts.items():
        for name, field in type(part.config).model_fields.items():
            extra, value = field.json_schema_extra, getattr(part.config, name)
            if not (isinstance(extra, dict) and extra.get("path") and isinstance(value, str) and value):
                continue
            for path in _meant(value):
                for file, found in _tree(path).items():
                    yield f"{place}.{name}: {file}", found


def _meant(value: str) -> Iterable[Path]:
    path = Path(value).expanduser()
    return [path] if path.exists() else sorted(shipped_folder("catalogs").rglob(f"{value.strip('/*')}.*"))


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
