"""A component class with its checked settings."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from tacos_framework.settings import Settings


@dataclass(frozen=True)
class Part:
    """A component class with its checked settings."""

    use: str
    cls: type[Any]
    config: Settings

    def make(self, overrides: Mapping[str, Any] | None = None, **supplied: Any) -> Any:
        """Build the component, with some settings replaced."""
        return self.cls(self.with_settings(overrides).config, **supplied)

    def with_settings(self, overrides: Mapping[str, Any] | None) -> Part:
        """The same with some settings replaced, by plain data."""
        if not overrides:
            return self
        merged = {**self.config.model_dump(mode="json", by_alias=True), **overrides}
        return replace(self, config=self.cls.Config.model_validate_json(json.dumps(merged)))
