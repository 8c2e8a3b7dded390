"""What `make mutants` found: the share of changes that tests notice, file by file, and those they do not.

cd .mutants && python ../scripts/mutation_score.py
"""

from __future__ import annotations

import subprocess
import sys
from collections import Counter, defaultdict
from pathlib import Path

NOTICED = ("killed", "timeout", "segfault")
UNNOTICED = ("survived", "no tests", "suspicious")


def main() -> None:
    """Print a table, and the names of the changes that no test notices."""
    mutmut = Path(sys.executable).with_name("mutmut")
    told = subprocess.run([mutmut, "results", "--all", "true"], check=True, capture_output=True, text=True)
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    left = []
    for line in told.stdout.splitlines():
        mutant, _, outcome = line.strip().partition(": ")
        counts[mutant.rpartition(".")[0]][outcome] += 1
        if outcome in UNNOTICED:
            left.append(f"{mutant}: {outcome}")
    print("\n".join(left))
    print("\n| File | Changes | Noticed | Not noticed | Score |\n|---|---|---|---|---|")
    for module, found in [*counts.items(), ("all", sum(counts.values(), Counter()))]:
        noticed, unnoticed = (sum(found[name] for name in names) for names in (NOTICED, UNNOTICED))
        name = module if module == "all" else f"`{module.replace('.', '/')}.py`"
        tried = noticed + unnoticed
        score = f"{100 * noticed / tried:.1f} %" if tried else ""
        print(f"| {name} | {tried} | {noticed} | {unnoticed} | {score} |")
    if skipped := sum(found["not checked"] for found in counts.values()):
        print(f"\nTime was up before {skipped} more were tried.")
    print("\nWhat a change was: cd .mutants && ../.venv/bin/mutmut show NAME")


if __name__ == "__main__":
    main()
