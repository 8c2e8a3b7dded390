"""The analysis of a finished study; what it needs is imported once there is one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tacos_framework.hookspecs import hookimpl


@hookimpl
def tacos_analyse_study(record: Any) -> Mapping[str, Any]:
    """Rank every part, find the equals and what matters: see `tacos_decision.analysis`."""
    from tacos_decision.analysis import analyse

    return analyse(record)
