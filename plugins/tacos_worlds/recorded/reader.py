"""Reads a folder of frames with ``times.csv``, and names all of its faults at once."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tacos_files.camera_images import PICTURE_SUFFIXES, has_one_value, read_frame, usual_bit_depth
from tacos_framework import Fault, UserError
from tacos_framework.files import named_file
from tacos_worlds.recorded.consistency import (
    alternating,
    bytes_exchanged,
    faults_of_brightness,
    faults_of_stamps,
    out_of_order,
    overexposed,
    together,
)
from tacos_worlds.recorded.found_response import ResponseFrom, response_of
from tacos_worlds.recorded.recording import ExposedFrames, Recording, green_on_diagonal
from tacos_worlds.recorded.saturation import clipping_codes
from tacos_worlds.recorded.times import TIMES, named_ms, read_times


@dataclass(frozen=True)
class _Entry:
    file: str
    exposure_ms: float
    stamp_ns: int


def read_recording(
    folder: str | Path,
    *,
    fewest: int = 2,
    response: ResponseFrom = "recorded",
    bit_depth: int | None = None,
) -> Recording:
    """The frames of a folder, by exposure. Samples at the top of 16 bits are shifted down.

    - `response`: ``linear`` where samples are in proportion to light, as those of raw files are;
      ``estimated`` from the exposures even where the folder states one.
    - `bit_depth`: of a sample; None takes what the samples reach.

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
        here = faults_of_stamps(path / TIMES, [e.file for e in own], [e.stamp_ns for e in own])
        here += out_of_order(path / TIMES, [e.file for e in own])
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
            if digest in seen and not has_one_value(image):
                here.append(
                    Fault(
                        str(path / entry.file),
                        f"holds the very samples of {seen[digest]}",
                        "a frame of its own: it is doubled",
                        "Take one of the two out.",
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
            faults += together(here)
        if len(images) == len(own):
            stamp_s = np.array([(e.stamp_ns - start_ns) * 1e-9 for e in own])
            found[f"{exposure_ms:g}"] = ExposedFrames(exposure_ms, stamp_s, np.stack(images))
    if exchanged := bytes_exchanged(path, found):
        raise UserError([*faults, exchanged])
    found, bits = _at_depth(path, found, bit_depth, faults)
    clipping_dn = np.zeros((2, 2), np.int64)
    fit: dict[str, ExposedFrames] = {}  # those whose brightness tells of the response, at whatever times
    if found:
        clipping_dn = clipping_codes([*found.values()][-1].codes_dn, (1 << bits) - 1)
        for name, each in found.items():
            if over := overexposed(path, each, clipping_dn):
                faults.append(over)
                bad.add(each.exposure_ms)
                continue
            fit[name] = each
            if of_two := alternating(path, each):
                faults.append(of_two)
                bad.add(each.exposure_ms)
    told = response_of(path, fit, bits, clipping_dn, response, faults, bad)
    if told is not None:
        stated = told.contradicted or told.response  # a mended one agrees with wrong exposures, too
        for fault, exposure_ms in faults_of_brightness(path, fit, stated, bits, told.trusted_dn):
            faults.append(fault)
            bad.add(exposure_ms)
    if entries and len(found) < fewest and not faults:
        faults.append(
            Fault(str(path), "holds one exposure", "two or more, so that one can be replayed as another")
        )
    if faults or told is None:
        usable = [each.name for each in found.values() if each.exposure_ms not in bad]
        words = f"Still usable: {', '.join(usable)} ms." if usable else "Nothing of it is usable as it is."
        last = faults[-1]
        faults[-1] = Fault(last.where, last.what, last.expected, f"{last.remedy} {words}".strip())
        raise UserError(faults)
    shown = max(found.values(), key=lambda each: float(np.median(each.codes_dn)))
    diagonal = green_on_diagonal(shown.codes_dn[:2])
    return Recording(found, bits, told.response, told.origin, clipping_dn, told.contradicted, diagonal)


def _entries(path: Path, faults: list[Fault]) -> list[_Entry]:
    if not path.is_dir():
        faults.append(Fault(str(path), "there is no such folder", f"a folder of frames with {TIMES}"))
        return []
    pictures = sorted(
        name
        for each in path.rglob("*")
        if each.suffix.lower() in PICTURE_SUFFIXES
        and named_ms(name := each.relative_to(path).as_posix()) is not None
    )
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
    lines, unread = read_times(table)
    faults += unread
    entries, listed = [], set()
    for line in lines:
        there = named_file(path, line.file)
        name = os.path.relpath(there, path) if there else line.file
        listed.add(name)
        if line.exposure_ms is None:
            faults.append(
                Fault(
                    line.where,
                    f"names {line.file!r} without its exposure",
                    "NNms_K.png, NNms/K.png, or a column exposure_ms",
                    "Without exposures light is unknown: state them, as the camera's driver does.",
                )
            )
        elif there is None or not there.is_file():
            faults.append(
                Fault(
                    line.where,
                    f"names {line.file}, which is not there",
                    "a frame in the folder",
                    "Add the frame, or take the line out.",
                )
            )
        else:
            entries.append(_Entry(name, line.exposure_ms, line.stamp_ns))
    missing = sorted(set(pictures) - listed)
    if missing and lines:
        faults.append(Fault(str(table), f"has no line for {', '.join(missing)}", "a line for each frame"))
    return entries


def _at_depth(
    path: Path, found: dict[str, ExposedFrames], stated: int | None, faults: list[Fault]
) -> tuple[dict[str, ExposedFrames], int]:
    """Frames whose samples count in steps of one, and their bits."""
    used = 0
    for each in found.values():
        used |= int(np.bitwise_or.reduce(each.codes_dn, axis=None))
    shift = (used & -used).bit_length() - 1 if used >= 256 else 0
    bits = stated or usual_bit_depth(used >> shift)
    if used >> shift >= 1 << bits:
        faults.append(Fault(str(path), f"has samples beyond {bits} bits", "bit_depth as the camera has it"))
    if not shift:
        return found, bits
    return {
        name: replace(each, codes_dn=each.codes_dn >> np.uint16(shift)) for name, each in found.items()
    }, bits
