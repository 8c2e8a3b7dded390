"""A component class with its checked settings."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from tacos_framework.plugins import guarded
from tacos_framework.settings import Settings


@dataclass(frozen=True)
class Part:
    """A component class with its checked settings, and the distribution it comes from."""

    use: str
    cls: type[Any]
    config: Settings
    distribution: str | None = None

    @property
    def name(self) -> str:
        """The component with its distribution, as messages have it."""
        return guarded.Culprit(self.use, self.distribution).name

    def calling(self, doing: str) -> guarded.calling:
        """The guard around whatever the component is called for."""
        return guarded.calling(self.use, self.distribution, doing)

    def make(self, overrides: Mapping[str, Any] | None = None, **supplied: Any) -> Any:
        """Build the component, with some settings replaced."""
        part = self.with_settings(overrides)
        with self.calling("as it is built"):
            return self.cls(part.config, **supplied)

    def with_settings(self, overrides: Mapping[str, Any] | None) -> Part:
        """The same with some settings replaced, by plain data."""
        if not overrides:
            return self
        merged = {**self.config.model_dump(mode="json", by_alias=True), **overrides}
        return replace(self, config=self.cls.Config.model_validate_json(json.dumps(merged)))
