"""Several optimizers on one design problem: equal images, many seeds, both catalog schemes."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pydantic import JsonValue, ValidationError, model_validator

from tacos_framework.contracts import Executor
from tacos_framework.errors import Fault, UserError, did_you_mean
from tacos_framework.plan import Plan, make_plan
from tacos_framework.plugins import Plugins
from tacos_framework.randomness import generator
from tacos_framework.recipe import FromCatalog, Recipe, Use
from tacos_framework.recipe.loading import load_recipe
from tacos_framework.report.page import write_page
from tacos_framework.results import Results
from tacos_framework.settings import Settings, setting
from tacos_framework.simulation import EpisodeSpec, Evaluator
from tacos_framework.study.progress import Progress
from tacos_validation.optimizers_compared.contest import Run
from tacos_validation.optimizers_compared.ledger import Ledger
from tacos_validation.optimizers_compared.pages import Comparison, page, summary
from tacos_validation.optimizers_compared.standings import middle, standing

Scheme = Literal["quantized", "discrete"]

MOST_TRIES = 50
"""Random candidates tried until one can be scored."""


class Reference(Settings):
    """The run to beat."""

    optimizer: str = setting("genetic", help="Which of the optimizers it is.")
    scheme: Scheme = setting("quantized", help="Under which scheme.")
    rounds: int = setting(20, help="After how many rounds its quality is the target.", ge=1)


class CompareOptimizers:
    """Runs optimizers side by side, each as often as there are seeds, until their images are spent.

    All runs search the same problem on the same episodes, so that fitness is a function of the candidate.
    They advance together, round by round, and a candidate that several ask for is simulated once; each of
    them is charged its images and seconds as if it ran alone. Candidates that break a constraint cost
    nothing, nor do candidates a run has had before. The rig's constraints, its renderer and its tasks are
    those of the problem's recipe; only its optimizer and the scheme of its catalogs change.

    A broken run goes on with ``--resume``: evaluations are kept as they come, and the optimizers observe
    them again.
    """

    class Config(Settings):
        """Settings of the procedure."""

        problem: str = setting(
            help="The recipe of the design problem: a path, or the name of a shipped one.", is_path=True
        )
        change: dict[str, JsonValue] = setting(
            {}, help="Keys of that recipe to change, as with --set, e.g. {rig.binning: 8}."
        )
        optimizers: dict[str, Use] = setting(
            help="The optimizers by name, with their settings.", min_length=1
        )
        optional: tuple[str, ...] = setting(
            (), help="Optimizers to leave out, with a note, where the packages they need are not installed."
        )
        schemes: tuple[Scheme, ...] = setting(
            ("quantized", "discrete"), help="Schemes of the catalog variables.", min_length=1
        )
        seeds: int = setting(10, help="Runs of each optimizer under each scheme.", ge=1)
        evaluations: int = setting(140, help="Budget of each run, in images of this many candidates.", ge=1)
        reference: Reference = setting(Reference(), help="The run to beat.")

        @model_validator(mode="after")
        def _fits_together(self) -> CompareOptimizers.Config:
            for name in (self.reference.optimizer, *self.optional):
                if name not in self.optimizers:
                    raise ValueError(
                        f"there is no optimizer {name!r}. {did_you_mean(name, self.optimizers)}".rstrip()
                    )
            if self.reference.scheme not in self.schemes:
                raise ValueError(
                    f"the reference runs under {self.reference.scheme}, which schemes leaves out"
                )
            if self.reference.optimizer in self.optional:
                raise ValueError("the reference cannot be optional")
            return self

    def __init__(self, config: Config) -> None:
        self.config = config

    def run(
        self, *, out: Path, seed: int, plugins: Plugins, executor: Executor, progress: Progress, resume: bool
    ) -> Mapping[str, Any]:
        """Compare them; leaves ``report.html``, ``curves.csv`` and ``standings.csv``."""
        problem = self._problem(plugins)
        optimizers, notes = self._optimizers(plugins)
        results = Results(out)
        evaluate = Evaluator(problem.recipe, plugins)
        recipe = problem.recipe
        episodes = [EpisodeSpec(recipe.seed, ("design", 0, i)) for i in range(recipe.study.episodes)]
        ledger = Ledger(evaluate, episodes, executor, results)
        progress.phase("Building worlds", None)
        workers = getattr(executor, "workers", 1)
        per_evaluation = self._images_per_evaluation(problem, ledger, workers, seed)
        runs = list(self._runs(problem, optimizers, per_evaluation, seed))
        progress.phase("Searching", len(runs))
        _advance(runs, ledger, progress)
        unseen = self._test(recipe, runs, evaluate, executor, results, progress)
        comparison = self._judge(runs, ledger, unseen, per_evaluation, notes)
        write_page(out / "report.html", page(comparison))
        results.write_text("curves.csv", _curves_csv(runs, comparison.best_known))
        results.write_text("standings.csv", _standings_csv(comparison))
        return {**comparison.as_data(), "evaluated": len(ledger), "summary": summary(comparison)}

    # what is compared -------------------------------------------------------------------------------------

    def _problem(self, plugins: Plugins) -> BenchmarkProblem:
        """The problem under each scheme."""
        plans: dict[str, Plan] = {}
        recipe: Any = None
        for scheme in self.config.schemes:
            loaded = load_recipe(self.config.problem, dict(self.config.change))
            if not isinstance(loaded, Recipe):
                raise UserError(
                    Fault("problem", f"{self.config.problem} is no study", "a recipe that designs")
                )
            design = {
                name: entry.model_copy(update={"scheme": scheme}) if isinstance(entry, FromCatalog) else entry
                for name, entry in loaded.design.items()
            }
            recipe = loaded.model_copy(update={"design": design})
            plans[scheme] = make_plan(recipe, plugins)
            if plans[scheme].trainable:
                raise UserError(
                    Fault(
                        "problem",
                        f"{self.config.problem} trains a task, so fitness depends on more than the candidate",
                        "a problem whose tasks do not learn",
                    )
                )
        return BenchmarkProblem(recipe, plans)

    def _optimizers(self, plugins: Plugins) -> tuple[dict[str, tuple[type[Any], Settings]], list[str]]:
        """Class and settings of each optimizer, and notes on those left out; all faults at once."""
        found: dict[str, tuple[type[Any], Settings]] = {}
        notes: list[str] = []
        faults: list[Fault] = []
        for name, use in self.config.optimizers.items():
            try:
                cls = plugins.resolve(use.use, "optimizer", where=f"optimizers.{name}")
                config = cls.Config.model_validate(use.settings)
                found[name] = (cls, config)
            except UserError as error:
                if name in self.config.optional:
                    notes.append(
                        f"{name} was left out: {'; '.join(f'{f.what}. {f.remedy}' for f in error.faults)}"
                    )
                else:
                    faults.extend(error.faults)
            except ValidationError as error:
                for each in error.errors():
                    key = ".".join(map(str, each["loc"]))
                    faults.append(Fault(f"optimizers.{name}", f"{key}: {each['msg']}"))
        if faults:
            raise UserError(faults)
        return found, notes

    def _images_per_evaluation(
        self, problem: BenchmarkProblem, ledger: Ledger, workers: int, seed: int
    ) -> int:
        """What a candidate that keeps the constraints costs; every worker has its worlds afterwards."""
        rng = generator(seed, "warm up")
        space = problem.plans[self.config.schemes[0]].space
        for _ in range(MOST_TRIES):
            if images := ledger.warm_up(space.sample(rng).as_dict(), workers):
                return images
        raise UserError(
            Fault(
                "problem",
                f"none of {MOST_TRIES} random candidates could be scored",
                "",
                "Relax its constraints.",
            )
        )

    def _runs(
        self,
        problem: BenchmarkProblem,
        optimizers: Mapping[str, tuple[type[Any], Settings]],
        per_evaluation: int,
        seed: int,
    ) -> Iterator[Run]:
        for name, (cls, config) in optimizers.items():
            for scheme in self.config.schemes:
                for number in range(self.config.seeds):
                    rng = generator(seed, "compare", name, scheme, number)
                    optimizer = cls(config, space=problem.plans[scheme].space, rng=rng)
                    images = self.config.evaluations * per_evaluation
                    yield Run(name, scheme, number, optimizer, images, per_evaluation)

    # what came out ----------------------------------------------------------------------------------------

    def _test(
        self,
        recipe: Recipe,
        runs: Sequence[Run],
        evaluate: Evaluator,
        executor: Executor,
        results: Results,
        progress: Progress,
    ) -> Ledger | None:
        """The winners of all runs on the test scenes of the problem."""
        test = recipe.test
        if test is None:
            return None
        episodes = [EpisodeSpec(test.seed, ("test", i), test.frames) for i in range(test.episodes)]
        progress.phase("Testing on unseen scenes", None)
        ledger = Ledger(evaluate, episodes, executor, results)
        ledger.look_up([run.winner for run in runs if run.winner is not None])
        return ledger

    def _judge(
        self,
        runs: Sequence[Run],
        ledger: Ledger,
        test: Ledger | None,
        per_evaluation: int,
        notes: Sequence[str],
    ) -> Comparison:
        scored = [entry.fitness for entry in ledger.entries if entry.fitness is not None]
        asked_for = self.config.reference
        groups: dict[tuple[str, str], list[Run]] = {}
        for run in runs:
            groups.setdefault((run.optimizer_name, run.scheme), []).append(run)
        reference = groups[asked_for.optimizer, asked_for.scheme]
        after = [[moment for moment in run.moments if moment.round <= asked_for.rounds] for run in reference]
        target = middle([moments[-1].best if moments else min(scored) for moments in after]).median
        # the paper renders its elites again in every generation, so all candidates asked count
        asked = middle([moments[-1].asked if moments else 0 for moments in after]).median
        early = asked * per_evaluation / 10
        standings = []
        for group in groups.values():
            winners = [run.winner for run in group if run.winner is not None]
            fitness = [test[winner].fitness for winner in winners] if test else []
            standings.append(
                standing(
                    group,
                    target=target,
                    early_images=early,
                    best_known=max(scored),
                    worst_known=min(scored),
                    unseen=[value for value in fitness if value is not None],
                )
            )
        early_stops = sorted(
            {f"{r.optimizer_name}: {r.stopped}" for r in runs if r.stopped != "budget spent"}
        )
        return Comparison(
            problem=self.config.problem,
            reference=f"{asked_for.optimizer}, {asked_for.scheme}, {asked_for.rounds} rounds",
            images_per_evaluation=per_evaluation,
            images=self.config.evaluations * per_evaluation,
            target=target,
            target_images=asked * per_evaluation,
            target_rendered=middle([m[-1].images if m else 0 for m in after]).median,
            best_known=max(scored),
            worst_known=min(scored),
            groups=groups,
            standings=tuple(standings),
            notes=(*notes, *(f"Not all runs spent their budget. {each}." for each in early_stops)),
        )


@dataclass(frozen=True)
class BenchmarkProblem:
    """The recipe, which simulates a candidate whatever the scheme, and its plan under each scheme."""

    recipe: Recipe
    plans: Mapping[str, Plan]


def _advance(runs: Sequence[Run], ledger: Ledger, progress: Progress) -> None:
    """All runs to their end, one round of each at a time, so that the executor has plenty to do."""
    going = [run for run in runs if not run.over]
    while going:
        ledger.look_up([values for run in going for values in run.ask()])
        for run in going:
            run.tell(ledger)
            if run.over:
                best = f"{run.moments[-1].best:.3f}" if run.moments else "nothing"
                progress.step(f"{run.optimizer_name} {run.scheme} {run.seed}: {best}")
        going = [run for run in going if not run.over]


def _curves_csv(runs: Sequence[Run], best_known: float) -> str:
    """A row for each improvement, and for the end, of every run."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(
        ["optimizer", "scheme", "seed", "round", "asked", "images", "seconds", "best_fitness", "regret"]
    )
    for run in runs:
        before: float | None = None
        for moment in run.moments:
            if moment.best != before or moment is run.moments[-1]:
                writer.writerow(
                    [run.optimizer_name, run.scheme, run.seed, moment.round, moment.asked, moment.images,
                     f"{moment.seconds:.3f}", moment.best, best_known - moment.best]
                )  # fmt: skip
            before = moment.best
    return text.getvalue()


def _standings_csv(comparison: Comparison) -> str:
    text = io.StringIO()
    flat = [
        {
            f"{key}_{part}" if isinstance(value, dict) else key: each
            for key, value in row.items()
            for part, each in (value.items() if isinstance(value, dict) else [("", value)])
        }
        for row in comparison.as_data()["standings"]
    ]
    writer = csv.DictWriter(text, list(flat[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(flat)
    return text.getvalue()
