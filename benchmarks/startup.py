"""How long the commands take to start, in fresh interpreters: the best of some runs.

Beside the wall clock stands the processor time, which other work on the machine disturbs less.

``python benchmarks/startup.py``
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time

COMMANDS = {
    "python -c pass": "pass",
    "tacos-run --help": "run_main(['--help'])",
    "tacos --help": "tacos_main(['--help'])",
    "tacos plugins": "tacos_main(['plugins'])",
    "tacos-run headset_quick --check": "run_main(['headset_quick', '--check'])",
    "tacos-run headset_quick --explain": "run_main(['headset_quick', '--explain'])",
}
HEAVY = ("numpy", "torch", "networkx", "cv2", "numba")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=5)
    runs = parser.parse_args().runs
    for name, call in COMMANDS.items():
        start = "" if call == "pass" else "from tacos_framework.cli import run_main, tacos_main; "
        wall_s, processor_s = map(min, zip(*(_seconds(start + call) for _ in range(runs)), strict=True))
        heavy = ", ".join(_heavy(start + call)) or "nothing heavy"
        print(f"{name:<36} {wall_s:>6.3f} s   processor {processor_s:>6.3f} s   imports {heavy}")


def _seconds(code: str) -> tuple[float, float]:
    """Wall and processor time of a fresh interpreter [s]."""
    began, used = time.perf_counter(), os.times()
    subprocess.run([sys.executable, "-c", code], stdout=subprocess.DEVNULL, check=True)
    now = os.times()
    processor_s = now.children_user - used.children_user + now.children_system - used.children_system
    return time.perf_counter() - began, processor_s


def _heavy(code: str) -> list[str]:
    probe = f"import sys, atexit; atexit.register(lambda: print(*sys.modules, file=sys.stderr)); {code}"
    done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    modules = set(done.stderr.split())
    return [name for name in HEAVY if name in modules]


if __name__ == "__main__":
    main()
