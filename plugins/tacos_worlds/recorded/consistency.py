"""Faults of a recording that single frames do not show: steps of time, exposures beside one another."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Fault
from tacos_worlds.recorded.recording import ExposedFrames
from tacos_worlds.recorded.response import Response

_LARGEST_MISMATCH = 0.15
"""Exposures whose light per time differs by more do not belong to one scene and one response [1]."""
_OVEREXPOSED = 0.5
"""Share of clipped samples from which a frame shows nothing that can be replayed [1]."""


def faults_of_stamps(table: Path, files: Sequence[str], stamps_ns: Sequence[int]) -> list[Fault]:
    """Frames that were dropped or doubled, by the steps between stamps of one exposure.

    Where a third of the steps are at fault it is one fault: the frames are of several cameras, or triggered.
    """
    steps = np.diff(stamps_ns)
    usual = float(np.median(steps[steps > 0])) if np.any(steps > 0) else 0.0
    found = []
    for first, second, step in zip(files, files[1:], steps, strict=False):
        where = f"{table}: {second}"
        if step == 0 or step < 0.5 * usual:
            found.append(
                Fault(
                    where,
                    f"was taken {step * 1e-6:.1f} ms after {first}",
                    f"about {usual * 1e-6:.1f} ms: the frame is doubled",
                    "Take one of the two out.",
                )
            )
        elif step > 1.5 * usual:
            found.append(
                Fault(
                    where,
                    f"was taken {step * 1e-6:.1f} ms after {first}",
                    f"about {usual * 1e-6:.1f} ms: frames were dropped between them "
                    f"({round(step / usual) - 1})",
                    "Cut the recording there, and replay the longer part.",
                )
            )
    if len(found) < 3 or len(found) < len(steps) / 3:
        return found
    least, most = steps.min() * 1e-6, steps.max() * 1e-6
    return [
        Fault(
            f"{table}: {files[0]} and {len(files) - 1} more of its exposure",
            f"were taken at uneven steps, from {least:.3g} to {most:.3g} ms",
            "even steps, as one camera takes them",
            "If two cameras are under one name, keep the frames of one.",
        )
    ]


def overexposed(path: Path, frames: ExposedFrames, clipping_dn: NDArray[np.int64]) -> Fault | None:
    height, width = frames.codes_dn.shape[1:]
    limit = np.tile(clipping_dn, (height // 2 + 1, width // 2 + 1))[:height, :width]
    shares = np.mean(frames.codes_dn >= limit, axis=(1, 2))
    if shares.min() < _OVEREXPOSED:
        return None
    return Fault(
        f"{path}: {frames.name} ms",
        f"is overexposed throughout: {shares.min():.0%} or more of each frame is at its top",
        f"less than {_OVEREXPOSED:.0%}",
        "Take its frames and their lines out.",
    )


def faults_of_brightness(
    path: Path, fit: Mapping[str, ExposedFrames], response: Response, bits: int
) -> Iterator[tuple[Fault, float]]:
    """Exposures whose light is not in proportion to their time, beside the median of all."""
    usable_dn = 0.02 * ((1 << bits) - 1), 0.9 * ((1 << bits) - 1)
    quantiles = np.linspace(0.05, 0.95, 37)
    rates: dict[str, NDArray[np.float64]] = {}
    for name, each in fit.items():
        light = np.quantile(response.light(each.codes_dn), quantiles)
        rates[name] = (
            np.where((light > usable_dn[0]) & (light < usable_dn[1]), light, np.nan) / each.exposure_ms
        )
    if len(rates) < 3:
        return
    stack = np.stack(list(rates.values()))
    known = np.isfinite(stack).sum(0) >= 3
    if not known.any():
        return
    usual = np.nanmedian(stack[:, known], axis=0)
    for name, rate in rates.items():
        ratios = rate[known] / usual
        if not np.isfinite(ratios).any():
            continue
        ratio = float(np.nanmedian(ratios))
        if abs(ratio - 1) > _LARGEST_MISMATCH:
            yield (
                Fault(
                    f"{path}: {name} ms",
                    f"is {ratio:.2f} times as bright for its time as the other exposures",
                    f"1 within {_LARGEST_MISMATCH:.0%}: exposures that match the brightness",
                    "Correct the exposure in the names of its files, or take them out.",
                ),
                fit[name].exposure_ms,
            )


def together(faults: Sequence[Fault]) -> list[Fault]:
    """One fault for files that have the same."""
    alike: dict[tuple[str, str], list[Fault]] = {}
    for each in faults:
        alike.setdefault((each.what.replace(Path(each.where).name, ""), each.expected), []).append(each)
    return [
        first if not more else replace(first, where=f"{first.where} and {len(more)} more of this exposure")
        for first, *more in alike.values()
    ]
