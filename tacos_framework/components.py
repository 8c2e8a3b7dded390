"""Components, commands and reference pages of a plugin, declared before anything is imported."""

from __future__ import annotations

import importlib
import re
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

CONTRACT_VERSION = 1
"""Grows when a plugin written for the older number would no longer work."""

KINDS = (
    "scene",
    "rig",
    "renderer",
    "effect",
    "sensor",
    "transform",
    "control",
    "task",
    "optimizer",
    "executor",
    "procedure",
)
"""The kinds of component; `tacos_framework.contracts` has one Protocol for each."""

_NAME = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
_TARGET = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*")


@dataclass(frozen=True)
class Component:
    """A component a plugin offers, described without importing its code.

    >>> Component("sensor", "affine-noise", "my_plugin.noise:AffineNoise", summary="Noise.").use
    'sensor.affine-noise'
    """

    kind: str
    """One of :data:`KINDS`."""
    name: str
    """Lower-case words joined by hyphens; recipes write ``kind.name``."""
    target: str
    """``"package.module:Class"``, imported on first use."""
    summary: str
    """One sentence for ``tacos plugins``."""
    requires: tuple[str, ...] = ()
    """Import names of optional packages the class needs, each as ``"module"`` or
    ``"module=package-to-install"``.
    """
    default_for: tuple[str, ...] = ()
    """Things it stands for where they are not named: ``"executor"`` where a recipe names none, ``"workers"``
    for ``--workers N``.
    """
    contract: int = CONTRACT_VERSION

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"component kind {self.kind!r} is not one of {', '.join(KINDS)}")
        if not _NAME.fullmatch(self.name):
            raise ValueError(f"component name {self.name!r} is not lower-case words joined by hyphens")
        if not _TARGET.fullmatch(self.target):
            raise ValueError(f"component target {self.target!r} is not of the form 'package.module:Class'")
        if not self.summary:
            raise ValueError(f"component {self.use} has no summary")

    @property
    def use(self) -> str:
        return f"{self.kind}.{self.name}"

    def missing_packages(self) -> list[str]:
        """The packages to install before this component can be loaded; empty when all are there."""
        from importlib.util import find_spec

        wanted = (requirement.partition("=") for requirement in self.requires)
        missing = (package or module for module, _, package in wanted if find_spec(module) is None)
        return list(dict.fromkeys(missing))

    def load(self) -> type[Any]:
        """Import and return the class. Errors of the import are the plugin's and pass unchanged."""
        module, _, name = self.target.partition(":")
        return getattr(importlib.import_module(module), name)


@dataclass(frozen=True)
class Command:
    """A command of ``tacos`` that a plugin offers."""

    name: str
    """The word after ``tacos``."""
    help: str
    """One sentence for ``tacos --help``."""
    add_arguments: Callable[[ArgumentParser], None]
    """Adds its arguments, and further commands, to its parser."""
    run: Callable[[Namespace], int]
    """Does it; returns the exit status. A `UserError` it raises is printed, with status 2."""


@dataclass(frozen=True)
class ReferencePage:
    """A page of the reference that follows from code: its file name, and what writes its Markdown."""

    name: str
    write: Callable[[], str]
