"""One point of a design space."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import blake2b
from typing import Any

from tacos_framework.values.catalog_part import CatalogPart


@dataclass(frozen=True, eq=False)
class Candidate:
    """One point of a design space, snapped to what can be manufactured."""

    values: Mapping[str, Any]
    """For each variable its value; a `CatalogPart` for catalog variables."""
    genes: tuple[float, ...]
    """The genes of exactly these values."""
    key: str = field(init=False)
    """Content hash of the values: equal keys mean equal candidates, in every process."""

    def __post_init__(self) -> None:
        content = json.dumps(self.as_dict(), sort_keys=True, allow_nan=False)
        object.__setattr__(self, "key", blake2b(content.encode(), digest_size=16).hexdigest())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Candidate) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)

    def as_dict(self) -> dict[str, Any]:
        """The values as JSON values; a part is its name and columns."""
        return {
            name: value.as_dict() if isinstance(value, CatalogPart) else value
            for name, value in self.values.items()
        }
