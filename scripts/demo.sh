#!/usr/bin/env bash
# Runs the study of a moving headset into runs/demo, or beside an older demo into a dated folder.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

out=runs/demo
if [ -e "$out" ]; then
    out="runs/demo-$(date +%Y%m%d-%H%M%S)"
fi
.venv/bin/tacos-run headset_moving --out "$out" "$@"
printf '\nOpen the report: %s\n' "$PWD/$out/report.html"
