"""Thousands of damaged files for a reader, in a process with limits; run by hand.

``python -m tests.fuzz.campaign --inputs 10000 [READER ...]`` prints a line for each reader: how many inputs
gave a value, how many were refused, and how many were defects (another exception than `UserError`, more than
10 s of processor time, more than 1 GiB, no end), which are written to ``crashes/``. The draws depend on the
seed alone.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import random
import resource
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from multiprocessing.connection import Connection
from pathlib import Path

from tacos_framework.errors import UserError
from tests.fuzz.mutations import damaged
from tests.fuzz.reader import read_or_refuse
from tests.fuzz.readers import READERS

LIMIT_S = 10.0
"""Of processor time, which a busy machine does not change."""

HANG_S = 100.0
"""After so long by the clock, a reader waits for what never comes."""

LIMIT_BYTES = 2**30
_FENCE_BYTES = 6 * 2**30
"""Address space beyond which allocations fail, so that a defect does not take the machine along."""


def mutant(name: str, seed: int, number: int) -> bytes:
    """The damaged file of a number."""
    reader, draw = READERS[name], random.Random(f"{name} {seed} {number}")
    return damaged(reader.example(), draw, structure=reader.structure)


def attempt(name: str, content: bytes, folder: Path) -> str:
    """How a reader takes a file: it gives a ``value``, or ``refused`` it; any defect raises."""
    return "refused" if isinstance(read_or_refuse(READERS[name], content, folder), UserError) else "value"


def _run(name: str, seed: int, start: int, stop: int, pipe: Connection) -> None:
    resource.setrlimit(resource.RLIMIT_AS, (_FENCE_BYTES, _FENCE_BYTES))
    warnings.simplefilter("ignore")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # what decoders in C say of each file
    with tempfile.TemporaryDirectory() as folder:
        before = 0
        for number in range(start, stop):
            pipe.send((number, "begun", ""))
            began_s = time.process_time()
            try:
                outcome, why = attempt(name, mutant(name, seed, number), Path(folder)), ""
            except Exception:  # noqa: BLE001 - what is looked for
                outcome, why = "traceback", traceback.format_exc(limit=-3)
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
            before = before or peak
            if peak - before > LIMIT_BYTES:
                outcome, why, before = "memory", f"{(peak - before) / 2**30:.1f} GiB", peak
            if (spent_s := time.process_time() - began_s) > LIMIT_S:
                outcome, why = "slow", f"{spent_s:.0f} s"
            pipe.send((number, outcome, why))


def campaign(name: str, seed: int, inputs: int, crashes: Path) -> Counter[str]:
    """How many inputs ended how; what broke the reader is kept."""
    spawned = multiprocessing.get_context("spawn")
    counts: Counter[str] = Counter()
    number = 0
    while number < inputs:
        here, there = spawned.Pipe()
        child = spawned.Process(target=_run, args=(name, seed, number, inputs, there), daemon=True)
        child.start()
        there.close()
        begun = False
        try:
            while number < inputs:
                if not here.poll(HANG_S if begun else 4 * HANG_S):  # it imports the readers first
                    outcome, why = "hangs", f"over {HANG_S} s by the clock"
                else:
                    _, outcome, why = here.recv()
                if outcome == "begun":
                    begun = True
                    continue
                counts[outcome] += 1
                if outcome not in ("value", "refused"):
                    _keep(crashes, name, seed, number, outcome, why)
                number += 1
                if outcome == "hangs":
                    break
        except EOFError:
            counts["died"] += 1
            _keep(crashes, name, seed, number, "died", "")
            number += 1
        child.kill()
        child.join()
    return counts


def _keep(crashes: Path, name: str, seed: int, number: int, outcome: str, why: str) -> None:
    crashes.mkdir(exist_ok=True)
    (crashes / f"{name}-{number}-{outcome}").write_bytes(mutant(name, seed, number))
    print(f"{name} {number}: {outcome}: {why}", file=sys.stderr)


def main() -> None:
    """Run the readers named, or all of them."""
    parser = argparse.ArgumentParser()
    parser.add_argument("readers", nargs="*", default=list(READERS), metavar="READER")
    parser.add_argument("--inputs", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--crashes", type=Path, default=Path("crashes"))
    given = parser.parse_args()
    for name in given.readers:
        began = time.monotonic()
        inputs = round(given.inputs * READERS[name].share)
        counts = campaign(name, given.seed, inputs, given.crashes)
        told = ", ".join(f"{count} {outcome}" for outcome, count in sorted(counts.items()))
        print(f"{name}: {told}; {time.monotonic() - began:.0f} s", flush=True)


if __name__ == "__main__":
    main()
