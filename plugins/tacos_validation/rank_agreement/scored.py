"""Cameras, each scored by a study on the same scenes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from tacos_framework import Evaluation, Executor, Fitness, Plugins
from tacos_framework.plan import Plan
from tacos_framework.simulation import EpisodeSpec, Evaluator
from tacos_framework.store import Results
from tacos_validation.rank_agreement.cameras import RankedCamera
from tacos_validation.score_table import ScoreTable, TableRow, evaluation_of

Rows = Mapping[str, Sequence[TableRow]]
"""For each camera its scores on each scene."""


def scores_of(
    plan: Plan,
    cameras: Sequence[RankedCamera],
    scenes: int,
    plugins: Plugins,
    executor: Executor,
    results: Results,
    on_row: Callable[..., None],
) -> Rows:
    """Scores of cameras on the first scenes of a study. `on_row`: called once for each that is there."""
    evaluate = Evaluator(plan.recipe, plugins)
    states = evaluate.simulation.initial_states() if plan.trainable else {}
    table = ScoreTable(plan, evaluate, executor, results, states)
    specs = [EpisodeSpec(plan.recipe.seed, ("design", 0, i)) for i in range(scenes)]
    wanted = [(camera.values, spec) for camera in cameras for spec in specs]
    for _ in range(len(wanted) - len(table.lacking(wanted))):
        on_row()
    table.fill(wanted, on_row)
    return {camera.name: [table.row(camera.values, spec) for spec in specs] for camera in cameras}


class Judge:
    """The fitness of cameras on some of the scenes they were scored on."""

    def __init__(self, values: Mapping[str, Mapping[str, Any]], rows: Rows, fitness: Fitness) -> None:
        self._values, self._rows, self._fitness = values, rows, fitness

    def __call__(self, camera: str, scenes: Sequence[int]) -> float | None:
        return self._evaluation(camera, scenes).fitness

    def all_scenes(self) -> dict[str, Evaluation]:
        return {name: self._evaluation(name, range(len(rows))) for name, rows in self._rows.items()}

    def _evaluation(self, camera: str, scenes: Sequence[int]) -> Evaluation:
        rows = self._rows[camera]
        return evaluation_of(self._values[camera], [rows[scene] for scene in scenes], self._fitness)
