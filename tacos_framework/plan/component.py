"""A component class with its checked settings."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

from tacos_framework.plugins import guarded
from tacos_framework.settings import Settings


@dataclass(frozen=True)
class ConfiguredComponent:
    """A component class with its checked settings."""

    use: str
    """The component, ``kind.name``."""
    cls: type[Any]
    config: Settings
    distribution: str | None = None
    """The distribution it comes from; None where it was registered by hand."""
    built: Any = field(default=None, compare=False, repr=False)
    """The component as it was built when the recipe was checked; None where it was not."""

    @property
    def origin(self) -> str:
        """The component with its distribution, as messages have it."""
        return guarded.Culprit(self.use, self.distribution).name

    @property
    def instance(self) -> Any:
        """The component with exactly these settings: that of the check, where there is one."""
        return self.make() if self.built is None else self.built

    def calling(self, doing: str) -> guarded.calling:
        """The guard around whatever the component is called for."""
        return guarded.calling(self.use, self.distribution, doing)

    def make(self, overrides: Mapping[str, Any] | None = None, **supplied: Any) -> Any:
        """Build the component anew, with some settings replaced."""
        part = self.with_settings(overrides)
        with self.calling("as it is built"):
            return self.cls(part.config, **supplied)

    def with_settings(self, overrides: Mapping[str, Any] | None) -> Self:
        """The same with some settings replaced, by plain data."""
        if not overrides:
            return self
        merged = {**self.config.model_dump(mode="json", by_alias=True), **overrides}
        config = self.cls.Config.model_validate_json(json.dumps(merged))
        return replace(self, config=config, built=None)


@dataclass(frozen=True)
class EffectPart(ConfiguredComponent):
    """An effect, what design variables call it, and which cameras have it."""

    name: str = ""
    """Its name among the effects of the recipe, or that of its node."""
    cameras: tuple[str, ...] | None = None
    """Names of the cameras it acts on; None for all of the rig."""
