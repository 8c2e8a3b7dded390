"""The diagnosis, checked blind on effects that were withheld from it."""

from __future__ import annotations

import multiprocessing
import shutil
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

from tacos_framework import Executor, Plugins, Progress, Settings, setting
from tacos_framework.store import Results
from tacos_gap.hypotheses.candidates import candidates
from tacos_report.page import write_page
from tacos_validation.blind.cases import Case
from tacos_validation.blind.figure import Figure
from tacos_validation.blind.generators.specifications import CAPTURES, KEPT_BACK, Commitment, reveal
from tacos_validation.blind.making import MADE, TRUTHS, Batch, Wanted, made_ahead, name_of
from tacos_validation.blind.pages import page
from tacos_validation.blind.real_cases import real_cases
from tacos_validation.blind.real_folders import RealCase, real_folders
from tacos_validation.blind.records import CASES, kept_cases
from tacos_validation.blind.scoring import baselines, figures
from tacos_validation.blind.solving import Diagnosing, FreshGaps, Worker
from tacos_validation.blind.tiers import Counts, case_specifications

COMPARED = ("T0", "T1", "T2")
"""Tiers on which simpler ways are tried too."""

SLOW = ("T2", "T3")
"""Tiers whose cases take several effects to explain, or several in the place of the one that is missing."""


class GapBlindCheck:
    """Makes cases with withheld effects, diagnoses them, opens the truth, and keeps score.

    Cases go batch by batch: a batch is made in processes of the generator, while the one before is solved.
    They write each truth with a salt and hand back its SHA-256; the digests are written to
    ``commitments.jsonl`` before the diagnosis of the batch begins, in the executor's processes. The truth is
    opened, and held against its digest, when all answers of the batch are there. Every case ends in
    ``cases.jsonl``. A broken run goes on with ``--resume``.
    """

    class Config(Settings):
        counts: Counts = setting(Counts(), help="Number of cases of each tier.")
        width_px: int = setting(160, help="Width of the captures.", unit="px", ge=64)
        height_px: int = setting(120, help="Height of the captures.", unit="px", ge=48)
        captures: str = setting("charts", help="Captures of cases with all of them: charts, or smallest.")
        real: str = setting(
            "",
            help="Folder of folders of real captures with a truth.json (T5); left out if empty.",
            is_path=True,
        )
        real_data: str = setting(
            "",
            help="Folder of public pictures from which real cases are made (T5); left out if empty.",
            is_path=True,
        )
        baselines: bool = setting(True, help="Run simpler methods on the same cases.")
        case_limit_s: float | None = setting(
            600.0, help="Longest processor time for a diagnosis; past it there is no answer.", unit="s", gt=0
        )
        batch: int = setting(48, help="Cases solved before their truth is opened.", ge=1)
        makers: int = setting(1, help="Processes that make cases.", ge=1)
        keep: bool = setting(False, help="Keep the captures; some 5 MB a case.")

    def __init__(self, config: Config) -> None:
        self.config = config

    def run(
        self, *, out: Path, seed: int, plugins: Plugins, executor: Executor, progress: Progress, resume: bool
    ) -> Mapping[str, Any]:
        config = self.config
        notes: list[str] = []
        size = (config.width_px, config.height_px)
        results = Results(out)
        cases = kept_cases(results) if resume else []
        done = {case.name for case in cases}
        effects = candidates(plugins).effects
        specifications = case_specifications(config.counts, seed, size, config.captures)
        every: list[Wanted] = [*specifications, *self._real(notes, tuple(effects))]
        wanted = [each for each in every if name_of(each) not in done]
        worker = Worker(effects, config.case_limit_s)
        progress.phase("Diagnosing withheld effects", len(wanted))
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(config.makers, mp_context=context) as makers:
            for batch, commitments in made_ahead(wanted, config.batch, results, makers):
                right = f"{sum(case.right for case in cases)} of {len(cases)} right so far" if cases else ""
                found = self._solve(
                    batch, commitments, out, worker, executor, answered=partial(progress.step, right)
                )
                for case in found:
                    results.append_line(CASES, case.as_data())
                cases += found
                if not config.keep:
                    _clear(batch, out)
        scored = figures(cases)
        write_page(out / "report.html", page(cases, scored, notes))
        return _result(cases, scored, notes)

    def _real(self, notes: list[str], effects: Sequence[str]) -> list[RealCase]:
        found: list[RealCase] = []
        for key, folder in (("real", self.config.real), ("real_data", self.config.real_data)):
            if folder and not Path(folder).is_dir():
                notes.append(f"The folder of {key}, {Path(folder).name}, is not there.")
            elif folder and key == "real":
                found += real_folders(Path(folder), effects)
            elif folder:
                found += real_cases(Path(folder))
        if not found:
            notes.append("T5 is left out: there are no captures of real cameras.")
        return found

    def _solve(
        self,
        batch: Batch,
        commitments: Sequence[Commitment],
        out: Path,
        worker: Worker,
        executor: Executor,
        answered: Callable[[], None],
    ) -> list[Case]:
        """Answers first, all of them; then the truth; then how the answers fare on fresh captures."""
        jobs = [self._diagnosing(each, out / MADE) for each in sorted(batch, key=_place_in_batch)]
        answers = {}
        for asked, answer in zip(jobs, executor.map(worker, jobs), strict=True):
            answers[asked.case] = answer
            answered()
        truths = {s.case: reveal(s, out / TRUTHS / f"{s.case}.json") for s in commitments}
        fresh = [
            job
            for case, truth in truths.items()
            if (job := _fresh_gaps_job(case, out / MADE / case / KEPT_BACK, answers[case], truth))
        ]
        fresh_gaps = dict(zip([job.case for job in fresh], executor.map(worker, fresh), strict=True))
        return [
            Case(case, truth["specification"]["tier"], truth, answers[case], fresh_gaps.get(case))
            for case, truth in truths.items()
        ]

    def _diagnosing(self, each: Wanted, made: Path) -> Diagnosing:
        name = name_of(each)
        if isinstance(each, RealCase):
            return Diagnosing(name, made / name / CAPTURES, baselines=False)
        return Diagnosing(
            name,
            made / name / CAPTURES,
            each.removed,
            self.config.baselines and each.tier in COMPARED,
            processes=2 if each.tier == "speed" else 1,
        )


