"""``tacos new-plugin``: a plugin project that installs, and passes its tests, as it is written."""

from __future__ import annotations

import keyword
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from tacos_framework import KINDS, Fault, UserError, did_you_mean
from tacos_framework.files import made_folder

_NAME = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
_TAKEN = frozenset(
    {
        "tacos_framework",
        "tacos_report",
        "tacos_plugins",
        "tacos_decision",
        "tacos_worlds",
        "tacos_gap",
        "tacos_validation",
    }
).union(sys.stdlib_module_names)

PROJECT_FILES = {
    "pyproject.toml": "project/pyproject.toml.j2",
    "README.md": "project/README.md.j2",
    ".gitignore": "project/gitignore.j2",
    "src/{package}/__init__.py": "project/package.py.j2",
    "src/{package}/plugin.py": "project/plugin.py.j2",
}
COMPONENT_FILES = {
    "src/{package}/{kind}.py": "components/{kind}.py.j2",
    "tests/test_{kind}.py": "tests/test_{kind}.py.j2",
}
"""Paths in the project, and the templates they are written from."""


def new_plugin(name: str, kinds: Sequence[str] = ("task",), *, folder: Path) -> list[Path]:
    """Write a plugin project.

    - `name`: name of the distribution, ``tacos-NAME`` by habit; its components are called NAME.
    - `kinds`: kinds of component it offers, one component of each.
    - `folder`: where the project's folder, called `name`, is made.

    Returns the files written.

    Raises `UserError` when the name cannot be that of a package, a kind is unknown, or the folder is there
    already or cannot be made.
    """
    project, component = folder / name, name.removeprefix("tacos-")
    kinds = tuple(dict.fromkeys(kinds))
    if faults := [*_name_faults(name, component), *_kind_faults(kinds), *_folder_faults(project)]:
        raise UserError(faults)
    package = name.replace("-", "_")
    words = {
        "name": name,
        "package": package,
        "component": component,
        "title": "".join(word.capitalize() for word in component.split("-")),
        "kinds": kinds,
    }
    files: dict[str, tuple[str, dict[str, str]]] = {
        path.format(**words): (template, {}) for path, template in PROJECT_FILES.items()
    }
    for kind in kinds:
        for path, template in COMPONENT_FILES.items():
            own = {"kind": kind}
            files[path.format(**words, **own)] = (template.format(**own), own)
    made_folder(project)
    written = []
    for path, (template, own) in files.items():
        target = project / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(_render(template, {**words, **own}), encoding="utf-8")
        written.append(target)
    return written


def _render(template: str, words: Mapping[str, object]) -> str:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("tacos_plugins.authoring.scaffold"),
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(words)


def _name_faults(name: str, component: str) -> list[Fault]:
    expected = "lower-case words joined by hyphens, such as tacos-fog"
    if not _NAME.fullmatch(name) or not _NAME.fullmatch(component):
        return [Fault(f"NAME {name!r}", "is no name for a plugin", expected)]
    package = name.replace("-", "_")
    if package in _TAKEN or keyword.iskeyword(package):
        what = f"its package {package!r} would hide a module of Python or of tacos-framework"
        return [Fault(f"NAME {name!r}", what, expected, f"Call it tacos-{component}-plugin, or else.")]
    return []


def _kind_faults(kinds: Sequence[str]) -> list[Fault]:
    if not kinds:
        return [Fault("--kind", "no kind is named", f"some of {', '.join(KINDS)}")]
    return [
        Fault(f"--kind {kind}", "there is no such kind of component", "", did_you_mean(kind, KINDS))
        for kind in kinds
        if kind not in KINDS
    ]


def _folder_faults(project: Path) -> list[Fault]:
    if not project.exists():
        return []
    return [Fault(str(project), "is there already", "a new folder", "Choose another name, or move it away.")]
