"""Discovery of plugins by entry points. Failures are kept and shown, they never stop the host."""

from __future__ import annotations

import os
from collections.abc import Iterator
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from tacos_framework.components import CONTRACT_VERSION, Component
from tacos_framework.errors import Fault, UserError
from tacos_framework.plugins.failures import WITHOUT_VARIABLE, PluginFailure, PluginFailures, in_words, tried
from tacos_framework.plugins.offers import GROUP, HookedPlugin, Offers
from tacos_framework.plugins.registry import Registered, Registry


class Plugins:
    """The plugins of one host. There is no global instance.

    >>> plugins = Plugins.discover()
    >>> plugins.component("sensor.affine-noise").summary
    'Photon and thermal noise, scaled by gain and pixel area.'
    """

    def __init__(self) -> None:
        self._failures = PluginFailures()
        self.offers = Offers(self._failures)
        self._components = Registry()
        self._modules: list[str] = []

    @classmethod
    def discover(cls) -> Plugins:
        """All plugins installed here, but those that ``TACOS_WITHOUT`` names.

        A broken one ends up in `failures`.
        """
        plugins = cls()
        without = [name.strip() for name in os.environ.get(WITHOUT_VARIABLE, "").split(",") if name.strip()]
        spared = set()
        for entry_point in sorted(entry_points(group=GROUP), key=lambda found: (found.name, found.value)):
            if named := {_name_of(entry_point), entry_point.name}.intersection(without):
                spared |= named
            else:
                plugins._load(entry_point)
        for name in without:
            reason = f"{WITHOUT_VARIABLE} names it, " + (
                "so it is left out" if name in spared else "but it is not there"
            )
            plugins._failures.add(name, reason, remedy=f"Change {WITHOUT_VARIABLE}.")
        return plugins

    def _load(self, entry_point: EntryPoint) -> None:
        distribution = _name_of(entry_point)
        plugin = distribution or entry_point.name
        module, error = tried(entry_point.load, f"the import of plugin {plugin}")
        if error is not None:
            self._failures.add(plugin, f"its import failed: {in_words(error)}", error)
        else:
            self._register(HookedPlugin(module, entry_point.name, distribution))

    def register(self, plugin: Any, name: str | None = None) -> None:
        """Add a module or object with hooks: the door for embedding and tests.

        Modules that can be imported by name are also registered in worker processes.
        """
        name = name or str(getattr(plugin, "__name__", type(plugin).__name__))
        if hasattr(plugin, "__spec__"):
            self._modules.append(plugin.__name__)
        self._register(HookedPlugin(plugin, name, None))

    def _register(self, plugin: HookedPlugin) -> None:
        if not self.offers.register(plugin):
            return
        for component in self.offers.of(plugin, "tacos_components", Component):
            if component.contract == CONTRACT_VERSION:
                self._components.add(Registered(component, plugin.name, plugin.distribution))
            else:
                self._failures.add(
                    plugin.source,
                    f"{component.use} is written for contract {component.contract}, this is "
                    f"{CONTRACT_VERSION}: install a version of the plugin made for this tacos-framework",
                    uses=(component.use,),
                )

    # failures ---------------------------------------------------------------------------------------------

    @property
    def failures(self) -> list[PluginFailure]:
        """Components that cannot be used, as far as it is known without importing them."""
        return [*self._failures, *self._components.clashes()]

    def unusable(self) -> list[PluginFailure]:
        """Components that cannot be imported or do not fit their kind. Imports every one of them.

        Those that only lack an optional package are left out: nothing is wrong with them.
        """
        found = []
        for registered in self:
            component = registered.component
            if component.missing_packages():
                continue
            try:
                self.resolve(component.use)
            except UserError as error:
                reason, cause = "; ".join(fault.what for fault in error.faults), None
            except Exception as error:  # noqa: BLE001 - kept and shown, as at discovery
                reason, cause = f"{component.use} cannot be imported: {in_words(error)}", error
            else:
                continue
            found.append(PluginFailure(registered.source, reason, cause, (component.use,)))
        return found

    # components -------------------------------------------------------------------------------------------

    def __iter__(self) -> Iterator[Registered]:
        return iter(self._components)

    @property
    def modules(self) -> tuple[str, ...]:
        """Import names of modules registered by hand, for worker processes to register too."""
        return tuple(self._modules)

    def distribution_of(self, use: str) -> str | None:
        """The distribution a component comes from; None where it was registered by hand or is not there."""
        found = self._components.get(use)
        return found.distribution if found else None

    def default(self, purpose: str, *, where: str) -> str:
        """The component that stands for what is not named; see `Component.default_for`.

        Raises `UserError` when no plugin that is installed, or more than one component, offers to.
        """
        uses = [each.component.use for each in self if purpose in each.component.default_for]
        if len(uses) != 1:
            offered = f"{' and '.join(uses)} all offer to" if uses else "no component that is installed does"
            what = f"nothing is named here, and {offered} stand for it"
            raise UserError(Fault(where, what, "a component executor.NAME", "Name one."))
        return uses[0]

    def component(self, use: str, kind: str | None = None, *, where: str = "plugins") -> Component:
        """The component recipes call `use`.

        Raises `UserError` when nothing of that name (and kind) is installed, with the nearest name, what is
        broken, or what to install; when two plugins offer it.
        """
        found = self._components.get(use)
        if found is not None and (kind is None or found.component.kind == kind):
            return found.component
        raise UserError(self._components.absent(use, kind, where, self.failures))

    def resolve(self, use: str, kind: str | None = None, *, where: str = "plugins") -> type[Any]:
        """The class of a component, checked against its contract.

        Raises `UserError` when it is not installed, an optional package is missing, or the class does not fit
        its kind.
        """
        component = self.component(use, kind, where=where)
        if missing := component.missing_packages():
            raise UserError(
                Fault(
                    where,
                    f"{use} needs packages that are not installed: {', '.join(missing)}",
                    remedy=f"pip install {' '.join(missing)}",
                )
            )
        source = self.distribution_of(use) or component.target
        loaded, error = tried(component.load, f"the import of plugin {source}")
        if isinstance(error, Exception):
            error.add_note(f"while importing {component.target} for {use} ({where})")
            raise error
        if error is not None:  # would end the host without a word
            said = f"{component.target} ended the program while {use} was imported: {in_words(error)}"
            raise ImportError(said) from error
        cls: type[Any] = loaded  # type: ignore[assignment]  # there is a class where there is no error
        from tacos_framework.plugins.contract_check import contract_faults

        if faults := contract_faults(component, cls):
            raise UserError(
                [Fault(where, f"{use}: {fault}", remedy="Correct the plugin.") for fault in faults]
            )
        return cls


def _name_of(entry_point: EntryPoint) -> str | None:
    """The distribution an entry point belongs to; None where its metadata does not say."""
    try:
        return entry_point.dist.name if entry_point.dist else None
    except KeyError:  # a folder of metadata without METADATA, as an interrupted uninstall leaves it
        return None
