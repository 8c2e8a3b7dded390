"""A procedure for tests of the framework."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tacos_framework.settings import Settings, setting


class Counting:
    """Squares the numbers below a limit."""

    class Config(Settings):
        limit: int = setting(help="Numbers to square.", ge=1)

    def __init__(self, config: Config) -> None:
        self.config = config

    def run(self, *, seed: int) -> Mapping[str, Any]:
        squares = [number * number + seed for number in range(self.config.limit)]
        return {"squares": squares, "summary": f"{len(squares)} squares"}
