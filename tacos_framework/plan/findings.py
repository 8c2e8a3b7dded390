"""Components of a recipe by name, and every fault with its position."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any

from pydantic import Field

from tacos_framework.errors import Fault, UserError
from tacos_framework.plan.component import ConfiguredComponent
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Recipe, Use
from tacos_framework.settings import KeyPath, Settings, check, with_paths_from

_CAMERAS = Annotated[tuple[str, ...], Field(min_length=1)]


@dataclass(frozen=True)
class RecipeFindings:
    """A recipe under examination. Nothing raises: every fault is kept, and the examination goes on."""

    recipe: Recipe
    plugins: Plugins
    faults: list[Fault]
    """The faults, in the order they were found."""

    def in_order(self) -> list[Fault]:
        """The faults of each file by line and column."""
        return sorted(self.recipe.without_echoes(self.faults), key=_place)

    def add(self, path: KeyPath, what: str, expected: str = "", remedy: str = "") -> None:
        """Keep a fault at a place in the recipe."""
        self.faults.append(Fault(self.recipe.where(path), what, expected, remedy))

    def adopt(self, path: KeyPath, error: UserError) -> None:
        """Keep the faults of a part of the recipe that was read elsewhere, with its place in the recipe."""
        place = self.recipe.where(path)
        for fault in error.faults:
            self.faults.append(Fault(f"{place}: {fault.where}", fault.what, fault.expected, fault.remedy))

    def checked(self, kind: type[Settings], settings: Mapping[str, Any], path: KeyPath) -> Settings | None:
        """Settings at a place in the recipe; None where they are at fault."""
        config, faults, _ = check(kind, settings, lambda below: self.recipe.where((*path, *below)))
        self.faults.extend(faults)
        return config

    def cameras(self, raw: Any, path: KeyPath) -> tuple[str, ...] | None:
        """The ``cameras:`` of an effect; None where it has none, or they are at fault."""
        if raw is None:
            return None
        names, faults, _ = check(
            _CAMERAS, raw, lambda b: self.recipe.where((*path, "cameras", *b)), "cameras"
        )
        self.faults.extend(faults)
        return names

    def component(self, use: str, kind: str | None, path: KeyPath) -> type[Any] | None:
        """The class of a component; None where there is no such component of that kind."""
        try:
            return self.plugins.resolve(use, kind, where=self.recipe.where((*path, "use")))
        except UserError as error:
            self.faults.extend(error.faults)
            return None

    def part(self, use: Use, kind: str, path: KeyPath) -> ConfiguredComponent | None:
        """A component with its settings; None where either is at fault."""
        cls = self.component(use.use, kind, path)
        return None if cls is None else self.configured(cls, use.use, use.settings, path)

    def executor(self) -> ConfiguredComponent | None:
        """The executor of candidates; the default where the recipe names none."""
        path: KeyPath = ("executor",)
        use = self.recipe.executor
        try:
            use = use or Use(use=self.plugins.default("executor", where=self.recipe.where(path)))
        except UserError as error:
            self.faults.extend(error.faults)
            return None
        return self.part(use, "executor", path)

    def configured(
        self, cls: type[Any], use: str, settings: Mapping[str, Any], path: KeyPath
    ) -> ConfiguredComponent | None:
        """A component class with its settings; None where they, or what they lead to, are at fault."""
        settings = with_paths_from(lambda name: self.recipe.folder_of((*path, name)), cls.Config, settings)
        config = self.checked(cls.Config, dict(settings), path)
        if config is None:
            return None
        part = ConfiguredComponent(use, cls, config, self.plugins.distribution_of(use))
        if use.partition(".")[0] in ("optimizer", "executor"):  # these are built by the study, for good
            return part
        try:
            return replace(part, built=part.make())  # what it refuses, such as a missing file, shows now
        except UserError as error:
            for fault in error.faults:
                key = next(((name,) for name, value in settings.items() if value == fault.where), ())
                self.adopt((*path, *key), UserError(fault))
            return None


def _place(fault: Fault) -> tuple[str, int, int]:
    """Sort key: faults of a file by line and column."""
    found = re.match(r"(.*?):(\d+):(\d+)", fault.where)
    return (found[1], int(found[2]), int(found[3])) if found else (fault.where, 0, 0)
