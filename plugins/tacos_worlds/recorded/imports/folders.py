"""Recordings that are folders: a table of times, EuRoC, TUM (also its monocular one), KITTI."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

from tacos_files.camera_images import PICTURE_SUFFIXES, read_image
from tacos_files.dates import date_ns
from tacos_framework import Fault, UserError, read_yaml
from tacos_framework.files import named_file, read_csv, read_lines, read_text
from tacos_worlds.recorded.found_response import RESPONSE
from tacos_worlds.recorded.imports.found import FoundFrame, FoundRecording
from tacos_worlds.recorded.times import TIMES, read_times

_LAYOUTS = "times.csv, data.csv of EuRoC, rgb.txt of TUM, or times.txt or timestamps.txt of KITTI"


def in_folder(folder: Path) -> FoundRecording:
    """The recording of one camera in a folder.

    Raises UserError when it has no layout that is known, holds several cameras, or its table is at fault.
    """
    cameras = sorted(
        path.parent for path in (*folder.glob("mav0/cam*/data.csv"), *folder.glob("cam*/data.csv"))
    )
    cameras += sorted(path for path in folder.glob("image_*") if path.is_dir())
    if len(cameras) > 1:
        names = ", ".join(path.name for path in cameras)
        what = f"holds {len(cameras)} cameras: {names}"
        raise UserError(Fault(str(folder), what, "one camera at a time", f"Import {cameras[0]} first."))
    here = cameras[0] if cameras else folder
    if (here / "data.csv").is_file():
        return FoundRecording("EuRoC", tuple(_euroc(here)), _euroc_camera(here))
    if (here / TIMES).is_file():
        response = read_text(here / RESPONSE) if (here / RESPONSE).is_file() else ""
        return FoundRecording("a table of times", tuple(_table(here)), response=response)
    if (here / "rgb.txt").is_file():
        return FoundRecording("TUM", tuple(_tum(here)))
    if (here / "images").is_dir() and (here / "times.txt").is_file():
        return FoundRecording("TUM, monocular", tuple(_tum_monocular(here / "images", here / "times.txt")))
    for table in (here / "timestamps.txt", here / "times.txt", here.parent / "times.txt"):
        if table.is_file():
            return FoundRecording("KITTI", tuple(_kitti(here, table)))
    raise UserError(
        Fault(
            str(folder),
            "has no table of times",
            _LAYOUTS,
            "Without times the order of the frames is unknown: write times.csv with file and taken_ns.",
        )
    )


def _frame(folder: Path, name: str, stamp_ns: int, exposure_ms: float | None, where: str) -> FoundFrame:
    path = named_file(folder, name)
    if path is None or not path.is_file():
        what, remedy = f"names {name}, which is not there", "Add the frame, or take the line out."
        raise UserError(Fault(where, what, "a frame in the folder", remedy))
    return FoundFrame(name, stamp_ns, exposure_ms, partial(read_image, path, str(path), folder))


def _euroc(camera: Path) -> Iterator[FoundFrame]:
    for number, cells in read_csv(camera / "data.csv"):
        if cells and not cells[0].startswith("#"):
            where = f"{camera / 'data.csv'}:{number}"
            if len(cells) < 2 or not cells[0].strip().isdecimal():
                raise UserError(
                    Fault(where, f"holds {','.join(cells)!r}", "a stamp in nanoseconds and a file name")
                )
            yield _frame(camera / "data", cells[1].strip(), int(cells[0]), None, where)


def _euroc_camera(camera: Path) -> str:
    file = camera / "sensor.yaml"
    if not file.is_file():
        return ""
    text = read_text(file, where=str(file))
    data = read_yaml(text.replace("%YAML:1.0", ""), str(file)).data
    keys = ("resolution", "intrinsics", "distortion_coefficients", "distortion_model")
    return text if isinstance(data, dict) and all(key in data for key in keys) else ""


def _table(folder: Path) -> Iterator[FoundFrame]:
    lines, faults = read_times(folder / TIMES)
    if faults:
        raise UserError(faults)
    for line in lines:
        yield _frame(folder, line.file, line.stamp_ns, line.exposure_ms, line.where)


def _tum(folder: Path) -> Iterator[FoundFrame]:
    for number, line in enumerate(read_lines(folder / "rgb.txt"), 1):
        if line.strip() and not line.startswith("#"):
            where = f"{folder / 'rgb.txt'}:{number}"
            try:
                stamp_s, name = line.split()[:2]
                stamp_ns = round(float(stamp_s) * 1e9)
            except ValueError as error:
                raise UserError(
                    Fault(where, f"holds {line.strip()!r}", "a stamp in seconds and a file name")
                ) from error
            yield _frame(folder, name, stamp_ns, None, where)


def _tum_monocular(images: Path, table: Path) -> Iterator[FoundFrame]:
    """Engel et al. 2016, a photometrically calibrated benchmark: number, time [s], exposure [ms]."""
    names = {Path(name).stem: name for name in _pictures(images)}
    for number, line in enumerate(read_lines(table), 1):
        if line.strip() and not line.startswith("#"):
            where = f"{table}:{number}"
            stem, *numbers = line.split()
            try:
                stamp, exposure_ms = numbers[0], float(numbers[1]) if numbers[1:] else 0.0
            except (IndexError, ValueError) as error:
                what, expected = (
                    f"holds {line.strip()!r}",
                    "number, time [s] and exposure [ms] of a frame",
                )
                raise UserError(Fault(where, what, expected)) from error
            exposed = exposure_ms if 0 < exposure_ms < float("inf") else None
            yield _frame(images, names.get(stem, stem), _stamp_ns(stamp, where), exposed, where)


def _pictures(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir() if path.suffix.lower() in PICTURE_SUFFIXES)


def _kitti(images: Path, table: Path) -> Iterator[FoundFrame]:
    folder = images / "data" if (images / "data").is_dir() else images
    names = _pictures(folder)
    lines = [line.strip() for line in read_lines(table) if line.strip()]
    if len(names) != len(lines):
        what = f"has {len(lines)} times for {len(names)} frames"
        raise UserError(
            Fault(str(table), what, "a time for each frame", "Frames were dropped: match them by hand.")
        )
    for number, (name, line) in enumerate(zip(names, lines, strict=True), 1):
        yield _frame(folder, name, _stamp_ns(line, f"{table}:{number}"), None, f"{table}:{number}")


def _stamp_ns(text: str, where: str) -> int:
    try:
        since_1970_ns = date_ns(text)
        return round(float(text) * 1e9) if since_1970_ns is None else since_1970_ns
    except (ValueError, OverflowError) as error:
        raise UserError(Fault(where, f"holds {text!r}", "seconds, or a date and a time of day")) from error
