"""The components of all plugins by name; a name that two of them offer belongs to neither."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from tacos_framework.components import KINDS, Component
from tacos_framework.errors import Fault, did_you_mean
from tacos_framework.packaged_resources import package_offering
from tacos_framework.plugins.failures import PluginFailure


@dataclass(frozen=True)
class Registered:
    """A component and the plugin that offers it."""

    component: Component
    plugin: str
    distribution: str | None = None

    @property
    def source(self) -> str:
        """The distribution, or the plugin that was registered by hand."""
        return self.distribution or self.plugin


class Registry:
    """Components by name."""

    def __init__(self) -> None:
        self._offers: dict[str, list[Registered]] = {}

    def add(self, registered: Registered) -> None:
        """Take in a component; where its name is taken already, the name is lost to both."""
        self._offers.setdefault(registered.component.use, []).append(registered)

    def get(self, use: str) -> Registered | None:
        """The component of a name; None where there is none, or more than one."""
        offers = self._offers.get(use, [])
        return offers[0] if len(offers) == 1 else None

    def __iter__(self) -> Iterator[Registered]:
        order = {kind: i for i, kind in enumerate(KINDS)}
        found = (offers[0] for offers in self._offers.values() if len(offers) == 1)
        return iter(sorted(found, key=lambda r: (order[r.component.kind], r.component.name)))

    def clashes(self) -> list[PluginFailure]:
        """The names that more than one plugin offers."""
        return [
            PluginFailure(
                _listed(_sources(offers)),
                f"{use} is offered by {_listed(_sources(offers), 'and by')}, so the name can mean neither",
                uses=(use,),
                remedy=_keep_one(offers),
            )
            for use, offers in sorted(self._offers.items())
            if len(offers) > 1
        ]

    def absent(self, use: str, kind: str | None, where: str, failures: Sequence[PluginFailure]) -> Fault:
        """Advice for those who ask for a component that is not there.

        `use`, `kind`: the name, and the kind of component that is needed. `failures`: the plugins that are
        broken, one of which may be what is missed.
        """
        offers = self._offers.get(use, [])
        if len(offers) > 1:
            return Fault(
                where,
                f"{use} is offered by {_listed(_sources(offers), 'and by')}",
                "one plugin that offers it",
                _keep_one(offers),
            )
        if offers:
            given = offers[0].component.kind
            return Fault(where, f"{use} is a {given}, not a {kind}", f"a component {kind}.NAME", "")
        known = (name for name, of in self._offers.items() if kind in (None, of[0].component.kind))
        remedy = did_you_mean(use, known)
        if lost := [failure for failure in failures if use in failure.uses or not failure.uses]:
            broken = "; ".join(f"plugin {failure.plugin} is unusable: {failure.reason}" for failure in lost)
            remedy = f"{remedy} Note: {broken}."
        elif (package := package_offering(use)) is not None:
            remedy = f"pip install '{package}'"
        else:
            remedy = f"{remedy} If a plugin package offers it, install that package beside tacos-framework."
        return Fault(
            where, f"no component {use!r} is installed", f"a component {kind or 'KIND'}.NAME", remedy
        )


def _sources(offers: Sequence[Registered]) -> list[str]:
    return [offer.source for offer in offers]


def _listed(names: Sequence[str], joined_by: str = "and") -> str:
    return f" {joined_by} ".join(names)


def _keep_one(offers: Sequence[Registered]) -> str:
    if len(set(_sources(offers))) == 1:
        return f"Have {offers[0].source} list it once."
    if all(offer.distribution for offer in offers):
        return f"Uninstall {_listed(_sources(offers), 'or')}."
    return f"Use one of {_listed(_sources(offers))} alone, or have one of them choose another name."
