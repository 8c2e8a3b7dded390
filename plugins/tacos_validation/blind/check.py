"""The diagnosis, checked blind on effects that were withheld from it."""

from __future__ import annotations

import json
import multiprocessing
import shutil
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from tacos_framework.contracts import Executor
from tacos_framework.errors import Fault, UserError
from tacos_framework.plugins import Plugins
from tacos_framework.settings import Settings, setting
from tacos_framework.study.progress import Progress
from tacos_gap.candidates import candidates
from tacos_report.page import write_page
from tacos_validation.blind.cases import Case
from tacos_validation.blind.generators.specifications import (
    CAPTURES,
    KEPT_BACK,
    CaseSpecification,
    Commitment,
    commit,
    make_and_commit,
    reveal,
)
from tacos_validation.blind.pages import page
from tacos_validation.blind.real_cases import RealCase, real_cases
from tacos_validation.blind.scoring import Figure, baselines, figures
from tacos_validation.blind.solving import Diagnosing, FreshGaps, Worker
from tacos_validation.blind.tiers import Counts, case_specifications

COMPARED = ("T0", "T1", "T2")
"""Tiers on which simpler ways are tried too."""

CASES, COMMITMENTS = "cases.jsonl", "commitments.jsonl"


class GapBlindCheck:
    """Makes cases with withheld effects, diagnoses them, opens the truth, and keeps score.

    Cases go batch by batch: a batch is made in processes of the generator, which writes each truth with a
    salt and hands back its SHA-256; the digests are written to ``commitments.jsonl`` before the diagnosis of
    the batch begins, in the executor's processes. The truth is opened, and held against its digest, when all
    answers of the batch are there. Every case ends in ``cases.jsonl``. A broken run goes on with
    ``--resume``.
    """

    class Config(Settings):
        """Settings of the check."""

        counts: Counts = setting(Counts(), help="How many cases of each tier.")
        width_px: int = setting(240, help="Width of the captures.", unit="px", ge=64)
        height_px: int = setting(180, help="Height of the captures.", unit="px", ge=48)
        captures: str = setting("charts", help="Captures of cases with all of them: charts, or smallest.")
        real: str = setting(
            "", help="Folder with real captures of known truth (T5); left out if empty.", is_path=True
        )
        baselines: bool = setting(True, help="Whether simpler ways are tried on the same cases.")
        batch: int = setting(12, help="Cases made, and kept on disk, at a time.", ge=1)
        makers: int = setting(1, help="Processes that make cases.", ge=1)
        keep: bool = setting(False, help="Whether captures are kept; some 5 MB a case.")

    def __init__(self, config: Config) -> None:
        self.config = config

    def run(
        self, *, out: Path, seed: int, plugins: Plugins, executor: Executor, progress: Progress, resume: bool
    ) -> Mapping[str, Any]:
        """Check; leaves ``report.html``, ``cases.jsonl`` and ``commitments.jsonl``."""
        config = self.config
        notes: list[str] = []
        wanted = case_specifications(
            config.counts, seed, (config.width_px, config.height_px), config.captures
        )
        cases = list(_read_cases(out / CASES)) if resume else []
        done = {case.name for case in cases}
        wanted = [spec for spec in wanted if spec.case not in done]
        real = [case for case in self._real(notes) if case.name not in done]
        worker = Worker(candidates(plugins).effects)
        progress.phase("Diagnosing withheld effects", len(wanted) + len(real))
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(config.makers, mp_context=context) as makers:
            timed = [spec for spec in wanted if spec.tier == "speed"]
            others = [spec for spec in wanted if spec.tier != "speed"]
            for batch in (  # what is timed goes alone
                *_batches(timed, 1),
                *_batches(others, config.batch),
                *_batches(real, config.batch),
            ):
                commitments = self._make(batch, out, makers)
                found = self._solve(batch, commitments, out, worker, executor)
                _append(out / CASES, [case.as_data() for case in found])
                for case in found:
                    progress.step(_line(case))
                cases += found
                if not config.keep:
                    shutil.rmtree(out / "made")
        scored = figures(cases)
        write_page(out / "report.html", page(cases, scored, notes))
        return _result(cases, scored, notes)

    def _real(self, notes: list[str]) -> list[RealCase]:
        if not self.config.real:
            notes.append("T5 is left out: no folder of real captures was given.")
            return []
        folder = Path(self.config.real)
        if not folder.is_dir():
            notes.append(f"T5 is left out: the folder of real captures, {folder.name}, is not there.")
            return []
        return list(real_cases(folder))

    def _make(
        self, batch: Sequence[CaseSpecification | RealCase], out: Path, makers: ProcessPoolExecutor
    ) -> list[Commitment]:
        """Make a batch and commit to its truth before anything else is done with it."""
        made, truths = out / "made", out / "truths"
        pending = []
        for each in batch:
            if isinstance(each, CaseSpecification):
                pending.append(makers.submit(make_and_commit, each, made, truths))
        commitments = [future.result() for future in pending]
        for each in batch:
            if isinstance(each, RealCase):
                each.write(made / each.name)
                commitments.append(commit(each.name, _real_truth(each), truths / f"{each.name}.json"))
        _append(
            out / COMMITMENTS,
            [{"case": commitment.case, "sha256": commitment.digest} for commitment in commitments],
        )
        return commitments

    def _solve(
        self,
        batch: Sequence[CaseSpecification | RealCase],
        commitments: Sequence[Commitment],
        out: Path,
        worker: Worker,
        executor: Executor,
    ) -> list[Case]:
        """Answers first, all of them; then the truth; then how the answers fare on fresh captures."""
        made = out / "made"
        removed = {each.case: each.removed for each in batch if isinstance(each, CaseSpecification)}
        timed = {each.case for each in batch if isinstance(each, CaseSpecification) and each.tier == "speed"}
        compared = {
            each.case for each in batch if isinstance(each, CaseSpecification) and each.tier in COMPARED
        }
        jobs = [
            Diagnosing(
                s.case,
                made / s.case / CAPTURES,
                removed.get(s.case, ()),
                self.config.baselines and s.case in compared,
                threads=2 if s.case in timed else 1,
            )
            for s in commitments
        ]
        answers = dict(zip([s.case for s in commitments], executor.map(worker, jobs), strict=True))
        truths = {s.case: reveal(s, out / "truths" / f"{s.case}.json") for s in commitments}
        fresh = [
            job
            for s in commitments
            if (job := _fresh_gaps_job(s.case, made / s.case / KEPT_BACK, answers[s.case], truths[s.case]))
        ]
        fresh_gaps = dict(zip([job.case for job in fresh], executor.map(worker, fresh), strict=True))
        return [
            Case(
                s.case,
                truths[s.case]["specification"]["tier"],
                truths[s.case],
                answers[s.case],
                fresh_gaps.get(s.case),
            )
            for s in commitments
        ]


