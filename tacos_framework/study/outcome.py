"""Outcome of a study, as ``result.json`` has it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from tacos_framework import __version__
from tacos_framework.contracts import SceneBase, TaskBase, optional
from tacos_framework.fitness import standard_errors
from tacos_framework.plan import Plan
from tacos_framework.plan.conditions import conditions
from tacos_framework.plan.notes import (
    inadmissible,
    notes_on_bounds,
    notes_on_camera,
    notes_on_catalogs,
    notes_on_constraints,
    notes_on_search,
)
from tacos_framework.plan.origins import notes_on_noise
from tacos_framework.simulation import Evaluation
from tacos_framework.study.degenerate import degenerate
from tacos_framework.study.kept_evaluation import as_data
from tacos_framework.study.records import candidate_record
from tacos_framework.study.score_spread import ScoreSpread, full_scores, score_spreads
from tacos_framework.study.search import Search
from tacos_framework.study.unseen_test import UnseenTest


@dataclass(frozen=True)
class Outcome:
    """Findings of a study so far."""

    plan: Plan
    searches: Sequence[Search]
    """That of the designed camera first."""
    test: UnseenTest | None
    """Outcome on the test scenes; None where the recipe has none."""
    scored_again: Sequence[Evaluation]
    """Scores asked for by analyses."""
    broken_off: str | None
    """Why it has not ended; None where it has."""

    def as_data(self) -> dict[str, Any]:
        """Outcome of the evaluations, as plain data; times, machine and pictures are not in it."""
        designed = self.searches[0]
        tested = self.test.on_common_scenes if self.test else {}
        further = [*(self.test.evaluations.values() if self.test else ()), *self.scored_again]
        return {
            "tacos": __version__,
            "name": self.plan.recipe.name,
            "seed": self.plan.recipe.seed,
            "stopped": self.broken_off or designed.stopped,
            "evaluations": sum(search.evaluations for search in self.searches) + len(further),
            "frames_rendered": sum(search.images for search in self.searches)
            + sum(evaluation.images for evaluation in further),
            "best": designed.best and _best(designed.best, tested.get(designed.name)),
            "test": {
                name: {**evaluation.scores, "fitness": evaluation.fitness}
                for name, evaluation in tested.items()
            },
            **self._no_winner(),
            "cameras": {
                s.name: self._camera(s, tested.get(s.name)) for s in self.searches if s.best is not None
            },
            "failed": self.failed(),
            "derived_units": dict(self.plan.rig.cls.derived_quantities),
            "design_space": self.plan.space.as_data(),
            "fitness": [{"score": term.score, "weight": term.weight} for term in self.plan.recipe.fitness],
            "conditions": conditions(self.plan),
            "scores": {
                name: {"share_of_variance": spread.share_of_variance, "full": spread.full}
                for name, spread in self._spreads.items()
            },
            "lower_is_better": sorted(
                f"{name}.{score}"
                for name, node in self.plan.nodes.items()
                for score in optional(node.cls, TaskBase, "lower_is_better")
            ),
            "score_meanings": {
                f"{name}.{score}": meaning
                for name, node in self.plan.nodes.items()
                for score, meaning in optional(node.cls, TaskBase, "score_meanings").items()
            },
            "carrier": self._carrier(),
        }

    def _no_winner(self) -> dict[str, str]:
        """Why the study names no winner, whatever the analyses of plugins say."""
        if self.broken_off:
            return {"decision_absent": f"The study has not ended: {self.broken_off}."}
        reason = degenerate(self.searches[0], self.plan.recipe)
        return {"degenerate": reason} if reason else {}

    def _camera(self, search: Search, test: Evaluation | None) -> dict[str, Any]:
        assert search.best is not None
        titles = {camera.name: camera.title for camera in self.plan.cameras}
        everything = self.test.evaluations.get(search.name) if self.test else None
        return {
            "title": titles.get(search.name, "Designed"),
            "camera": search.best.values,
            "derived": search.best.derived,
            "terms": test.terms if test else {},
            "episodes": list(everything.episodes) if everything else [],
            "spread": standard_errors(test.episodes) if test else {},
            "evaluations": search.searched.evaluations if search.searched else search.evaluations,
            "finalists": [candidate_record(evaluation) for evaluation in search.finalists],
            **({"scenarios": test.scenarios} if test and test.scenarios else {}),
            "free": list(search.space.names) if search.space else [],
        }

    @cached_property
    def _spreads(self) -> dict[str, ScoreSpread]:
        """Spread of each score of the fitness over the cameras of the test."""
        everyone = self.test.on_common_scenes.values() if self.test else ()
        blocks = [evaluation.blocks for evaluation in everyone if evaluation.fitness is not None]
        terms = [term.score for term in self.plan.recipe.fitness if term.weight]
        scenarios = [name for name, _ in self.plan.fitness.scenarios]
        names = [f"{scenario}/{score}" for scenario in scenarios for score in terms] if scenarios else terms
        return score_spreads(names, blocks)

    def failed(self) -> dict[str, str]:
        """Cameras of which no candidate could be scored, and why the last of them could not."""
        none = [s for s in self.searches if s.best is None and (s.generation or s.stopped)]
        ruled_out = inadmissible(self.plan) if none else {}
        return {
            search.name: ruled_out.get(search.name)
            or search.last_failure
            or search.stopped
            or "none was proposed"
            for search in none
        }

    def _carrier(self) -> str:
        """Carrier of the cameras, as the first scene names it; empty where none does."""
        said = (optional(node.cls, SceneBase, "carrier") for node in self.plan.nodes.values())
        return next(filter(None, said), "")

    def notes(self) -> Iterator[str]:
        """Notes for readers of the results, in sentences."""
        binning = getattr(self.plan.rig.config, "binning", 1)
        if binning != 1:
            yield (
                f"Pixel counts are scaled down: each simulated pixel averages {binning:g} x {binning:g} "
                f"photosites, and its noise is that of the average. "
                f"Scores are not those of the full pixel counts."
            )
        if trainings := max(search.trained_best for search in self.searches):
            yield f"Before the test, the trainable tasks were trained {trainings} times more on each camera."
        yield from notes_on_catalogs(self.plan)
        if full := full_scores(self._spreads):
            yield full
        if self.test and any(optional(node.cls, SceneBase, "one_world") for node in self.plan.nodes.values()):
            yield (
                "All scenes are trips through one world: those of the test are other ways through it. How "
                "the cameras do in other places is left open."
            )
        yield from notes_on_search(self.plan)
        yield from notes_on_constraints(self.plan)
        if (best := self.searches[0].best) is not None:
            yield from notes_on_bounds(self.plan, best.values)
            yield from notes_on_camera(self.plan, best.values)
        chosen = [search.best.values for search in self.searches if search.best is not None]
        yield from notes_on_noise(self.plan, chosen)
        titles = {camera.name: camera.title for camera in self.plan.cameras}
        ruled_out = inadmissible(self.plan)
        for name, reason in self.failed().items():
            if name not in ruled_out:  # notes on constraints name those
                yield f"No candidate of the {titles.get(name, 'design')} could be scored: {reason}."


def _best(chosen: Evaluation, tested: Evaluation | None) -> dict[str, Any]:
    """The designed camera, with the scores it has from the search, else those of the test."""
    data = as_data(tested if chosen.fitness is None and tested is not None else chosen)
    return {
        "camera": data["values"],
        "derived": data["derived"],
        "fitness": data["fitness"],
        "scores": data["scores"],
        "terms": data["terms"],
        **({"scenarios": data["scenarios"]} if data["scenarios"] else {}),
    }
