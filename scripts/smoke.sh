#!/usr/bin/env bash
# Runs a part of the tests, and a small study, with other versions than those of .venv:
#
#     scripts/smoke.sh lowest-direct python3.11     the lowest versions pyproject.toml allows
#     scripts/smoke.sh highest python3.13           the newest, on another Python
#
# The environment, .venv-smoke-RESOLUTION-PYTHON, is kept; tests of extras that are not in it are skipped. What
# the lowest versions warn of is known to whoever made the newer ones, so warnings are no errors here.
set -euo pipefail

resolution="$1"
python="$2"
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
venv="$root/.venv-smoke-$resolution-$python"
cd "$root"

"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null ||
    { echo "[smoke] $python is not installed, or older than 3.11"; exit 1; }
[ -x "$venv/bin/uv" ] || { "$python" -m venv --clear "$venv" && "$venv/bin/python" -m pip install --quiet uv; }
echo "[smoke] $("$python" --version), $resolution versions"
VIRTUAL_ENV="$venv" "$venv/bin/uv" pip install --quiet --resolution "$resolution" \
    --editable '.[testing,optuna,fronts,frames,raw,export]' --editable plugins/tacos_validation \
    'hypothesis>=6.100' 'jsonschema>=4.20' 'colour-science>=0.4.6'

export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 LP_NUM_THREADS=1
"$venv/bin/python" -m pytest -q -o filterwarnings=default -p no:cacheprovider \
    tests/camera tests/variables tests/formation tests/recipe tests/renderers/test_light.py tests/rigs \
    tests/sensors tests/optimizers/test_genetic.py tests/optimizers/test_cma_es.py tests/worlds/test_user_models.py \
    tests/worlds/imported
out="$(mktemp -d)"
trap 'rm -rf "$out"' EXIT
"$venv/bin/tacos-run" headset_quick --quiet --out "$out/run" --set rig.binning=16 --set executor.workers=1 \
    --set optimizer.evaluations=8 --set study.episodes=1 --set study.finalists=1 --set compare=null --set test=null
echo "[smoke] passed"
