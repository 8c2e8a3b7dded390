"""Variants of a study, such as a camera designed jointly with its network and one for a frozen network."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import JsonValue, model_validator

from tacos_framework import (
    Executor,
    Fault,
    Plugins,
    Progress,
    Recipe,
    Settings,
    UserError,
    did_you_mean,
    setting,
)
from tacos_framework.plan import make_plan
from tacos_framework.store import DESIGNED
from tacos_validation.harness import FaultsTogether, leave, result_of, tested_recipe
from tacos_validation.studies_compared.pages import StudiesComparison, page, summary, table_csv
from tacos_validation.studies_compared.pairs import StudyOutcome


class CompareStudies:
    """Runs a study in several variants and with several seeds, and sets their designs side by side.

    Studies of a seed see the same worlds and are tested on the same unseen scenes; each seed has unseen
    scenes of its own. What is compared is what is designed, on those scenes. Every study is left whole under
    ``studies/``, with its report. A broken run goes on with ``--resume``; studies that are done are kept.
    """

    class Config(Settings):
        study: str = setting(
            help="The recipe of the study: a path, or the name of a shipped one.", is_path=True
        )
        change: dict[str, JsonValue] = setting(
            {}, help="Keys of that recipe to change in every variant, as with --set."
        )
        variants: dict[str, dict[str, JsonValue]] = setting(
            help="For each variant by name the keys it changes, e.g. {nodes.detect.train.weights: frozen}.",
            min_length=2,
        )
        reference: str = setting(help="The variant the others are compared with.")
        seeds: tuple[int, ...] = setting(help="Seeds to run each variant with.", min_length=1)

        @model_validator(mode="after")
        def _fits_together(self) -> CompareStudies.Config:
            if self.reference not in self.variants:
                remedy = did_you_mean(self.reference, self.variants)
                raise ValueError(f"there is no variant {self.reference!r}. {remedy}".rstrip())
            if len(set(self.seeds)) < len(self.seeds):
                raise ValueError("a seed stands twice")
            for name in self.variants:
                if not name.replace("_", "").replace("-", "").isalnum():
                    raise ValueError(f"the name of a variant is part of a folder's, so not {name!r}")
            return self

    def __init__(self, config: Config) -> None:
        self.config = config

    def check(self, *, plugins: Plugins) -> None:
        for _ in self._studies(plugins):
            pass

    def run(
        self,
        *,
        out: Path,
        plugins: Plugins,
        executor: Executor,
        progress: Progress,
        resume: bool,
        accept_changes: bool = False,
    ) -> Mapping[str, Any]:
        studies = list(self._studies(plugins))
        progress.phase("Running studies", len(studies))
        result = partial(
            result_of, plugins=plugins, executor=executor, resume=resume, accept_changes=accept_changes
        )
        outcomes = []
        for variant, seed, recipe in studies:
            folder = out / "studies" / f"{variant}-{seed}"
            outcome = _outcome(variant, seed, _with_design(result(recipe, folder), folder))
            outcomes.append(outcome)
            progress.step(f"{variant}, seed {seed}: {outcome.scores['fitness']:.3f}")
        counted = tuple(dict.fromkeys(term.score for _, _, recipe in studies for term in recipe.fitness))
        compared = StudiesComparison(self.config.study, self.config.reference, tuple(outcomes), counted)
        return leave(out, page(compared), compared.as_data(), summary(compared), studies=table_csv(outcomes))

    def _studies(self, plugins: Plugins) -> Iterator[tuple[str, int, Recipe]]:
        faults = FaultsTogether()
        for number, seed in enumerate(self.config.seeds):
            for name, changes in self.config.variants.items():
                with faults.of(f"variants.{name}"):
                    keys = {**self.config.change, **changes, "seed": seed}
                    recipe = tested_recipe(self.config.study, keys, number)
                    make_plan(recipe, plugins)
                    yield name, seed, recipe
            faults.refuse()


def _with_design(result: Mapping[str, Any], out: Path) -> Mapping[str, Any]:
    if DESIGNED not in result["test"]:
        what = f"the study ended without a design that was tested: {result['stopped']}"
        raise UserError(Fault(str(out), what))
    return result


def _outcome(variant: str, seed: int, result: Mapping[str, Any]) -> StudyOutcome:
    return StudyOutcome(
        variant,
        seed,
        scores=result["test"][DESIGNED],
        camera=result["best"]["camera"],
        images=result["frames_rendered"],
        seconds=result["seconds"],
    )
