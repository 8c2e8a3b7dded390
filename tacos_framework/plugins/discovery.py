"""Discovery of plugins by entry points. Failures are kept and shown, they never stop the host."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from typing import Any

import pluggy

from tacos_framework import hookspecs
from tacos_framework.components import CONTRACT_VERSION, KINDS, Command, Component
from tacos_framework.errors import Fault, UserError, did_you_mean

GROUP = "tacos"
"""The entry-point group plugins register in."""


@dataclass(frozen=True)
class PluginFailure:
    """A plugin, or one component of it, that cannot be used.

    Parameters
    ----------
    plugin
        Name of the entry point or module.
    reason
        What went wrong, in a sentence.
    error
        The exception it raised, unchanged; None when the framework refused it.
    uses
        The components that are lost by it, as far as they are known.
    """

    plugin: str
    reason: str
    error: BaseException | None = None
    uses: tuple[str, ...] = ()


@dataclass(frozen=True)
class Registered:
    """A component and the plugin that offers it."""

    component: Component
    plugin: str
    distribution: str | None = None


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
        self._components: dict[str, Registered] = {}
        self._modules: list[str] = []
        self.failures: list[PluginFailure] = []

    @classmethod
    def discover(cls) -> Plugins:
        """All plugins installed here. A broken one ends up in `failures`."""
        plugins = cls()
        for entry_point in sorted(entry_points(group=GROUP), key=lambda found: (found.name, found.value)):
            plugins._load(entry_point)
        return plugins

    def _load(self, entry_point: EntryPoint) -> None:
        distribution = _name_of(entry_point)
        try:
            module = entry_point.load()
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # noqa: BLE001 - whatever a stranger's import raises is kept and shown
            reason = f"its import failed: {type(error).__name__}: {error}"
            self.failures.append(PluginFailure(distribution or entry_point.name, reason, error))
            return
        self._register(module, entry_point.name, distribution)

    def register(self, plugin: Any, name: str | None = None) -> None:
        """Add a module or object with hooks: the door for embedding and tests.

        Modules that can be imported by name are also registered in worker processes.
        """
        name = name or str(getattr(plugin, "__name__", type(plugin).__name__))
        if hasattr(plugin, "__spec__"):
            self._modules.append(plugin.__name__)
        self._register(plugin, name, None)

    def _register(self, plugin: Any, name: str, distribution: str | None) -> None:
        known = set(self._manager.get_plugins())
        unique = f"{distribution}:{name}" if distribution else name  # names are chosen by strangers
        try:
            self._manager.register(plugin, unique)
            self._manager.check_pending()
        except (pluggy.PluginValidationError, ValueError) as error:
            if plugin not in known and self._manager.is_registered(plugin):
                self._manager.unregister(plugin)
            reason = f"its hooks do not fit: {error}"
            self.failures.append(PluginFailure(distribution or name, reason, error))
            return
        if not self._manager.get_hookcallers(plugin):
            reason = "it implements no hook: mark tacos_components with @hookimpl"
            self.failures.append(PluginFailure(distribution or name, reason))
            return
        others = [other for other in self._manager.get_plugins() if other is not plugin]
        hooks = self._manager.subset_hook_caller("tacos_components", remove_plugins=others)
        try:
            offered = [component for components in hooks() for component in components]
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # noqa: BLE001 - kept and shown, as above
            reason = f"its tacos_components failed: {type(error).__name__}: {error}"
            self.failures.append(PluginFailure(distribution or name, reason, error))
            return
        for component in offered:
            self._add(component, name, distribution)

    def _add(self, component: Any, plugin: str, distribution: str | None) -> None:
        def refuse(reason: str, uses: tuple[str, ...] = ()) -> None:
            self.failures.append(PluginFailure(distribution or plugin, reason, uses=uses))

        if not isinstance(component, Component):
            refuse(f"it offers a {type(component).__name__} where a Component is expected")
        elif component.contract != CONTRACT_VERSION:
            refuse(
                f"{component.use} is written for contract {component.contract}, this is {CONTRACT_VERSION}: "
                "install a version of the plugin made for this tacos-framework",
                (component.use,),
            )
        elif (other := self._components.get(component.use)) is not None:
            refuse(f"{component.use} is already offered by {other.distribution or other.plugin}")
        else:
            self._components[component.use] = Registered(component, plugin, distribution)

    def unusable(self) -> list[PluginFailure]:
        """Components that cannot be imported or do not fit their kind. Imports every one of them.

        Those that only lack an optional package are left out: nothing is wrong with them.
        """
        found = []
        for registered in self:
            component, plugin = registered.component, registered.distribution or registered.plugin
            if component.missing_packages():
                continue
            try:
                self.resolve(component.use)
            except UserError as error:
                reason, cause = "; ".join(fault.what for fault in error.faults), None
            except Exception as error:  # noqa: BLE001 - kept and shown, as at discovery
                reason, cause = f"{component.use} cannot be imported: {type(error).__name__}: {error}", error
            else:
                continue
            found.append(PluginFailure(plugin, reason, cause, (component.use,)))
        return found

    def __iter__(self) -> Iterator[Registered]:
        order = {kind: i for i, kind in enumerate(KINDS)}
        return iter(
            sorted(self._components.values(), key=lambda r: (order[r.component.kind], r.component.name))
        )

    @property
    def hook(self) -> Any:
        """The observer hooks of all plugins (pluggy's hook relay)."""
        return self._manager.hook

    def commands(self) -> list[Command]:
        """The commands of ``tacos`` that plugins offer, by name; of two with one name the first stays."""
        offered = (command for of_plugin in self.hook.tacos_commands() for command in of_plugin)
        commands: dict[str, Command] = {}
        for command in offered:
            commands.setdefault(command.name, command)
        return [commands[name] for name in sorted(commands)]

    @property
    def modules(self) -> tuple[str, ...]:
        """Import names of modules registered by hand, for worker processes to register too."""
        return tuple(self._modules)

    def distribution_of(self, use: str) -> str | None:
        """The distribution a component comes from; None where it was registered by hand or is not there."""
        found = self._components.get(use)
        return found.distribution if found else None

    def component(self, use: str, kind: str | None = None, *, where: str = "plugins") -> Component:
        """The component recipes call `use`.

        Raises
        ------
        UserError
            When nothing of that name (and kind) is installed, with the nearest name, what is broken, or
            what to install.
        """
        found = self._components.get(use)
        if found is not None and (kind is None or found.component.kind == kind):
            return found.component
        raise UserError(self._absent(use, kind, found, where))

    def _absent(self, use: str, kind: str | None, found: Registered | None, where: str) -> Fault:
        if found is not None:
            return Fault(
                where, f"{use} is a {found.component.kind}, not a {kind}", f"a component {kind}.NAME", ""
            )
        lost = [failure for failure in self.failures if use in failure.uses or not failure.uses]
        remedy = did_you_mean(
            use, (u for u, r in self._components.items() if kind in (None, r.component.kind))
        )
        if lost:
            broken = "; ".join(f"plugin {failure.plugin} is unusable: {failure.reason}" for failure in lost)
            remedy = f"{remedy} Note: {broken}."
        else:
            remedy = f"{remedy} If a plugin package offers it, install that package beside tacos-framework."
        return Fault(
            where, f"no component {use!r} is installed", f"a component {kind or 'KIND'}.NAME", remedy
        )

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
        try:
            cls = component.load()
        except SystemExit as error:  # would end the host without a word
            raise ImportError(f"{component.target} ended the program while {use} was imported") from error
        except Exception as error:
            error.add_note(f"while importing {component.target} for {use} ({where})")
            raise
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


def contract_faults(component: Component, cls: type[Any]) -> list[str]:
    """What a class lacks to be a component of its kind, in sentences; empty when it fits."""
    from tacos_framework.contracts import PROTOCOLS, VERBS
    from tacos_framework.settings import Settings

    faults = [
        f"{cls.__name__} has no method {verb}"
        for verb in VERBS[component.kind]
        if not callable(getattr(cls, verb, None))
    ]
    if not (isinstance(config := getattr(cls, "Config", None), type) and issubclass(config, Settings)):
        faults.append(f"{cls.__name__}.Config is not a tacos_framework.settings.Settings class")
    protocol = PROTOCOLS[component.kind]
    properties = {name for name, member in vars(protocol).items() if isinstance(member, property)}
    attributes = (set(protocol.__annotations__) | properties) - {"Config"}
    faults += [
        f"{cls.__name__} has no class attribute {name}"
        for name in sorted(attributes)
        if not hasattr(cls, name)
    ]
    return faults
