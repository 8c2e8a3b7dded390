"""Machine and software that a study ran on."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, requires, version
from re import match
from typing import Any

DEVICE_VARIABLE = "TACOS_DEVICE"
"""Environment variable that says where workers, too, compute and render: ``cpu``, or a GPU's number."""


@dataclass(frozen=True)
class EnvironmentFinding:
    """One thing ``tacos doctor`` reports."""

    name: str
    """Subject of the finding, e.g. ``OpenGL``."""
    value: str
    ok: bool = True
    remedy: str = ""


@dataclass(frozen=True)
class Gpu:
    """A GPU of this machine."""

    number: int
    """Its name for ``--device``."""
    name: str


def usable_cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def package_versions(further: Iterable[str] = ()) -> dict[str, str]:
    """Versions of tacos-framework, of the packages it needs, and of further ones."""
    names = ["tacos-framework", *further]
    for requirement in requires("tacos-framework") or []:
        found = match(r"[A-Za-z0-9._-]+", requirement)
        if found and "extra ==" not in requirement:
            names.append(found.group())
    versions = {}
    for name in names:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            versions[name] = "not installed"
    return versions


def describe_environment(workers: int, findings: Iterable[EnvironmentFinding]) -> dict[str, Any]:
    """Facts to repeat a run with: Python, platform, cores, packages, and findings of plugins."""
    return {
        "python": platform.python_version(),
        "platform": platform.platform(),
        "cores": usable_cores(),
        "workers": workers,
        "packages": package_versions(),
        "findings": {finding.name: finding.value for finding in findings},
    }
