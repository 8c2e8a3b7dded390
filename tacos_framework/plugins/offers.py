"""Offers of plugins by hooks beside components: commands, reports, findings, listeners."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import pluggy

from tacos_framework import hookspecs
from tacos_framework.components import Command, ReferencePage
from tacos_framework.environment import EnvironmentFinding, Gpu
from tacos_framework.plugins.failures import PluginFailure, PluginFailures, in_words, tried
from tacos_framework.plugins.observers import Observer, Observers

if TYPE_CHECKING:
    from tacos_framework.contracts import EpisodeStore

GROUP = "tacos"
"""The entry-point group plugins register in, and the project name of their hooks."""

Offer = TypeVar("Offer")


@dataclass(frozen=True)
class HookedPlugin:
    """A module or object with hooks, and where it comes from."""

    hooks: Any
    name: str
    distribution: str | None

    @property
    def source(self) -> str:
        return self.distribution or self.name


class Offers:
    """The hooks of the plugins of one host, each called for one plugin alone, so that a failure has a name.

    - `failures`: where it is kept what cannot be used.
    """

    def __init__(self, failures: PluginFailures) -> None:
        self._manager = pluggy.PluginManager(GROUP)
        self._manager.add_hookspecs(hookspecs)
        self._plugins: list[HookedPlugin] = []
        self._command_sources: dict[str, str] = {}
        self._failures = failures

    def register(self, plugin: HookedPlugin) -> bool:
        """Take a plugin's hooks; false, with the reason kept, where they do not fit."""
        known = set(self._manager.get_plugins())
        unique = f"{plugin.distribution}:{plugin.name}" if plugin.distribution else plugin.name
        try:
            self._manager.register(plugin.hooks, unique)  # names are chosen by strangers
            self._manager.check_pending()
        except (pluggy.PluginValidationError, ValueError) as error:
            if plugin.hooks not in known and self._manager.is_registered(plugin.hooks):
                self._manager.unregister(plugin.hooks)
            self._failures.add(plugin.source, f"its hooks do not fit: {error}", error)
            return False
        if not self._manager.get_hookcallers(plugin.hooks):
            reason = "it implements no hook: mark tacos_components with @hookimpl"
            self._failures.add(plugin.source, reason)
            return False
        self._plugins.append(plugin)
        return True

    def _hook_of(self, plugin: HookedPlugin, hook: str) -> Any:
        """Calls a hook of one plugin alone."""
        others = [other.hooks for other in self._plugins if other.hooks is not plugin.hooks]
        return self._manager.subset_hook_caller(hook, remove_plugins=others)

    def of(self, plugin: HookedPlugin, hook: str, kind: type[Offer]) -> list[Offer]:
        """Offers of a plugin by a hook; its failures are kept."""
        call = self._hook_of(plugin, hook)
        offered, error = tried(partial(_all, call), f"{hook} of plugin {plugin.source}")
        if error is not None:
            self._failures.add(plugin.source, f"its {hook} failed: {in_words(error)}", error)
        for offer in offered or ():
            if not isinstance(offer, kind):
                self._failures.add(
                    plugin.source, f"it offers a {type(offer).__name__} where a {kind.__name__} is expected"
                )
        return [offer for offer in offered or () if isinstance(offer, kind)]

    def findings(self) -> list[EnvironmentFinding]:
        """Findings of plugins about this machine; a look that fails is a finding too."""
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

    def gpus(self) -> list[Gpu] | None:
        """The GPUs that plugins know of, each once; None where no plugin looks for any."""
        looking = [plugin for plugin in self._plugins if self._implements(plugin, "tacos_gpus")]
        found = [gpu for plugin in looking for gpu in self.of(plugin, "tacos_gpus", Gpu)]
        by_number = {gpu.number: gpu for gpu in reversed(found)}
        return [by_number[number] for number in sorted(by_number)] if looking else None

    def _implements(self, plugin: HookedPlugin, hook: str) -> bool:
        callers = self._manager.get_hookcallers(plugin.hooks) or []
        return hook in (caller.name for caller in callers)

    def commands(self, taken: tuple[str, ...] = ()) -> list[Command]:
        """The commands of ``tacos`` of plugins, by name, without those whose name is not theirs alone.

        `taken`: names the host has given already.
        """
        offers: dict[str, list[tuple[HookedPlugin, Command]]] = {}
        for plugin in self._plugins:
            for command in self.of(plugin, "tacos_commands", Command):
                offers.setdefault(command.name, []).append((plugin, command))
        for name, offered in offers.items():
            sources = [plugin.source for plugin, _ in offered]
            if name in taken:
                sources.insert(0, "tacos itself")
            if len(sources) > 1:
                by = " and by ".join(sources)
                self._failures.add(sources[-1], f"the command {name!r} is offered by {by}, so it is left out")
            self._command_sources[name] = sources[-1]
        return [
            offered[0][1]
            for name, offered in sorted(offers.items())
            if len(offered) == 1 and name not in taken
        ]

    def reject(self, command: Command, error: BaseException) -> None:
        """Keep that a command cannot be used, which showed only when it was."""
        source = self._command_sources[command.name]
        self._failures.add(source, f"its command {command.name!r} failed: {in_words(error)}", error)

    def reference_pages(self) -> list[ReferencePage]:
        """The pages of the reference that plugins offer."""
        return [
            page
            for plugin in self._plugins
            for page in self.of(plugin, "tacos_reference_pages", ReferencePage)
        ]

    def episode_store(self) -> EpisodeStore | None:
        """The store of episodes that scenes make; None if no plugin offers one."""
        from tacos_framework.contracts import EpisodeStore  # numpy is not for those who only list plugins

        kind: Any = EpisodeStore  # a Protocol
        stores = (s for p in self._plugins for s in self.of(p, "tacos_episode_stores", kind))
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


def _all(hook: Callable[[], Iterable[Iterable[Any]]]) -> list[Any]:
    """Answers of a hook, in one list."""
    return [each for returned in hook() for each in returned]
