"""Discovery of plugins by entry points. Failures are kept and shown, they never stop the host."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import pluggy

from tacos_framework import hookspecs
from tacos_framework.components import CONTRACT_VERSION, Command, Component, ReferencePage
from tacos_framework.environment import EnvironmentFinding
from tacos_framework.errors import Fault, UserError
from tacos_framework.plugins.failures import PluginFailure, in_words, tried
from tacos_framework.plugins.importing import WITHOUT_VARIABLE, imported, say_what_ended_the_last_start
from tacos_framework.plugins.observers import Observer, Observers
from tacos_framework.plugins.registry import Registered, Registry

if TYPE_CHECKING:
    from tacos_framework.contracts import EpisodeStore

GROUP = "tacos"
"""The entry-point group plugins register in."""

Offer = TypeVar("Offer")


@dataclass(frozen=True)
class _Plugin:
    """A module or object with hooks, and where it comes from."""

    hooks: Any
    name: str
    distribution: str | None

    @property
    def source(self) -> str:
        return self.distribution or self.name


class Plugins:
    """The plugins of one host. There is no global instance.

    Examples
    --------
    >>> plugins = Plugins.discover()
    >>> plugins.component("sensor.affine-noise").summary
    'Photon and thermal noise, scaled by gain and pixel area.'
    """

    def __init__(self) -> None:
        self._manager = pluggy.PluginManager(GROUP)
        self._manager.add_hookspecs(hookspecs)
        self._plugins: list[_Plugin] = []
        self._components = Registry()
        self._modules: list[str] = []
        self._command_sources: dict[str, str] = {}
        self._failures: dict[tuple[str, str], PluginFailure] = {}
        self._remarks: dict[tuple[str, str], EnvironmentFinding] = {}

    @classmethod
    def discover(cls) -> Plugins:
        """All plugins installed here, but those that ``TACOS_WITHOUT`` names.

        A broken one ends up in `failures`.
        """
        plugins = cls()
        say_what_ended_the_last_start()
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
            plugins._failures[name, reason] = PluginFailure(
                name, reason, remedy=f"Change {WITHOUT_VARIABLE}."
            )
        return plugins

    def _load(self, entry_point: EntryPoint) -> None:
        distribution = _name_of(entry_point)
        plugin = distribution or entry_point.name
        module, error = imported(entry_point.load, plugin, partial(self._remark, plugin))
        if error is not None:
            self._fail(plugin, f"its import failed: {in_words(error)}", error)
        else:
            self._register(_Plugin(module, entry_point.name, distribution))

    def register(self, plugin: Any, name: str | None = None) -> None:
        """Add a module or object with hooks: the door for embedding and tests.

        Modules that can be imported by name are also registered in worker processes.
        """
        name = name or str(getattr(plugin, "__name__", type(plugin).__name__))
        if hasattr(plugin, "__spec__"):
            self._modules.append(plugin.__name__)
        self._register(_Plugin(plugin, name, None))

    def _register(self, plugin: _Plugin) -> None:
        known = set(self._manager.get_plugins())
        unique = f"{plugin.distribution}:{plugin.name}" if plugin.distribution else plugin.name
        try:
            self._manager.register(plugin.hooks, unique)  # names are chosen by strangers
            self._manager.check_pending()
        except (pluggy.PluginValidationError, ValueError) as error:
            if plugin.hooks not in known and self._manager.is_registered(plugin.hooks):
                self._manager.unregister(plugin.hooks)
            self._fail(plugin.source, f"its hooks do not fit: {error}", error)
            return
        if not self._manager.get_hookcallers(plugin.hooks):
            self._fail(plugin.source, "it implements no hook: mark tacos_components with @hookimpl")
            return
        self._plugins.append(plugin)
        for component in self._offered(plugin, "tacos_components", Component):
            if component.contract == CONTRACT_VERSION:
                self._components.add(Registered(component, plugin.name, plugin.distribution))
            else:
                self._fail(
                    plugin.source,
                    f"{component.use} is written for contract {component.contract}, this is "
                    f"{CONTRACT_VERSION}: install a version of the plugin made for this tacos-framework",
                    uses=(component.use,),
                )

    # what plugins offer by hooks --------------------------------------------------------------------------

    def _hook_of(self, plugin: _Plugin, hook: str) -> Any:
        """Calls a hook of one plugin alone."""
        others = [other.hooks for other in self._plugins if other.hooks is not plugin.hooks]
        return self._manager.subset_hook_caller(hook, remove_plugins=others)

    def _offered(self, plugin: _Plugin, hook: str, kind: type[Offer]) -> list[Offer]:
        """What a plugin offers by a hook; its failures are kept."""
        call = self._hook_of(plugin, hook)
        offered, error = tried(partial(_all, call), f"{hook} of plugin {plugin.source}")
        if error is not None:
            self._fail(plugin.source, f"its {hook} failed: {in_words(error)}", error)
        for offer in offered or ():
            if not isinstance(offer, kind):
                self._fail(
                    plugin.source,
                    f"it offers a {type(offer).__name__} where a {kind.__name__} is expected",
                )
        return [offer for offer in offered or () if isinstance(offer, kind)]

    def findings(self) -> list[EnvironmentFinding]:
        """What plugins found out about this machine; a look that fails is a finding too."""
        found = []
        for plugin in self._plugins:
            call = self._hook_of(plugin, "tacos_doctor")
            findings, error = tried(partial(_all, call), f"tacos_doctor of plugin {plugin.source}")
            for finding in findings or ():
                if isinstance(finding, EnvironmentFinding):
                    found.append(finding)
                else:
                    error = TypeError(f"it gives a {type(finding).__name__} where a Finding is expected")
            if error is not None:
                said = f"its tacos_doctor failed: {in_words(error)}"
                found.append(
                    EnvironmentFinding(f"plugin {plugin.source}", said, ok=False, remedy="Update it.")
                )
        return found

    def commands(self, taken: tuple[str, ...] = ()) -> list[Command]:
        """The commands of ``tacos`` of plugins, by name, without those whose name is not theirs alone.

        Parameters
        ----------
        taken
            Names the host has given already.
        """
        offers: dict[str, list[tuple[_Plugin, Command]]] = {}
        for plugin in self._plugins:
            for command in self._offered(plugin, "tacos_commands", Command):
                offers.setdefault(command.name, []).append((plugin, command))
        for name, offered in offers.items():
            sources = [plugin.source for plugin, _ in offered]
            if name in taken:
                sources.insert(0, "tacos itself")
            if len(sources) > 1:
                by = " and by ".join(sources)
                self._fail(sources[-1], f"the command {name!r} is offered by {by}, so it is left out")
            self._command_sources[name] = sources[-1]
        return [
            offered[0][1]
            for name, offered in sorted(offers.items())
            if len(offered) == 1 and name not in taken
        ]

    def reject(self, command: Command, error: BaseException) -> None:
        """Keep that a command cannot be used, which showed only when it was."""
        source = self._command_sources[command.name]
        self._fail(source, f"its command {command.name!r} failed: {in_words(error)}", error)

    def reference_pages(self) -> list[ReferencePage]:
        """The pages of the reference that plugins offer."""
        return [
            page
            for plugin in self._plugins
            for page in self._offered(plugin, "tacos_reference_pages", ReferencePage)
        ]

    def episode_store(self) -> EpisodeStore | None:
        """What keeps the episodes that scenes make; None where no plugin offers to."""
        from tacos_framework.contracts import EpisodeStore  # numpy is not for those who only list plugins

        kind: Any = EpisodeStore  # a Protocol
        stores = (s for p in self._plugins for s in self._offered(p, "tacos_episode_stores", kind))
        return next(stores, None)

    def write_reports(self, folder: Path) -> tuple[list[Path], list[PluginFailure]]:
        """Have plugins report on a results folder: the files they wrote, and what failed."""
        written: list[Path] = []
        failures = []
        for plugin in self._plugins:
            call = self._hook_of(plugin, "tacos_report")
            files, error = tried(partial(call, folder=folder), f"tacos_report of plugin {plugin.source}")
            written += files or ()
            if error is not None:
                said = f"its tacos_report failed: {in_words(error)}"
                failures.append(PluginFailure(plugin.source, said, error))
        return written, failures

    def observers(self) -> Observers:
        """Those who listen to a study; for one study, as those that fail are told no more."""
        observers = []
        for plugin in self._plugins:
            implemented = self._manager.get_hookcallers(plugin.hooks) or []
            hooks = {caller.name: self._hook_of(plugin, caller.name) for caller in implemented}
            observers.append(Observer(plugin.name, plugin.distribution, hooks))
        return Observers(observers)

    # failures ---------------------------------------------------------------------------------------------

    @property
    def failures(self) -> list[PluginFailure]:
        """What cannot be used, as far as it is known without importing components."""
        return [*self._failures.values(), *self._components.clashes()]

    def _fail(
        self, plugin: str, reason: str, error: BaseException | None = None, uses: tuple[str, ...] = ()
    ) -> None:
        self._failures[plugin, reason] = PluginFailure(plugin, reason, error, uses)

    def _remark(self, plugin: str, what: str) -> None:
        remark = EnvironmentFinding(f"plugin {plugin}", what, ok=False, remedy="Update it.")
        self._remarks[plugin, what] = remark

    @property
    def remarks(self) -> list[EnvironmentFinding]:
        """What imports so far have changed in this process."""
        return list(self._remarks.values())

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

        Raises
        ------
        UserError
            When no plugin that is installed, or more than one component, offers to.
        """
        uses = [each.component.use for each in self if purpose in each.component.default_for]
        if len(uses) != 1:
            offered = f"{' and '.join(uses)} all offer to" if uses else "no component that is installed does"
            what = f"nothing is named here, and {offered} stand for it"
            raise UserError(Fault(where, what, "a component executor.NAME", "Name one."))
        return uses[0]

    def component(self, use: str, kind: str | None = None, *, where: str = "plugins") -> Component:
        """The component recipes call `use`.

        Raises
        ------
        UserError
            When nothing of that name (and kind) is installed, with the nearest name, what is broken, or
            what to install; when two plugins offer it.
        """
        found = self._components.get(use)
        if found is not None and (kind is None or found.component.kind == kind):
            return found.component
        raise UserError(self._components.absent(use, kind, where, self.failures))

    def resolve(self, use: str, kind: str | None = None, *, where: str = "plugins") -> type[Any]:
        """The class of a component, checked against its contract.

        Raises
        ------
        UserError
            When it is not installed, an optional package is missing, or the class does not fit its kind.
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
        loaded, error = imported(component.load, source, partial(self._remark, source))
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


def _all(hook: Callable[[], Iterable[Iterable[Any]]]) -> list[Any]:
    """What a hook returns, in one list."""
    return [each for returned in hook() for each in returned]


def _name_of(entry_point: EntryPoint) -> str | None:
    """The distribution an entry point belongs to; None where its metadata does not say."""
    try:
        return entry_point.dist.name if entry_point.dist else None
    except KeyError:  # a folder of metadata without METADATA, as an interrupted uninstall leaves it
        return None
