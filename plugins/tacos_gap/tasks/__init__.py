"""Effect of a gap on perception tasks: scores on real frames, and on simulated ones before and after."""

from __future__ import annotations

from tacos_gap.tasks.recipe_tasks import RecipeTask, default_tasks, tasks_of
from tacos_gap.tasks.scoring import CaptureScores, ScoredTasks, score_tasks
from tacos_gap.tasks.task_gap import TaskScore, task_gap

__all__ = [
    "CaptureScores",
    "RecipeTask",
    "ScoredTasks",
    "TaskScore",
    "default_tasks",
    "score_tasks",
    "task_gap",
    "tasks_of",
]
