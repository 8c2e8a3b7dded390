#!/usr/bin/env python3
"""Prints the extras of this project as a table: what each is for, and what it adds to an installation.

    .venv/bin/python scripts/extras.py

Sizes are those of the files of all packages an extra needs and the package alone does not, as installed in
this environment; an extra that is not installed here in full has none.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement

PROJECT = "tacos-framework"
PYPROJECT = Path(__file__).resolve().parent.parent / "pyproject.toml"


def needed(requirement: Requirement, seen: set[tuple[str, str]]) -> Iterator[str]:
    """Names of the packages a requirement brings, itself first; raises where one is not installed."""
    for extra in ("", *sorted(requirement.extras)):
        if (requirement.name, extra) in seen:
            continue
        seen.add((requirement.name, extra))
        if requirement.name != PROJECT:
            yield requirement.name.lower().replace("_", "-")
        for line in distribution(requirement.name).requires or ():
            below = Requirement(line)
            if below.marker is None or below.marker.evaluate({"extra": extra}):
                yield from needed(below, seen)


def megabytes(name: str) -> float:
    """The size of an installed package's files [MB]."""
    files = distribution(name).files or ()
    return sum(Path(file.locate()).stat().st_size for file in files if Path(file.locate()).is_file()) / 1e6


def main() -> None:
    """Print the table."""
    extras = tomllib.loads(PYPROJECT.read_text("utf-8"))["project"]["optional-dependencies"]
    alone = set(needed(Requirement(PROJECT), set()))
    print("| extra | packages | adds |\n| --- | --- | --- |")
    print(f"| (none) | {len(alone)} | {sum(map(megabytes, alone)):.0f} MB |")
    for extra, requirements in extras.items():
        named = ", ".join(f"`{Requirement(line).name}`" for line in requirements)
        try:
            added = set(needed(Requirement(f"{PROJECT}[{extra}]"), set())) - alone
            size = sum(map(megabytes, added))
            print(f"| `{extra}` | {named} | {f'{size / 1e3:.1f} GB' if size > 1e3 else f'{size:.0f} MB'} |")
        except PackageNotFoundError as error:
            print(f"| `{extra}` | {named} | not installed here: {error.name} |")


if __name__ == "__main__":
    main()
