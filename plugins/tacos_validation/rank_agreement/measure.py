"""One set of cameras, scored by a small study and by the same study at full size."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tacos_framework import Evaluation, Executor, Plugins, Progress, generator
from tacos_framework.plan import Plan, make_plan
from tacos_framework.store import Results
from tacos_validation.harness import FaultsTogether, leave, study_recipe
from tacos_validation.rank_agreement.agreement import agreement, agreement_of_halves, decided_pairs, tau_b
from tacos_validation.rank_agreement.cameras import RankedCamera, cameras_of
from tacos_validation.rank_agreement.outcome import SIZES, RankedLight, RankOutcome
from tacos_validation.rank_agreement.pages import page, summary, table_csv
from tacos_validation.rank_agreement.scored import Judge, Rows, scores_of
from tacos_validation.rank_agreement.settings import RankAgreementConfig


class RankAgreement:
    """Tells whether a small study puts cameras in the order in which the same study at full size has them.

    Both see the same worlds, walks, poses and noise draws, in each light; only what ``full`` names differs.
    So their agreement tells what being small does to the order; how far the scenes settle it is told by that
    of the study at full size with itself, on two halves of them. A camera that breaks a constraint or fails
    has no place, and is named with the reason. Tasks that learn are scored with the weights they start from.
    A broken run goes on with ``--resume``: scores are kept as they come.
    """

    Config = RankAgreementConfig

    def __init__(self, config: RankAgreementConfig) -> None:
        self.config = config

    def run(
        self, *, out: Path, seed: int, plugins: Plugins, executor: Executor, progress: Progress, resume: bool
    ) -> Mapping[str, Any]:
        plans = self._plans(plugins)
        cameras = cameras_of(self.config.cameras, next(iter(plans.values())))
        results = Results(out)
        scored: dict[tuple[str, str], Rows] = {}
        for (light, size), plan in plans.items():
            progress.phase(f"{light}, {size}", len(cameras) * self._scenes(plan))
            scored[light, size] = scores_of(
                plan, cameras, self._scenes(plan), plugins, executor, results, progress.step
            )
        outcome = self._outcome(plans, scored, cameras, seed)
        return leave(out, page(outcome), outcome.as_data(), summary(outcome), table=table_csv(outcome))

    def _plans(self, plugins: Plugins) -> dict[tuple[str, str], Plan]:
        plans: dict[tuple[str, str], Plan] = {}
        faults = FaultsTogether()
        for light, keys in self.config.lights.items():
            for size in SIZES:
                full = self.config.full if size == "full" else {}
                with faults.of():
                    recipe = study_recipe(self.config.study, {**self.config.change, **keys, **full})
                    plans[light, size] = make_plan(recipe, plugins)
        faults.refuse()
        return plans

    def _scenes(self, plan: Plan) -> int:
        return self.config.scenes or plan.recipe.study.episodes

    def _outcome(
        self,
        plans: Mapping[tuple[str, str], Plan],
        scored: Mapping[tuple[str, str], Rows],
        cameras: Sequence[RankedCamera],
        seed: int,
    ) -> RankOutcome:
        values = {camera.name: camera.values for camera in cameras}
        lights = []
        for light in self.config.lights:
            judges = {size: Judge(values, scored[light, size], plans[light, size].fitness) for size in SIZES}
            evaluations = {size: judge.all_scenes() for size, judge in judges.items()}
            quick, full = (evaluations[size] for size in SIZES)
            ranked = [n for n in values if quick[n].fitness is not None and full[n].fitness is not None]
            found = agreement(
                ranked,
                judges["quick"],
                judges["full"],
                self._scenes(plans[light, "quick"]),
                resamples=self.config.resamples,
                confidence=self.config.confidence,
                rng=generator(seed, "rank agreement", light),
            )
            of_halves = agreement_of_halves(
                ranked,
                judges["full"],
                self._scenes(plans[light, "full"]),
                resamples=self.config.resamples,
                rng=generator(seed, "rank agreement, halves", light),
            )
            decided = decided_pairs(
                ranked,
                judges["quick"],
                judges["full"],
                self._scenes(plans[light, "full"]),
                resamples=self.config.resamples,
                confidence=self.config.confidence,
                rng=generator(seed, "rank agreement, decided pairs", light),
            )
            by_score = _by_score(ranked, quick, full)
            lights.append(RankedLight(light, found, by_score, evaluations, of_halves, decided))
        first = next(iter(plans.values()))
        notes = tuple(
            f"{name} learns in the study; here it is scored with the weights it starts from."
            for name in first.trainable
        )
        return RankOutcome(
            study=self.config.study,
            gate=self.config.gate,
            fewest=self.config.fewest,
            confidence=self.config.confidence,
            scenes=self._scenes(first),
            lights=tuple(lights),
            notes=notes,
        )


def _by_score(
    ranked: Sequence[str], quick: Mapping[str, Evaluation], full: Mapping[str, Evaluation]
) -> dict[str, float | None]:
    reported = [set(size[name].scores) for name in ranked for size in (quick, full)]
    everywhere = sorted(set.intersection(*reported)) if reported else []
    return {
        score: tau_b([quick[n].scores[score] for n in ranked], [full[n].scores[score] for n in ranked])
        for score in everywhere
        if score != "fitness" and len(ranked) > 1
    }
