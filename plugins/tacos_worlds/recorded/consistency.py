"""Faults of a recording that single frames do not show: steps of time, exposures beside one another."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tacos_files.camera_images import roughness
from tacos_framework import Fault
from tacos_worlds.recorded.recording import ExposedFrames
from tacos_worlds.recorded.response import Response

_LARGEST_MISMATCH = 0.15
"""Exposures whose light per time differs by more do not belong to one scene and one response [1]."""
_OVEREXPOSED = 0.5
"""Share of clipped samples from which a frame shows nothing that can be replayed [1]."""
_NUMBERED = re.compile(r"(.*?)(\d+)")
_MOST_FALLS = 0.25
"""Share of numbers that fall from frame to frame from which on names have no order [1]."""
_ROUGHER = 2.0
"""Roughness of files as they are over that with their bytes exchanged, from which on they are so by fault."""
_MAINS_WAVES_HZ = (100.0, 120.0)
_PARTS, _FEWEST_VIEWS = 12, 4
_ALIKE, _APART = 0.6, 0.3
"""Correlation from which views are alike, and by how much that of the next frame must be less [1]."""

_MOSTLY_BORNE_OUT = 0.3
"""Share of the codes that a response must hold for, so that wrong exposures would show in them."""


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


def out_of_order(table: Path, files: Sequence[str]) -> list[Fault]:
    """Frames whose numbers do not rise with their stamps, where those of most do.

    A count that begins again, after the last number or for another take, is no such fault.

    `files`: names of the frames of one exposure, in the order of their stamps.
    """
    counted = [_NUMBERED.fullmatch(Path(file).stem) for file in files]
    numbers = [int(each[2]) for each in counted if each]
    if len(numbers) < len(files) or len({each[1] for each in counted if each}) > 1:
        return []
    falls = [
        k
        for k in range(1, len(numbers))
        if numbers[k] < numbers[k - 1]
        and (max(numbers[k:]) > numbers[k - 1] or (k > 1 and numbers[k] > numbers[k - 2]))
    ]
    if len(falls) > _MOST_FALLS * len(numbers):
        return []
    return [
        Fault(
            f"{table}: {files[k]}",
            f"was taken after {files[k - 1]}, by its stamp",
            "stamps that rise with the numbers of the files",
            "Look whether times or names were mixed up.",
        )
        for k in falls
    ]


def bytes_exchanged(path: Path, found: Mapping[str, ExposedFrames]) -> Fault | None:
    """The fault of files that are far smoother with the two bytes of each sample exchanged."""
    orders = [
        tuple(roughness(each) for each in (middle, middle.byteswap()))
        for middle in (each.codes_dn[len(each.codes_dn) // 2] for each in found.values())
    ]
    is_rougher = any(stored > _ROUGHER * exchanged for stored, exchanged in orders)
    if not is_rougher or any(exchanged > _ROUGHER * stored for stored, exchanged in orders):
        return None
    return Fault(
        str(path),
        "neighbouring pixels differ at random, and as little as in any picture once the two bytes of each "
        "sample are exchanged",
        "samples in the byte order of their format",
        "Save the frames anew with the bytes exchanged (numpy: frame.byteswap()).",
    )


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
    path: Path,
    fit: Mapping[str, ExposedFrames],
    response: Response,
    bits: int,
    trusted_dn: int | None = None,
) -> Iterator[tuple[Fault, float]]:
    """Exposures whose light is not in proportion to their time, beside the median of all.

    `trusted_dn`: code from which on exposures contradict the response. A wrong exposure is a factor at all
    codes; where they agree on the lower part, it is the response that is wrong above.
    """
    white_dn = (1 << bits) - 1
    usable_dn = 0.02 * white_dn, 0.9 * white_dn
    if trusted_dn is not None and trusted_dn > _MOSTLY_BORNE_OUT * white_dn:
        usable_dn = usable_dn[0], min(usable_dn[1], float(response.light(np.array([trusted_dn]))[0]))
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
        ratio, exposure_ms = float(np.nanmedian(ratios)), fit[name].exposure_ms
        if abs(ratio - 1) > _LARGEST_MISMATCH:
            yield (
                Fault(
                    f"{path}: {name} ms",
                    f"is {ratio:.2f} times as bright for its time as the other exposures",
                    f"1 within {_LARGEST_MISMATCH:.0%}: exposures that match the brightness",
                    "Correct the exposure in the names of its files, or take them out."
                    + by_lamp(exposure_ms, abs(ratio - 1)),
                ),
                exposure_ms,
            )


def by_lamp(exposure_ms: float, share: float) -> str:
    """The remedy where a lamp on mains may change the light of an exposure by a share; else nothing.

    Its brightness is a wave of 100 or 120 Hz, of which an exposure takes the mean: at most the sinc of both.
    """
    most = float(np.max(np.abs(np.sinc(np.array(_MAINS_WAVES_HZ) * exposure_ms * 1e-3))))
    if share > most:
        return ""
    return (
        " If they are right, a lamp on mains flickers: so short an exposure catches a part of its wave. "
        "Record by daylight or a lamp on direct current, or at multiples of 10 ms (50 Hz) or 8.33 ms (60 Hz)."
    )


def alternating(path: Path, frames: ExposedFrames) -> Fault | None:
    """Two cameras whose frames alternate under one name: each is like the next but one, not like the next."""
    views = np.stack([_small(codes) for codes in frames.codes_dn])
    if len(views) < _FEWEST_VIEWS:
        return None
    next_one, next_but_one = (float(np.median(np.sum(views[n:] * views[:-n], axis=1))) for n in (1, 2))
    if next_but_one < _ALIKE or next_one > next_but_one - _APART:
        return None
    return Fault(
        f"{path}: {frames.name} ms",
        f"shows two views in turn: frames correlate by {next_but_one:.2f} with the next but one, and by "
        f"{next_one:.2f} with the next",
        "frames of one camera",
        "Two cameras are under one name: keep the frames of one.",
    )


def _small(codes_dn: NDArray[np.uint16]) -> NDArray[np.float64]:
    """Means of 12 x 12 parts of a frame, of mean 0 and length 1."""
    parts = [np.array_split(rows, _PARTS, axis=1) for rows in np.array_split(codes_dn, _PARTS)]
    means = np.array([float(part.mean()) for row in parts for part in row if part.size])
    means -= means.mean()
    return np.asarray(means / max(float(np.linalg.norm(means)), 1e-9))


def together(faults: Sequence[Fault]) -> list[Fault]:
    """One fault for files that have the same."""
    alike: dict[tuple[str, str], list[Fault]] = {}
    for each in faults:
        alike.setdefault((each.what.replace(Path(each.where).name, ""), each.expected), []).append(each)
    return [
        first if not more else replace(first, where=f"{first.where} and {len(more)} more of this exposure")
        for first, *more in alike.values()
    ]
