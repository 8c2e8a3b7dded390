"""Dependencies of a run's results: code, versions, parts of catalogs, files of settings."""

from __future__ import annotations

import importlib.util
import platform
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path

from tacos_framework.cache import content_key
from tacos_framework.environment import package_versions
from tacos_framework.errors import Fault, UserError
from tacos_framework.files.trees import checksums_below
from tacos_framework.packaged_resources import recipe_folders, shipped_folder
from tacos_framework.plan import Plan
from tacos_framework.plan.procedure import ProcedurePlan
from tacos_framework.plugins import Plugins
from tacos_framework.settings import Settings, paths_in
from tacos_framework.store.manifest import Manifest
from tacos_framework.variables import CatalogChoice

FRAMEWORK = "tacos_framework"


def manifest_of_study(plan: Plan) -> Manifest:
    """The manifest of a study that starts now: of the components that its recipe names."""
    parts = plan.parts
    return Manifest(
        python=platform.python_version(),
        packages=package_versions({part.distribution for part in parts.values() if part.distribution}),
        code=_code_of_all(part.cls.__module__ for part in parts.values()),
        catalogs=_catalogs(plan),
        files=dict(_files({place: part.config for place, part in parts.items()})),
    )


def manifest_of_procedure(plan: ProcedurePlan, plugins: Plugins) -> Manifest:
    """The manifest of a procedure that starts now: of all components, as it may run any study."""
    offered = list(plugins)
    modules = [plan.cls.__module__, *(each.component.target.partition(":")[0] for each in offered)]
    return Manifest(
        python=platform.python_version(),
        packages=package_versions({each.distribution for each in offered if each.distribution}),
        code=_code_of_all(modules),
        catalogs={},
        files=dict(_files({plan.recipe.use: plan.config})),
    )


def _code_of_all(modules: Iterable[str]) -> dict[str, dict[str, str]]:
    """The code of the packages that modules are in, and of the framework."""
    packages = {FRAMEWORK, *(module.partition(".")[0] for module in modules)}
    return {package: _code_of(package) for package in sorted(packages)}


@cache
def _code_of(package: str) -> dict[str, str]:
    """Checksums of a package's files by their names; read once, as this process keeps what it imported."""
    try:
        spec = importlib.util.find_spec(package) if package != "__main__" else None
    except ValueError:  # a module that was made, not imported
        spec = None
    if spec is None:
        return {}
    if not spec.submodule_search_locations:
        return dict(checksums_below(Path(spec.origin))) if spec.origin and Path(spec.origin).is_file() else {}
    data = (shipped_folder("catalogs"), *recipe_folders())
    return {
        name: checksum
        for folder in map(Path, spec.submodule_search_locations)
        for name, checksum in checksums_below(folder).items()
        if not any((folder / name).is_relative_to(shipped) for shipped in data)
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


def _files(settings: Mapping[str, Settings]) -> Iterator[tuple[str, str]]:
    """Checksums of the files that settings name, by place: by a path, or as data that are shipped."""
    for place, config in settings.items():
        for name, value in paths_in(config):
            for path in _meant(value):
                for file, checksum in _readable_checksums(path, f"{place}.{name}").items():
                    yield f"{place}.{name}: {file}", checksum


def _readable_checksums(path: Path, where: str) -> Mapping[str, str]:
    try:
        return checksums_below(path)
    except OSError as error:
        what = f"{error.filename or path} cannot be read: {error.strerror}"
        raise UserError(Fault(where, what, "files that may be read")) from error


def _meant(value: str) -> Iterable[Path]:
    path = Path(value).expanduser()
    return [path] if path.exists() else sorted(shipped_folder("catalogs").rglob(f"{value.strip('/*')}.*"))