def _fresh_gaps_job(
    case: str, folder: Path, answer: Mapping[str, Any], truth: Mapping[str, Any]
) -> FreshGaps | None:
    if not folder.is_dir() or "error" in answer:
        return None
    withheld = truth["withheld"]
    known = all(each["parameters"] for each in withheld)
    settings = [{"use": each["effect"], **each["parameters"]} for each in withheld] if known else []
    return FreshGaps(case, folder, answer["patch"], settings)


def _real_truth(case: RealCase) -> dict[str, Any]:
    first = case.expects.get("first", ())
    return {
        "specification": {"tier": "T5", "captures": "real", "severity": None, "notes": {}, "variants": {}},
        "withheld": [{"effect": name, "parameters": {}, "units": None} for name in first[:1]],
        "expects": {key: list(value) for key, value in case.expects.items()},
    }


def _batches(items: Sequence[Any], size: int) -> Iterator[list[Any]]:
    for start in range(0, len(items), size):
        yield list(items[start : start + size])


def _append(file: Path, lines: Sequence[Mapping[str, Any]]) -> None:
    with file.open("a", encoding="utf-8") as stream:
        for line in lines:
            stream.write(json.dumps(line, ensure_ascii=False) + "\n")


def _read_cases(file: Path) -> Iterator[Case]:
    """Cases of a broken run; a last line that was cut off counts for nothing.

    Raises
    ------
    UserError
        When another version wrote them.
    """
    if not file.is_file():
        return
    for line in file.read_text("utf-8").splitlines():
        try:
            data = json.loads(line)
        except json.JSONDecodeError:
            return
        if "fresh_gaps" not in data:
            raise UserError(
                Fault(
                    str(file),
                    "an older version of tacos-framework wrote these cases",
                    "cases of this version",
                    "Go on with that version, or start anew without --resume.",
                )
            )
        yield Case.of(data)


def _line(case: Case) -> str:
    withheld = " + ".join(case.effects) or "nothing"
    return (
        f"{case.tier} {withheld}: {' + '.join(case.causes) or case.first} {'' if case.right else '(wrong)'}"
    )


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
