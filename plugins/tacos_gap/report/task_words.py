"""Effect of a gap on tasks, in sentences and rows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tacos_report.quantities import number

Found = Mapping[str, Any]


def title(name: str) -> str:
    """A score as people call it.

    >>> title("features.inlier_ratio")
    'features: inlier ratio'
    """
    return name.replace(".", ": ").replace("_", " ")


def closed(found: Found) -> float | None:
    """Share of a score's gap that the causes remove; None where noise hides that there was one."""
    before, after = (abs(found[name] - found["real"]) for name in ("sim_before", "sim_after"))
    return None if hidden(found) or before == 0 else 1 - after / before


def hidden(found: Found) -> bool:
    ci = found.get("ci")
    if not ci:
        return False
    (low, high), (least, most) = ci["real"], ci["sim_before"]
    return bool(low <= most and least <= high)


def sentence(name: str, found: Found) -> str:
    """Distance of a score from reality, and how far the causes bring it.

    >>> ci = {"real": [165, 177], "sim_before": [220, 228], "sim_after": [170, 182]}
    >>> found = {"real": 171, "sim_before": 224, "sim_after": 176, "ci": ci}
    >>> sentence("features.inliers", found)
    'Features: inliers: 171 on real frames, 224 simulated, 176 with the causes: 91 % of the gap is gone.'
    """
    real, before, after = (number(found[key]) for key in ("real", "sim_before", "sim_after"))
    text = title(name)
    text = f"{text[:1].upper()}{text[1:]}: {real} on real frames, {before} simulated, {after} with the causes"
    share = closed(found)
    if share is None:
        return f"{text}; real and simulated frames differ by no more than noise."
    if share <= 0:
        return f"{text}: the causes do not bring it nearer."
    return f"{text}: {round(100 * share)} % of the gap is gone."


def rows(task: Mapping[str, Found]) -> tuple[tuple[str, ...], ...]:
    """Each score on real frames, on simulated ones and with the causes, with its 90 % interval."""
    return tuple(
        (title(name), *(_shown(found, key) for key in ("real", "sim_before", "sim_after")))
        for name, found in task.items()
    )


def _shown(found: Found, key: str) -> str:
    ci = found.get("ci")
    value = number(found[key])
    return value if not ci else f"{value} ({number(ci[key][0])} to {number(ci[key][1])})"
