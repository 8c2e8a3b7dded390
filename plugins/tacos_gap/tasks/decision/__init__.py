"""Whether a study would decide otherwise in the better simulator."""

from __future__ import annotations

from tacos_gap.tasks.decision.decide import Question, decide

__all__ = ["Question", "decide"]
