"""Analysis of a finished study: all parts ranked, equals, tolerances, importance, fronts.

`read_result` reads the results folder of a study, and gives its tables as lists or data frames.
"""

from __future__ import annotations

from tacos_decision.tables import StudyResult, read_result

__all__ = ["StudyResult", "read_result"]
