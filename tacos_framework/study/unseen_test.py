"""Cameras on scenes that none was designed on: as many as it takes to tell them apart."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from tacos_framework.contracts import Executor, Scores
from tacos_framework.fitness import Fitness
from tacos_framework.recipe import Test
from tacos_framework.simulation import EpisodeSpec, Evaluation, Evaluator, ScoreJob, merged_evaluation
from tacos_framework.study.fitness_contributions import contributions
from tacos_framework.study.sequential import PairedInterval, compared, error_at, looks
from tacos_framework.study.shards import score_sharded


@dataclass
class UnseenTest:
    """The designed camera beside the products, on more and more scenes."""

    settings: Test
    """Number of scenes and confidence."""
    fitness: Fitness
    designed: str
    """Name of the camera that each other is compared with."""
    evaluations: dict[str, Evaluation] = field(default_factory=dict)
    """Evaluations so far, by name; each camera's scenes are the first so many."""

    def episodes(self, first: int, last: int) -> tuple[EpisodeSpec, ...]:
        """Test episodes by number; `last` is not among them."""
        test = self.settings
        return tuple(EpisodeSpec(test.seed, ("test", i), test.frames) for i in range(first, last))

    @property
    def looks(self) -> tuple[int, ...]:
        """The numbers of scenes after which is looked."""
        return looks(self.settings.episodes, self.settings.most_episodes or self.settings.episodes)

    def run(
        self,
        cameras: Mapping[str, ScoreJob],
        executor: Executor,
        evaluate: Evaluator,
        on_look: Callable[[int], None],
        on_evaluated: Callable[[Evaluation], None],
    ) -> None:
        """Add scenes until the comparison with the best product is decided or the most are spent.

        `cameras`: what scoring each camera is, by name; their episodes are set here. `on_look`,
        `on_evaluated`: told before a block of scenes how many cameras see it, and each camera's evaluation of
        it.
        """
        for count in self.looks:
            wanted = self._wanted(cameras)
            behind = [name for name in wanted if self._seen(name) < count]
            if not behind:
                continue
            on_look(len(behind))
            jobs = [
                replace(cameras[name], episodes=self.episodes(self._seen(name), count)) for name in behind
            ]
            scored = list(score_sharded(jobs, executor, evaluate))
            for name, evaluation in zip(behind, scored, strict=True):
                known = self.evaluations.get(name)
                self.evaluations[name] = (
                    _merged([known, evaluation], self.fitness) if known is not None else evaluation
                )
                on_evaluated(evaluation)

    def _wanted(self, cameras: Mapping[str, ScoreJob]) -> list[str]:
        """The cameras that more scenes would tell more of."""
        new = [name for name in cameras if name not in self.evaluations]
        if new:
            return new
        comparisons = self.comparisons
        undecided = [name for name, found in comparisons.items() if found.verdict == "undecided"]
        best = min(comparisons, key=lambda name: comparisons[name].difference, default=None)
        return [self.designed, *undecided] if best in undecided else []

    def _seen(self, name: str) -> int:
        return len(self.evaluations[name].blocks) if name in self.evaluations else 0

    @property
    def scored(self) -> dict[str, Evaluation]:
        """The cameras that did not fail."""
        return {name: found for name, found in self.evaluations.items() if found.fitness is not None}

    @property
    def failed(self) -> dict[str, str]:
        """The cameras that did, and why in a sentence."""
        return {name: found.failed for name, found in self.evaluations.items() if found.failed}

    @property
    def comparisons(self) -> dict[str, PairedInterval]:
        """The designed camera less each other that was scored, by name; empty without a designed one."""
        scored = self.scored
        products = [name for name in scored if name != self.designed]
        if self.designed not in scored:
            return {}
        error = (1 - self.settings.confidence) / max(1, len(self.evaluations) - 1)
        return {name: self._compared(scored[self.designed], scored[name], error) for name in products}

    def _compared(self, designed: Evaluation, product: Evaluation, error: float) -> PairedInterval:
        count = min(len(designed.blocks), len(product.blocks))
        ours, theirs = (first_episodes(each, count, self.fitness) for each in (designed, product))
        own, other = (contributions(each.blocks, self.fitness) for each in (ours, theirs))
        if ours.fitness is None or theirs.fitness is None:
            return PairedInterval(0.0, None, count, "undecided")
        if own is None or other is None:
            return PairedInterval(ours.fitness - theirs.fitness, None, count, "undecided")
        error = error_at(count, self.looks, error)
        return compared(own - other, error=error, margin=self.fitness.margin)

    @property
    def on_common_scenes(self) -> dict[str, Evaluation]:
        """Each camera's scores on the scenes that all of them have seen, so that they compare."""
        scored = self.scored
        common = min((len(found.blocks) for found in scored.values()), default=0)
        return {
            name: first_episodes(found, common, self.fitness) if name in scored else found
            for name, found in self.evaluations.items()
        }


def first_episodes(evaluation: Evaluation, count: int, fitness: Fitness) -> Evaluation:
    """Outcome on the first so many of an evaluation's episodes."""
    if count == len(evaluation.blocks):
        return evaluation
    columns = {name: tuple(column[:count]) for name, column in evaluation.scenario_episodes.items()}
    first = replace(evaluation, episodes=evaluation.episodes[:count], scenario_episodes=columns)
    return _merged([first], fitness)


def _merged(evaluations: Sequence[Evaluation], fitness: Fitness) -> Evaluation:
    """One evaluation of all their episodes, each of which may lack a score that others have."""
    partials = [
        replace(
            each,
            failed=None if each.blocks else each.failed,
            episodes=tuple(_scores(episode) for episode in each.episodes),
            scenario_episodes={
                name: tuple(_scores(episode) for episode in column)
                for name, column in each.scenario_episodes.items()
            },
        )
        for each in evaluations
    ]
    return merged_evaluation(partials, fitness)


def _scores(episode: Scores) -> dict[str, float]:
    return {name: value for name, value in episode.items() if name != "fitness"}
