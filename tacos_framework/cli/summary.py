"""The last words of ``tacos-run`` after a run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any


def summary(result: Mapping[str, Any], out: Path) -> str:
    from tacos_framework.camera.clipping import Exposed
    from tacos_framework.store import DESIGNED  # with numpy, which a faulty command does without

    if "procedure" in result:
        lines = [str(result.get("summary", "")), f"{result['seconds']:.0f} s. Results: {out}"]
        if (out / "report.html").exists():
            lines[-1] = f"{result['seconds']:.0f} s. Report: {out / 'report.html'}"
        return "\n".join(filter(None, lines))
    lines = []
    best, degenerate = result["best"], result.get("degenerate")
    if degenerate and best:
        lines.append(str(degenerate))
    elif best:
        lines.append("Designed: " + ", ".join(f"{k} {_short(v)}" for k, v in best["camera"].items()))
    tested = result["test"]
    for name in sorted(tested, key=lambda name: -(tested[name]["fitness"] or float("-inf"))):
        fitness = tested[name]["fitness"]
        lines.append(
            f"  {name:<20} fitness on unseen scenes {'failed' if fitness is None else f'{fitness:.3f}'}"
        )
    if not best:
        reason = result.get("failed", {}).get(DESIGNED, "log.txt says why")
        lines.append(f"No candidate could be scored: {reason}.")
    decision = result.get("decision")
    if isinstance(decision, Mapping) and (sentence := decision.get("sentence")) and not degenerate:
        lines.append(str(sentence))
    for name, shares in result.get("exposed", {}).items():
        if doubt := Exposed(**shares).doubt:
            lines.append(f"Sample frames of {name}: {doubt}.")
    if full := [name for name, spread in result.get("scores", {}).items() if spread["full"]]:
        lines.append(f"Scores that separate no cameras: {', '.join(full)}; the report says what to change.")
    lines.append(f"{result['frames_rendered']} images in {result['seconds']:.0f} s; {result['stopped']}.")
    lines.append(f"Report: {out / 'report.html'}" if (out / "report.html").exists() else f"Results: {out}")
    return "\n".join(lines)


def _short(value: Any) -> str:
    if isinstance(value, Mapping):
        return str(value.get("name", value))
    return f"{value:.4g}" if isinstance(value, float) else str(value)
