"""Figures of results on matplotlib axes: ``tacos.plot.ranking(tacos.read_result(folder))``.

Each function takes a result, draws on `axes` or on those of a new figure, and returns them.
"""

from __future__ import annotations

from tacos_decision.plots import progress, ranking, scores_by_scene
from tacos_gap.report.plots import closure

__all__ = ["closure", "progress", "ranking", "scores_by_scene"]
