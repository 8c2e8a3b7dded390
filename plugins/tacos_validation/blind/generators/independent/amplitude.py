"""Effects that one number scales."""

from __future__ import annotations

from typing import Any

from tacos_validation.blind.generators.injected_effect import InjectedEffect


class SingleAmplitudeEffect(InjectedEffect):
    """An effect of one amplitude, whose shape the catalogue's parameters do not describe."""

    amplitude: float = 0.0

    @property
    def parameters(self) -> dict[str, Any]:
        """None that could be compared."""
        return {}
