"""Scores of the tasks in an episode."""

from __future__ import annotations

from collections.abc import Mapping

from tacos_framework.contracts import Scorer, Scores, State
from tacos_framework.simulation.checked_outputs import checked_scores
from tacos_framework.simulation.context import EvaluationContext
from tacos_framework.simulation.episodes import EpisodeSpec


def score(context: EvaluationContext, spec: EpisodeSpec, states: Mapping[str, State]) -> tuple[Scores, int]:
    """Show an episode to all tasks.

    `spec`: the episode, of every scene of the graph.

    Returns: ``{"node.score": value}``, and how many images were rendered.
    """
    graph = context.plan.graph
    scores: dict[str, float] = {}
    images = 0
    for scene in graph.of_kind("scene"):
        tasks = [task for task in graph.of_kind("task") if graph.scene_of(task) == scene]
        scorers: dict[str, Scorer] = {}
        for task in tasks:
            with context.at_work(task):
                scorers[task] = context.components[task].begin(state=states.get(task))
        with context.clock.of(scene):
            episode = context.episode(scene, spec)
        images += len(episode) * len(context.rig.cameras)
        for inputs in context.stream(scene, episode, context.draws(spec), tasks):
            for task in tasks:
                with context.at_work(task):
                    scorers[task].update(**inputs[task])
        for task in tasks:
            with context.at_work(task):
                reported = checked_scores(context.plan.nodes[task].origin, scorers[task].scores())
            scores.update({f"{task}.{name}": value for name, value in reported.items()})
    return scores, images
