"""Photographs among the files that were named, and files that are passed over."""

from __future__ import annotations

import os
import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path

from tacos_files.camera_images import PICTURE_SUFFIXES, RAW_SUFFIXES
from tacos_framework import Fault, UserError
from tacos_gap.captures.files import by_number
from tacos_gap.in_use.diagnosis import is_recording
from tacos_worlds.recorded.times import TIMES, read_times

_OF_SYSTEMS = frozenset({"__macosx", "@eadir", "thumbs.db", "desktop.ini"})
"""Files and folders that systems leave beside photographs, in small letters; others begin with a dot."""

_CONVERTED = {
    frozenset({".fits", ".fit", ".fts"}): "Save FITS as an array, its exposure time in the name: "
    "`from astropy.io import fits; numpy.save('dark_10ms.npy', fits.getdata('dark.fits'))`.",
    frozenset({".mp4", ".mov", ".avi", ".mkv", ".m4v"}): "Save single frames: "
    "`ffmpeg -i clip.mp4 frame_%03d.png`. Video codecs smooth noise: take stills where the camera can.",
    frozenset({".jp2", ".j2k", ".jxl", ".jxr", ".exr", ".gif", ".psd"}): "Save each as PNG or TIFF, with all "
    "its bits.",
    frozenset({".raw", ".bin"}): "Save each picture as an array of its own: "
    "`numpy.save('dark_10ms.npy', numpy.fromfile('dark.raw', '<u2').reshape(rows, columns))`.",
}
"""Files that hold pictures, by suffix, and how to get at these."""

_NAMED = 3
"""Files that are named of those passed over."""


def pictures_in(sources: Sequence[Path]) -> tuple[list[Path], list[Path], list[str]]:
    """Files of pictures, each once; other files; sentences on pictures that were passed over.

    `sources`: files and folders, searched through. What is hidden, or left there by a system, counts for
    nothing. Raises UserError when a source is not there, or all of them hold no picture.
    """
    missing = [
        Fault(str(source), "is neither a file nor a folder", "pictures, or a folder of them")
        for source in sources
        if not source.exists()
    ]
    if missing:
        raise UserError(missing)
    there = list({os.path.realpath(path): path for source in sources for path in _files_of(source)}.values())
    found = [path for path in there if path.suffix.lower() in PICTURE_SUFFIXES]
    raw = {path.with_suffix("") for path in found if path.suffix.lower() in RAW_SUFFIXES}
    kept = [p for p in found if p.suffix.lower() in RAW_SUFFIXES or p.with_suffix("") not in raw]
    if not kept:
        what = "holds no pictures" if len(sources) == 1 else "and the others hold no pictures"
        instead = f"; there is {_listed(there)}" if there else ""
        expected = "JPEG, PNG, TIFF, BMP, PGM, PPM, camera RAW or .npy"
        remedy = " ".join(remedy for _, remedy in _convertible(there))
        raise UserError(Fault(str(sources[0]), what + instead, expected, remedy))
    said = []
    if beside := len(found) - len(kept):
        those = "1 file" if beside == 1 else f"{beside} files"
        said.append(
            f"{those} beside a RAW file of the same name {'is' if beside == 1 else 'are'} passed over."
        )
    return kept, [path for path in there if path not in set(found)], said


def passed_over(others: Sequence[Path]) -> list[str]:
    """Sentences on files that are neither pictures nor tables: what to do about those that hold pictures."""
    said = []
    for those, remedy in _convertible(others):
        said.append(f"Passed over: {_listed(those)}. {remedy}")
        others = [path for path in others if path not in those]
    return [*said, f"Passed over, as no pictures that can be read: {_listed(others)}."] if others else said


def _convertible(others: Sequence[Path]) -> Iterator[tuple[list[Path], str]]:
    """Files that hold pictures all the same, and links to folders; each with how to get at them."""
    if links := [path for path in others if path.is_dir()]:
        yield links, "Links to folders are not followed: name those folders too."
    for suffixes, remedy in _CONVERTED.items():
        if those := [path for path in others if path.suffix.lower() in suffixes and path not in links]:
            yield those, remedy


def recordings_among(sources: Sequence[Path]) -> list[str]:
    """Sentences on folders that a diagnosis reads as they are: the moments of frames, which captures lack."""
    return [
        f"{source.name} is a recording: its {TIMES} says when each frame was taken, which an import does not "
        f"use. Response and motion blur are found without an import: `tacos-run diagnose --set "
        f"{shlex.quote(f'captures={source}')} --out out`."
        for source in sources
        if is_recording(source) and read_times(source / TIMES)[0]
    ]


def _files_of(source: Path) -> Iterator[Path]:
    """A file, or the files of a folder by their names, 10 after 9, and links that lead to none."""
    if not source.is_dir():
        yield source
        return
    for path in sorted(source.rglob("*"), key=by_number):
        if (path.is_file() or path.is_symlink()) and not any(
            map(_is_of_system, path.relative_to(source).parts)
        ):
            yield path


def _is_of_system(name: str) -> bool:
    return name.startswith(".") or name.lower() in _OF_SYSTEMS


def _listed(paths: Sequence[Path]) -> str:
    names = ", ".join(path.name for path in paths[:_NAMED])
    return names + (f" and {len(paths) - _NAMED} more" if len(paths) > _NAMED else "")
