"""Studies that a user breaks off."""

from __future__ import annotations

from typing import Any

import pytest

from tacos_validation import harness


@pytest.fixture
def third_study_breaks_off(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Breaks the third study of a comparison off as it begins; gives the folders of those begun, in order."""
    begun: list[str] = []
    run_study = harness.run

    def third_time_unlucky(*given: Any, **named: Any) -> Any:
        begun.append(named["out"].name)
        if len(begun) == 3:
            raise KeyboardInterrupt
        return run_study(*given, **named)

    monkeypatch.setattr(harness, "run", third_time_unlucky)
    return begun
