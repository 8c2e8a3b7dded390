"""Lists the diagnosis of the gap between a simulation and a real camera. Light: names code by string and imports none of it."""

from __future__ import annotations

from tacos_framework.components import Component
from tacos_framework.hookspecs import hookimpl


@hookimpl
def tacos_components() -> list[Component]:
    """The diagnosis, and captures to rehearse it with."""
    return [
        Component(
            "procedure",
            "simulate-captures",
            "tacos_gap.procedures.simulate_captures:SimulateCaptures",
            summary="A folder of captures from our own simulator, to rehearse a diagnosis without a camera.",
        ),
        Component(
            "procedure",
            "diagnose",
            "tacos_gap.procedures.diagnose:Diagnose",
            summary="Where a simulation and real captures part, which effect causes it, and how far adding it helps.",
        ),
    ]