def _place_in_batch(each: Wanted) -> int:
    """Place in a batch: the longest cases first, so that no worker idles at the end."""
    if isinstance(each, RealCase):
        return 2
    if each.nuisance == "processed":
        return 0
    return 1 if each.tier in SLOW else 3


def _fresh_gaps_job(
    case: str, folder: Path, answer: Mapping[str, Any], truth: Mapping[str, Any]
) -> FreshGaps | None:
    if not folder.is_dir() or "error" in answer:
        return None
    withheld = truth["withheld"]
    known = all(each["parameters"] for each in withheld)
    settings = [{"use": each["effect"], **each["parameters"]} for each in withheld] if known else []
    return FreshGaps(case, folder, answer["patch"], settings)


def _clear(batch: Batch, out: Path) -> None:
    for each in batch:
        shutil.rmtree(out / MADE / name_of(each))
    if not any((out / MADE).iterdir()):
        (out / MADE).rmdir()


def _result(cases: Sequence[Case], scored: Sequence[Figure], notes: Sequence[str]) -> dict[str, Any]:
    goals = [figure for figure in scored if figure.met is not None]
    lines = [f"{sum(bool(f.met) for f in goals)} of {len(goals)} goals met over {len(cases)} cases."]
    for each in goals:
        number = f"{each.value:.1%}" if each.unit == "%" else f"{each.value:.2f}{each.unit}"
        lines.append(
            f"  {'met   ' if each.met else 'missed'} {each.name}: {number} of {each.count}, {each.goal}"
        )
    return {
        "figures": [each.as_data() for each in scored],
        "baselines": {
            way: {name: each.as_data() for name, each in row.items()} for way, row in baselines(cases).items()
        },
        "failures": [case.name for case in cases if not case.right],
        "notes": list(notes),
        "cases": len(cases),
        "summary": "\n".join([*lines, *notes]),
    }
