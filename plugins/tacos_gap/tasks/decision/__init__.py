"""The decision of a study in the better simulator, beside that in the one as it was."""

from __future__ import annotations

from tacos_gap.tasks.decision.decide import Question, decide

__all__ = ["Question", "decide"]
