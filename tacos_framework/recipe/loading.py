"""Finding and reading recipes, for the command line and for library use alike."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from types import MappingProxyType
from typing import Any

from yaml.representer import RepresenterError

from tacos_framework.errors import Fault, UserError
from tacos_framework.packaged_resources import package_offering, shipped_recipes
from tacos_framework.recipe.parsing import recipe_from
from tacos_framework.recipe.procedure import ProcedureRecipe, is_procedure, procedure_from
from tacos_framework.recipe.recipe import Recipe
from tacos_framework.recipe.run_folder import RUN_RECIPE
from tacos_framework.settings.yaml_document import Document
from tacos_framework.settings.yaml_reader import read_yaml_draft
from tacos_framework.settings.yaml_writer import to_yaml


def find_recipe(name: str | Path) -> Path:
    """The file of a recipe: a path, or the name of one that is shipped.

    Raises `UserError` when there is neither.
    """
    path = Path(name)
    if path.suffix in (".yaml", ".yml") or path.is_file():
        return path
    shipped = shipped_recipes()
    if str(name) in shipped:
        return shipped[str(name)]
    if path.is_dir():
        raise UserError(_folder_fault(path))
    remedy = _near(str(name), shipped) if str(name) == path.name else "Check the path."
    if (package := package_offering(str(name))) is not None:
        remedy = f"pip install '{package}'"
    raise UserError(
        Fault(
            str(name),
            "there is no such recipe, and no folder of a run",
            "a YAML file, or the name of a shipped recipe",
            remedy,
        )
    )


def _near(name: str, shipped: Iterable[str]) -> str:
    """A shipped name much like the given one, or where all of them stand."""
    near = get_close_matches(name, shipped, n=1)
    return (
        f"Did you mean {near[0]!r}?"
        if near
        else ("Check the path, runs lie in runs/ by default; `tacos recipes` lists the recipes that ship.")
    )


def _folder_fault(folder: Path) -> Fault:
    """The fault of a folder in the place of a recipe."""
    if not (folder / RUN_RECIPE).is_file():
        return Fault(str(folder), "is a folder, and no run is in it", "the YAML file of a recipe")
    remedy = f"To go on with the run: tacos-run --resume {folder}. To look at it: tacos report {folder}."
    return Fault(str(folder), "is the folder of a run", "the YAML file of a recipe", remedy)


def read_any_recipe(
    name: str | Path | Mapping[str, Any],
    sets: Mapping[str, Any] | None = None,
    effects: Sequence[Mapping[str, Any]] = (),
    places: Mapping[tuple[str | int, ...], str] = MappingProxyType({}),
) -> tuple[Recipe | ProcedureRecipe, list[Fault]]:
    """Read the recipe of a study or of a procedure.

    - `name`: path of the file, name of a shipped recipe, or what such a file would hold.
    - `sets`: dotted keys and the values to put there (``--set``).
    - `effects`: effects to add (``--with``).
    - `places`: where their entries stand, by index and path: ``more.yaml:2:5``.

    Returns: the recipe, and the faults of its form. Where there are faults the recipe holds what could be
    understood, so that further checks can find further faults; it must not be run.

    Raises `UserError` when there is no such file, or it cannot be read as YAML at all.
    """
    document = _as_document(name) if isinstance(name, Mapping) else read_yaml_draft(find_recipe(name))
    read = procedure_from if is_procedure(document) else recipe_from
    return read(document, sets or {}, effects, places)


def _as_document(written: Mapping[str, Any]) -> Document:
    """A mapping as if it had been read from a file.

    Raises `UserError` when it holds what no YAML file can.
    """
    try:
        text = to_yaml(dict(written))
    except RepresenterError as error:
        found = error.args[-1]
        fault = Fault(
            "recipe",
            f"holds {found!r}, a {type(found).__name__}",
            "text, numbers, true, false, null, lists and dicts",
            "Turn it into one of these, for example by float() or .tolist().",
        )
        raise UserError(fault) from error
    return read_yaml_draft(text, "recipe")


def load_recipe(
    name: str | Path | Mapping[str, Any],
    sets: Mapping[str, Any] | None = None,
    effects: Sequence[Mapping[str, Any]] = (),
) -> Recipe | ProcedureRecipe:
    """Read a recipe by path, by the name of a shipped one, or from what its file would hold.

    `name`: path, name such as ``"headset_quick"``, or a mapping with the keys of a recipe. `sets`: dotted
    keys and the values to put there, e.g. ``{"optimizer.generations": 2}``.

    Raises `UserError` with every fault of its form. Components and wiring are checked by
    `tacos_framework.run`.
    """
    recipe, faults = read_any_recipe(name, sets, effects)
    if faults:
        raise UserError(faults)
    return recipe
