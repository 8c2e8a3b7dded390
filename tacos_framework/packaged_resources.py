"""Files that come with packages: recipes and catalogs, found from any folder."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import Literal

from tacos_framework.errors import Fault, UserError, did_you_mean
from tacos_framework.files import read_json

_PACKAGE = Path(__file__).resolve().parent

RECIPES_GROUP = "tacos_recipes"
"""Entry points of this group name packages whose YAML files are recipes: ``"my_plugin.recipes"``."""


def shipped_folder(kind: Literal["catalogs", "recipes"]) -> Path:
    """The folder of shipped files: inside an installed package, or beside it in a checkout."""
    installed = _PACKAGE / kind
    return installed if installed.is_dir() else _PACKAGE.parent / kind


def recipe_folders() -> tuple[Path, ...]:
    """The folders of the recipes that run by name: the framework's, then those of plugin packages."""
    return (shipped_folder("recipes"), *_folders_of_plugins())


def shipped_recipes() -> dict[str, Path]:
    """The files of the recipes that run by name, sorted by name; a plugin's never hides the framework's."""
    found = {file.stem: file for folder in reversed(recipe_folders()) for file in folder.glob("*.yaml")}
    return {name: found[name] for name in sorted(found)}


def package_offering(name: str) -> str | None:
    """The package to install for a component (``procedure.NAME``) or recipe of a known distribution."""
    known = read_json(shipped_folder("catalogs") / "plugin_packages.json")
    for package, offers in known.items():
        if name in (*offers["components"], *offers["recipes"]):
            return str(package)
    return None


def _folders_of_plugins() -> Iterator[Path]:
    for point in sorted(entry_points(group=RECIPES_GROUP)):
        try:
            spec = find_spec(point.value)
        except ImportError:  # `tacos plugins` lists the package as broken
            continue
        if spec is not None:
            yield from map(Path, spec.submodule_search_locations or ())


def find_file(name: str | Path, shipped: Path, *, folder: Path | None = None, noun: str) -> Path:
    """The file a recipe means by a name or a path.

    - `name`: a bare word is the name of a shipped file; anything else is a path.
    - `shipped`: the folder of shipped files of this sort (``*.yaml``).
    - `folder`: the folder of the recipe, where its paths start; None for paths that start from the working
      folder, such as those of the command line and of callers in Python.
    - `noun`: what it is, for messages.

    Raises `UserError` when there is no such file.
    """
    text = str(name)
    if is_shipped_name(text):
        file = shipped / f"{text}.yaml"
        if file.is_file():
            return file
        raise UserError(_unknown(text, shipped, folder, noun))
    path = Path(text) if folder is None else folder / text
    if "\0" in text:
        raise UserError(Fault(repr(text), "a path cannot hold a NUL character"))
    if not path.is_file():
        raise UserError(Fault(str(path), f"there is no such {noun}", "a file", "Check the path."))
    return path


def shipped_names(folder: Path) -> tuple[str, ...]:
    return tuple(sorted(file.stem for file in folder.glob("*.yaml")))


def is_shipped_name(text: str) -> bool:
    """True for a bare word, which names a shipped file rather than a path."""
    return text.replace("_", "a").replace("-", "a").isalnum()


def _unknown(name: str, shipped: Path, folder: Path | None, noun: str) -> Fault:
    beside = (folder or Path()) / name
    for suffix in (".yaml", ".csv"):
        if beside.with_suffix(suffix).is_file():
            remedy = f"Write '{name}{suffix}' to use the file beside the recipe."
            return Fault(name, f"no {noun} of this name is shipped", "", remedy)
    return Fault(
        name,
        f"no {noun} of this name is shipped",
        "a shipped name, or a path beside the recipe",
        did_you_mean(name, shipped_names(shipped)),
    )
