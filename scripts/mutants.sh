#!/usr/bin/env bash
# Changes the physics, the fitness and the genetic algorithm a little, one change at a time, and says which
# changes no test notices. What is changed and which tests look stands in pyproject.toml, [tool.mutmut].
#
#     scripts/mutants.sh        all of it, for MUTANTS_MINUTES at most (default: 60)
#
# Works on a copy of the sources, in .mutants/: the working tree stays as it is. mutmut takes a module's name
# from its path, so in the copy the packages of plugins/ stand beside tacos_framework.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
copy="$root/.mutants"
bin="$root/.venv/bin"

rm -rf "$copy"
mkdir "$copy"
cd "$root"
cp -r tacos_framework plugins/tacos_* tests recipes catalogs pyproject.toml "$copy"
cd "$copy"
# Whoever starts this in the background has it ignore SIGINT; SIGKILL comes a little later.
timeout --signal=INT --kill-after=20s "${MUTANTS_MINUTES:-60}m" "$bin/mutmut" run || {
    status=$?
    [ $status -eq 124 ] || [ $status -eq 137 ] || exit $status # out of time: what was seen counts
}
"$bin/python" "$root/scripts/mutation_score.py"
