"""Files that come with the package: recipes and catalogs, found from any folder."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from tacos_framework.errors import Fault, UserError, did_you_mean

_PACKAGE = Path(__file__).resolve().parent


def shipped_folder(kind: Literal["catalogs", "recipes"]) -> Path:
    """The folder of shipped files: inside an installed package, or beside it in a checkout."""
    installed = _PACKAGE / kind
    return installed if installed.is_dir() else _PACKAGE.parent / kind


def find_file(name: str | Path, shipped: Path, *, folder: Path | None = None, noun: str) -> Path:
    """The file a recipe means by a name or a path.

    Parameters
    ----------
    name
        A bare word is the name of a shipped file; anything else is a path.
    shipped
        The folder of shipped files of this sort (``*.yaml``).
    folder
        The folder of the recipe, where its paths start; None for paths that start from the working folder,
        such as those of the command line and of callers in Python.
    noun
        What it is, for messages.

    Raises
    ------
    UserError
        When there is no such file.
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
    """The names of the shipped files in a folder, sorted."""
    return tuple(sorted(file.stem for file in folder.glob("*.yaml")))


def is_shipped_name(text: str) -> bool:
    """Whether a text is a bare word, and so means a shipped file rather than a path."""
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
