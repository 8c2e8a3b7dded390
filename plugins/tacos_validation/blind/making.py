"""Cases made a batch ahead of those that are solved, each committed to before its diagnosis begins."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from pathlib import Path

from tacos_framework.store import Results
from tacos_validation.blind.generators.specifications import (
    CaseSpecification,
    Commitment,
    commit,
    make_and_commit,
)
from tacos_validation.blind.real_folders import RealCase
from tacos_validation.blind.records import COMMITMENTS

MADE, TRUTHS = "made", "truths"
"""Folders of a run: what is being solved, and the salted truths."""

Wanted = CaseSpecification | RealCase
Batch = Sequence[Wanted]


def name_of(each: Wanted) -> str:
    return each.case if isinstance(each, CaseSpecification) else each.name


def made_ahead(
    wanted: Sequence[Wanted], size: int, results: Results, makers: ProcessPoolExecutor
) -> Iterator[tuple[Batch, list[Commitment]]]:
    """Batches with the commitments to their truths, which by then stand in a file.

    The next batch is made while the caller solves the one it was given, but for cases that are timed.
    """
    out = results.folder
    shutil.rmtree(out / MADE, ignore_errors=True)  # what a broken run left
    batches = _batches(wanted, size)
    ahead: list[Future[Commitment]] | None = None
    for i, batch in enumerate(batches):
        making = _begun(batch, out, makers) if ahead is None else ahead
        commitments = [future.result() for future in making] + _real_commitments(batch, out)
        for each in commitments:
            results.append_line(COMMITMENTS, {"case": each.case, "sha256": each.digest})
        last = i + 1 == len(batches)
        ahead = None if last or _is_timed(batch) else _begun(batches[i + 1], out, makers)
        yield batch, commitments


def _begun(batch: Batch, out: Path, makers: ProcessPoolExecutor) -> list[Future[Commitment]]:
    return [
        makers.submit(make_and_commit, each, out / MADE, out / TRUTHS)
        for each in batch
        if isinstance(each, CaseSpecification)
    ]


def _real_commitments(batch: Batch, out: Path) -> list[Commitment]:
    commitments = []
    for each in batch:
        if isinstance(each, RealCase):
            name = name_of(each)
            each.write(out / MADE / name)
            commitments.append(commit(name, each.truth(), out / TRUTHS / f"{name}.json"))
    return commitments


def _is_timed(batch: Batch) -> bool:
    return any(isinstance(each, CaseSpecification) and each.tier == "speed" for each in batch)


def _batches(wanted: Sequence[Wanted], size: int) -> list[Batch]:
    """Batches: timed cases first and alone, then made cases and real ones."""
    made = [each for each in wanted if isinstance(each, CaseSpecification)]
    timed = [each for each in made if each.tier == "speed"]
    others = [each for each in made if each.tier != "speed"]
    real = [each for each in wanted if isinstance(each, RealCase)]
    return [
        *([each] for each in timed),
        *(some[i : i + size] for some in (others, real) for i in range(0, len(some), size)),
    ]
