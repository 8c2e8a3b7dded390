"""The effects a diagnosis considers: all that are installed and can be built."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from tacos_framework import EffectBase, Fault, Plugins, UserError, did_you_mean, optional


@dataclass(frozen=True)
class Candidates:
    """Effects that can be causes. `limitations`: in a sentence each, what is left out and why."""

    effects: Mapping[str, type[Any]]
    distributions: Mapping[str, str] = field(default_factory=dict)
    limitations: tuple[str, ...] = ()

    def without_these(self, names: Collection[str], by: str) -> Candidates:
        """The candidates without some that captures cannot show: `by` are the captures, in a few words."""
        if not names:
            return self
        kept = {name: cls for name, cls in self.effects.items() if name not in names}
        said = f"{by} cannot show {', '.join(sorted(names))}: not considered."
        return Candidates(kept, self.distributions, (*self.limitations, said))

    def excluding(self, names: Collection[str]) -> dict[str, type[Any]]:
        return {name: cls for name, cls in self.effects.items() if name not in names}

    def without(self, name: str, error: BaseException) -> Candidates:
        return Candidates(
            {other: cls for other, cls in self.effects.items() if other != name},
            self.distributions,
            (*self.limitations, left_out(name, self.distributions.get(name), error)),
        )


def candidates(plugins: Plugins, without: tuple[str, ...] = ()) -> Candidates:
    """Every installed effect that can be a cause.

    Raises UserError when an effect of `without` is not installed.
    """
    found = {
        r.component.name: r.distribution
        for r in plugins
        if r.component.kind == "effect" and not r.component.missing_packages()
    }
    if unknown := [name for name in without if name not in found]:
        raise UserError(
            Fault(
                "without",
                f"no effect is called {name}",
                ", ".join(sorted(found)),
                did_you_mean(name.removeprefix("effect."), found),
            )
            for name in unknown
        )
    effects: dict[str, type[Any]] = {}
    limitations = []
    for name in sorted(set(found) - set(without)):
        try:
            cls = plugins.resolve(f"effect.{name}", "effect")
            cls(cls.Config())
        except Exception as error:  # noqa: BLE001 - whatever a stranger's class raises is said
            limitations.append(left_out(name, found[name], error))
        else:
            if _guesses(cls):
                effects[name] = cls
    distributions = {name: found[name] or "" for name in effects}
    return Candidates(effects, {k: v for k, v in distributions.items() if v}, tuple(limitations))


def _guesses(cls: type[Any]) -> bool:
    """True for a class with initial guesses: one without is no flaw of a capture."""
    initial = optional(cls, EffectBase, "initial_guesses")
    return initial is None or len(initial) > 0 or callable(optional(cls, EffectBase, "guesses_from"))


def left_out(name: str, distribution: str | None, error: BaseException) -> str:
    of = f" of {distribution}" if distribution else ""
    why = " ".join(str(error).split()) or "it says nothing more"
    said = why if isinstance(error, UserError) else f"{type(error).__name__}: {why}"
    return f"effect.{name}{of} is not considered, since it fails. {said}"
