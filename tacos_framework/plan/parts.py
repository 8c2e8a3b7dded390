"""A component class with its checked settings."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
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
        if not overrides:
            return self.cls(self.config, **supplied)
        merged = {**self.config.model_dump(mode="json", by_alias=True), **overrides}
        return self.cls(self.cls.Config.model_validate_json(json.dumps(merged)), **supplied)
