"""Thousands of candidates over two workers, one of which is killed again and again.

::

    LP_NUM_THREADS=1 OMP_NUM_THREADS=1 python benchmarks/soak.py --candidates 5000 --kill-every 200

The same study runs twice, once left alone and once with a worker killed (SIGKILL) every so many candidates,
and what they leave is compared. Memory, open files and processor time are those of the process that runs
the study, so that other programs change none of them. ``--recipe NAME`` takes a shipped recipe in place of
the toys.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import statistics
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tacos_framework import Evaluation, Plugins, Recipe, read_any_recipe, run
from tacos_framework.study import Silent

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))  # spawned workers import them, too

import toy_plugin
from toy_study import toy_recipe

BATCH = 20


class Watch(Silent):
    """Kills workers, and takes down memory, open files and time at every window's end."""

    def __init__(self, window: int, kill: bool) -> None:
        self.rows: list[tuple[int, float, int, float]] = []
        self.kills = 0
        self._window, self._kill, self._count, self._began_s = window, kill, 0, time.process_time()

    def evaluated(self, evaluation: Evaluation) -> None:
        """One candidate more."""
        self._count += 1
        if self._count % self._window:
            return
        now_s = time.process_time()
        spent_s, self._began_s = now_s - self._began_s, now_s
        files = len(os.listdir("/proc/self/fd"))
        self.rows.append((self._count, resident_mib(), files, 1000 * spent_s / self._window))
        workers = [child for child in multiprocessing.active_children() if child.name == "tacos-worker"]
        if self._kill and workers:
            workers[self.kills % len(workers)].kill()
            self.kills += 1


def resident_mib() -> float:
    """Memory this process holds [MiB]."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def toy_study(candidates: int) -> Recipe:
    """The study of the tests' toys, on two workers and without an end of its own."""
    data = toy_recipe(nodes={"world": {"frames": 2}}).as_data()
    return Recipe.model_validate(
        {
            **data,
            "optimizer": {"use": "optimizer.random", "evaluations": candidates, "batch": BATCH},
            "executor": {"use": "executor.process", "workers": 2},
            "test": None,
        }
    )


def shipped_recipe(name: str, candidates: int) -> Recipe:
    """A shipped recipe on small images."""
    sets: dict[str, Any] = {
        "optimizer": {"use": "optimizer.random", "evaluations": candidates, "batch": BATCH},
        "executor": {"use": "executor.process", "workers": 2},
        "rig.binning": 16,
        "nodes.world.frames": 4,
        "study.episodes": 1,
        "compare": None,
        "test": None,
    }
    recipe, faults = read_any_recipe(name, sets=sets)
    assert not faults, faults
    return Recipe.model_validate(recipe.as_data())


def soaked(recipe: Recipe, out: Path, watch: Watch) -> tuple[dict[str, Any], list[Any]]:
    """What the study leaves, but for times and the machine."""
    plugins = Plugins.discover()
    plugins.register(toy_plugin)
    result = run(recipe, out=out, plugins=plugins, progress=watch, report=False)
    lines = [json.loads(line) for line in (out / "generations.jsonl").read_text("utf-8").splitlines()]
    left = {k: v for k, v in result.items() if k not in ("seconds", "seconds_by_node", "environment")}
    return left, [{k: v for k, v in line.items() if k != "seconds"} for line in lines]


def main(arguments: Sequence[str] | None = None) -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--candidates", type=int, default=5000)
    parser.add_argument("--kill-every", type=int, default=200)
    parser.add_argument("--recipe", help="a shipped recipe, in place of the toys")
    asked = parser.parse_args(arguments)
    recipe = shipped_recipe(asked.recipe, asked.candidates) if asked.recipe else toy_study(asked.candidates)
    with tempfile.TemporaryDirectory() as folder:
        calm, shaken = Watch(asked.kill_every, kill=False), Watch(asked.kill_every, kill=True)
        alone = soaked(recipe, Path(folder) / "calm", calm)
        killed = soaked(recipe, Path(folder) / "killed", shaken)
    for name, watch in (("left alone", calm), ("workers killed", shaken)):
        print(f"{name}, {watch.kills} killed")
        print("| candidates | memory [MiB] | open files | processor time each [ms] |\n|---|---|---|---|")
        step = max(1, len(watch.rows) // 10)
        for count, memory, files, each_ms in watch.rows[::step]:
            print(f"| {count} | {memory:.0f} | {files} | {each_ms:.1f} |")
        half = len(watch.rows) // 2
        early, late = (
            statistics.median(r[3] for r in part) for part in (watch.rows[:half], watch.rows[half:])
        )
        print(f"median of the first half {early:.1f} ms, of the second {late:.1f} ms\n")
    print("same result" if alone == killed else "ANOTHER RESULT")


if __name__ == "__main__":
    main()
