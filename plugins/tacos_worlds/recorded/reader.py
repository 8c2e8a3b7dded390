"""Reads a folder of frames with ``times.csv``, and names all of its faults at once."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tacos_files.camera_images import read_frame, usual_bit_depth
from tacos_framework import Fault, UserError
from tacos_framework.files import read_csv, read_text
from tacos_worlds.recorded.recording import ExposedFrames, Recording, green_on_diagonal
from tacos_worlds.recorded.response import Response, estimated_response, linear_response, tabled_response

ResponseFrom = Literal["recorded", "linear", "estimated"]

TIMES = "times.csv"
RESPONSE = "response.txt"
_NAME = re.compile(r"(?P<ms>\d+(?:[._]\d+)?)ms_(?P<index>\d+)\.(?:png|tif|tiff)$", re.IGNORECASE)
_LARGEST_MISMATCH = 0.15
"""Exposures whose light per time differs by more do not belong to one scene and one response [1]."""
_OVEREXPOSED = 0.5
"""Share of samples at the top code from which a frame shows nothing that can be replayed [1]."""


@dataclass(frozen=True)
class _Entry:
    file: str
    exposure_ms: float
    stamp_ns: int


def read_recording(folder: str | Path, *, fewest: int = 2, response: ResponseFrom = "recorded") -> Recording:
    """The frames of a folder, by exposure.

    - `response`: ``linear`` where samples are in proportion to light, as those of raw files are;
      ``estimated`` from the exposures even where the folder states one.

    Raises UserError with a fault for each thing that is wrong, and which exposures have none.
    """
    path = Path(folder)
    faults: list[Fault] = []
    entries = _entries(path, faults)
    found: dict[str, ExposedFrames] = {}
    bad: set[float] = set()
    start_ns = min((entry.stamp_ns for entry in entries), default=0)
    common: tuple[int, ...] | None = None
    for exposure_ms in sorted({entry.exposure_ms for entry in entries}):
        own = sorted((e for e in entries if e.exposure_ms == exposure_ms), key=lambda e: e.stamp_ns)
        here = list(_faults_of_stamps(path, own))
        images, seen = [], dict[str, str]()
        for entry in own:
            try:
                image = read_frame(path / entry.file, str(path / entry.file), path)
            except UserError as error:
                here += error.faults
                continue
            if image.shape[-1] != 1:
                here.append(
                    Fault(
                        str(path / entry.file),
                        "has colours: demosaicing has mixed neighbours",
                        "raw samples, one per pixel",
                    )
                )
                continue
            image = image[..., 0]
            common = common or image.shape
            if image.shape != common:
                here.append(
                    Fault(
                        str(path / entry.file),
                        f"is {image.shape[1]} x {image.shape[0]} px",
                        f"{common[1]} x {common[0]} px, as the first frame",
                        "Leave the frame out, or record with one size.",
                    )
                )
                continue
            digest = hashlib.sha256(image.tobytes()).hexdigest()
            if digest in seen:
                here.append(
                    Fault(
                        str(path / entry.file),
                        f"holds the very samples of {seen[digest]}",
                        "a frame of its own: it is doubled",
                    )
                )
            seen.setdefault(digest, entry.file)
            images.append(image.astype(np.uint16))
        if len(own) < 2:
            here.append(
                Fault(
                    f"{path}: {exposure_ms:g} ms",
                    "has one frame",
                    "two or more, as consecutive frames are compared",
                )
            )
        if here:
            bad.add(exposure_ms)
            faults += here
        if len(images) == len(own):
            stamp_s = np.array([(e.stamp_ns - start_ns) * 1e-9 for e in own])
            found[f"{exposure_ms:g}"] = ExposedFrames(exposure_ms, stamp_s, np.stack(images))
    bits = usual_bit_depth(max((int(each.codes_dn.max()) for each in found.values()), default=0))
    for each in found.values():
        if over := _overexposed(path, each, bits):
            faults.append(over)
            bad.add(each.exposure_ms)
    fit = {name: each for name, each in found.items() if each.exposure_ms not in bad}
    found_response: Response | None
    if response == "linear":
        found_response, origin = linear_response((1 << bits) - 1), "The samples are taken to be linear."
    else:
        found_response, origin = _response(path, fit, bits, faults, told=response == "recorded")
    if found_response is not None:
        for fault, exposure_ms in _brightness(path, fit, found_response, bits):
            faults.append(fault)
            bad.add(exposure_ms)
    if entries and len(found) < fewest and not faults:
        faults.append(
            Fault(str(path), "holds one exposure", "two or more, so that one can be replayed as another")
        )
    if faults or found_response is None:
        usable = [each.name for each in found.values() if each.exposure_ms not in bad]
        words = f"Still usable: {', '.join(usable)} ms." if usable else "Nothing of it is usable as it is."
        last = faults[-1]
        faults[-1] = Fault(last.where, last.what, last.expected, f"{last.remedy} {words}".strip())
        raise UserError(faults)
    shown = max(found.values(), key=lambda each: float(np.median(each.codes_dn)))
    return Recording(found, bits, found_response, origin, green_on_diagonal(shown.codes_dn[:2]))


def _entries(path: Path, faults: list[Fault]) -> list[_Entry]:
    if not path.is_dir():
        faults.append(Fault(str(path), "there is no such folder", f"a folder of frames with {TIMES}"))
        return []
    pictures = sorted(each.name for each in path.iterdir() if _NAME.search(each.name))
    table = path / TIMES
    if not table.is_file():
        faults.append(
            Fault(
                str(table),
                f"there is no such file beside {len(pictures)} frames",
                "a table with the columns file and taken_ns",
                "Without times the order and the motion of the frames are unknown: write the stamps "
                "of the camera's driver.",
            )
        )
        return []
    entries = []
    (_, heading), *lines = read_csv(table) or [(1, [])]
    if not {"file", "taken_ns"} <= set(heading):
        faults.append(Fault(f"{table}:1", f"has the columns {', '.join(heading)}", "file and taken_ns"))
        return []
    for line, cells in lines:
        row = dict(zip(heading, cells, strict=False))
        name, stamp = row.get("file", ""), row.get("taken_ns", "")
        exposure_ms = _exposure_ms(name, row.get("exposure_ms", ""))
        if exposure_ms is None:
            faults.append(
                Fault(
                    f"{table}:{line}",
                    f"names {name!r} without its exposure",
                    "NNms_K.png, or a column exposure_ms",
                    "Without exposures light is unknown: state them, as the camera's driver does.",
                )
            )
        elif not re.fullmatch(r"\d{1,19}", stamp):
            faults.append(
                Fault(f"{table}:{line}", f"has taken_ns {stamp!r}", "a whole number of nanoseconds")
            )
        elif not (path / name).is_file():
            faults.append(
                Fault(
                    f"{table}:{line}",
                    f"names {name}, which is not there",
                    "a frame in the folder",
                    "Add the frame, or take the line out.",
                )
            )
        elif exposure_ms <= 0:
            faults.append(Fault(f"{table}:{line}", f"names {name}, of no exposure time", "more than 0 ms"))
        else:
            entries.append(_Entry(name, exposure_ms, int(stamp)))
    missing = sorted(set(pictures) - {entry.file for entry in entries})
    if missing and entries:
        faults.append(Fault(str(table), f"has no line for {', '.join(missing)}", "a line for each frame"))
    return entries


def _exposure_ms(name: str, stated: str) -> float | None:
    """Exposure of a frame by the table, else by its name; None where neither tells [ms]."""
    try:
        return float(stated)
    except ValueError:
        named = _NAME.fullmatch(name)
        return float(named["ms"].replace("_", ".")) if named else None


def _faults_of_stamps(path: Path, own: list[_Entry]) -> Iterator[Fault]:
    """Frames that were dropped or doubled, by the steps between stamps of one exposure."""
    steps = np.diff([entry.stamp_ns for entry in own])
    usual = float(np.median(steps[steps > 0])) if np.any(steps > 0) else 0.0
    for first, second, step in zip(own, own[1:], steps, strict=False):
        where = f"{path / TIMES}: {second.file}"
        if step == 0 or step < 0.5 * usual:
            yield Fault(
                where,
                f"was taken {step * 1e-6:.1f} ms after {first.file}",
                f"about {usual * 1e-6:.1f} ms: the frame is doubled",
                "Take one of the two out.",
            )
        elif step > 1.5 * usual:
            yield Fault(
                where,
                f"was taken {step * 1e-6:.1f} ms after {first.file}",
                f"about {usual * 1e-6:.1f} ms: frames were dropped between them ({round(step / usual) - 1})",
                "Cut the recording there, and replay the longer part.",
            )


def _overexposed(path: Path, frames: ExposedFrames, bits: int) -> Fault | None:
    shares = np.mean(frames.codes_dn >= 0.995 * ((1 << bits) - 1), axis=(1, 2))
    if shares.min() < _OVEREXPOSED:
        return None
    return Fault(
        f"{path}: {frames.name} ms",
        f"is overexposed throughout: {shares.min():.0%} or more of each frame is at its top",
        f"less than {_OVEREXPOSED:.0%}",
        "Take its frames and their lines out.",
    )


def _response(
    path: Path, fit: dict[str, ExposedFrames], bits: int, faults: list[Fault], *, told: bool
) -> tuple[Response | None, str]:
    file, white_dn = path / RESPONSE, (1 << bits) - 1
    if told and file.is_file():
        try:
            values = np.array(read_text(file).split(), np.float64)
            return tabled_response(values, white_dn), f"The response is that of {RESPONSE}."
        except ValueError as error:
            faults.append(
                Fault(
                    str(file),
                    f"holds no response: {error}",
                    "numbers of 0..255 that rise",
                    "Take it out to have the response estimated.",
                )
            )
            return None, ""
    if len(fit) < 2:
        if not faults:
            faults.append(
                Fault(
                    str(path),
                    f"has no {RESPONSE} and one exposure",
                    "one of the two, to know the response",
                    "Say so where samples are linear.",
                )
            )
        return None, ""
    brightness = [float(np.median(each.codes_dn)) for each in fit.values()]
    names = list(fit)
    fell = [i for i in range(1, len(names)) if brightness[i] < brightness[i - 1]]
    for i in fell:
        faults.append(
            Fault(
                f"{path}: {names[i]} ms",
                f"is darker (median code {brightness[i]:.0f}) than {names[i - 1]} ms "
                f"({brightness[i - 1]:.0f})",
                "exposures that match the brightness",
                "Correct the exposures in the names of the files.",
            )
        )
    if fell:
        return None, ""
    stacks = {each.exposure_ms: each.codes_dn for each in fit.values()}
    said = "The response was estimated from the exposures themselves."
    return estimated_response(stacks, white_dn), said


def _brightness(
    path: Path, fit: dict[str, ExposedFrames], response: Response, bits: int
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
