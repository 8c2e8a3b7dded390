"""The files a capture names, each with what is wrong with it."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_files.camera_images import check_bit_depth, read_array, read_image
from tacos_files.jpeg_coding import jpeg_coding
from tacos_framework import Document, Fault, FileCoding, UserError
from tacos_framework.files import limits, read_rows, too_large

MAX_FRAMES = 6
"""Frames of one capture that are used; more add little and cost time."""

PATCH_COLUMNS = ("x", "y", "width", "height", "r", "g", "b")
"""Columns of a chart's table besides ``id``."""


class CaptureFiles:
    """Reads the files of captures and keeps every fault."""

    def __init__(self, folder: Path, document: Document, channels: int, bit_depth: int = 8):
        self.folder = folder
        self.channels, self.bit_depth = channels, bit_depth
        self.faults: list[Fault] = []
        self._document = document
        self._bytes = 0

    def fault(self, path: tuple[str | int, ...], what: str, expected: str = "", remedy: str = "") -> None:
        self.faults.append(Fault(self._document.where(path), what, expected, remedy))

    def found(self, i: int, key: str, names: str | Sequence[str]) -> list[Path]:
        """The paths of files and globs, those of a glob by name, 10 after 9."""
        paths: list[Path] = []
        for name in [names] if isinstance(names, str) else names:
            if not any(sign in name for sign in "*?[") or _is_file(self.folder / name):
                paths.append(self.folder / name)
                continue
            if ".." in Path(name).parts:  # it might search the whole disk
                self.fault(("captures", i, key), f"{name!r} leaves the folder", f"files in {self.folder}")
                continue
            try:
                matching = self._matching(name)
            except (ValueError, NotImplementedError) as error:
                self.fault(("captures", i, key), f"{name!r} is no pattern for files: {error}")
                continue
            if not matching:
                other = self._matching(_any_case(name))
                remedy = f"Capitals count: there is {other[0].relative_to(self.folder)}." if other else ""
                what, expected = f"no file matches {name!r}", f"files in {self.folder}"
                self.fault(("captures", i, key), what, expected, remedy)
            paths += matching
        return paths

    def _matching(self, pattern: str) -> list[Path]:
        """The files of a pattern; hidden ones, which systems leave beside others, only where it says so."""
        hidden = Path(pattern).name.startswith(".")
        found = (path for path in self.folder.glob(pattern) if hidden or not path.name.startswith("."))
        return sorted(filter(Path.is_file, found), key=by_number)

    def stack(
        self, i: int, key: str, paths: Sequence[Path], shape: tuple[int, int]
    ) -> NDArray[np.float32] | None:
        """(N, H, W, C) images [DN]; None where one of them cannot be used, or there is none."""
        where = self._document.where(("captures", i, key))
        self._bytes += len(paths) * math.prod(shape) * self.channels * np.dtype(np.float32).itemsize
        if self._bytes > limits().bytes_of("captures_mb"):
            self.faults.append(too_large(where, "the images up to here", self._bytes, "captures_mb"))
            return None
        images: NDArray[np.float32] | None = None
        read = 0
        for path in paths:
            try:
                image = read_image(path, where, self.folder)
                if key == "real":
                    check_bit_depth(image, self.bit_depth, where, path.name)
                image = self._with_channels(image, path, where)
            except UserError as error:
                self.faults.extend(error.faults)
                continue
            if image.shape[:2] != shape:
                height, width = image.shape[:2]
                self.faults.append(
                    Fault(
                        where,
                        f"{path.name} has {width} x {height} pixels",
                        f"{shape[1]} x {shape[0]}",
                        "Give the capture its own width_px and height_px, or correct the camera's.",
                    )
                )
                continue
            if images is None:  # filled one by one, as a list beside it would take as much again
                images = np.empty((len(paths), *shape, self.channels), np.float32)
            images[read] = image
            read += 1
        return images if read == len(paths) else None

    def coding(self, i: int, path: Path) -> FileCoding | None:
        """Coding of a file that could be read; None where it is no JPEG."""
        found = jpeg_coding(path, where=self._document.where(("captures", i, "real")), within=self.folder)
        return None if found is None else FileCoding(*found)

    def _with_channels(self, image: NDArray[Any], path: Path, where: str) -> NDArray[Any]:
        given = image.shape[2]
        if given == self.channels:
            return image
        if self.channels == 1 and (image == image[..., :1]).all():
            return image[..., :1]
        raise UserError(
            Fault(
                where,
                f"{path.name} has {given} channel{'s' * (given > 1)}",
                str(self.channels),
                "Correct camera.channels.",
            )
        )

    def array(
        self, i: int, key: str, name: str | None, shape: tuple[int, ...], *, infinite: bool = False
    ) -> NDArray[np.float64] | None:
        """An array or image that begins with a shape; infinite values only where they have a meaning."""
        if name is None:
            return None
        where = self._document.where(("captures", i, key))
        path = self.folder / name
        try:
            numbers = path.suffix.lower() == ".npy" and _is_file(path)
            array = (read_array if numbers else read_image)(path, where, self.folder)
        except UserError as error:
            self.faults.extend(error.faults)
            return None
        if array.shape[: len(shape)] != shape:
            self.faults.append(Fault(where, f"{name} has the shape {array.shape}", f"{shape}"))
            return None
        values = array.astype(np.float64)
        if np.isnan(values).any() or not (infinite or np.isfinite(values).all()):
            self.faults.append(Fault(where, f"{name} holds NaN or infinite values", "finite numbers"))
            return None
        return values

    def patches(
        self, i: int, name: str, shape: tuple[int, int]
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]] | None:
        """Boxes [px] and expected linear values [DN] of the patches of a chart."""
        where = self._document.where(("captures", i, "chart"))
        path = self.folder / name
        rows, before = [], len(self.faults)
        try:
            for line, row in _rows(path, where, self.folder):
                try:
                    rows.append(_patch(row, shape))
                except ValueError as error:
                    self.faults.append(Fault(f"{where}: {name}:{line}", str(error)))
        except UserError as error:
            self.faults.extend(error.faults)
        if len(self.faults) > before:
            return None
        if not rows:
            self.faults.append(Fault(where, f"{name} lists no patch", ",".join(("id", *PATCH_COLUMNS))))
            return None
        boxes, colours = zip(*rows, strict=True)
        return np.array(boxes, np.int64), np.array(colours, np.float64)


def _any_case(pattern: str) -> str:
    """A pattern that capitals do not matter to, but for those in brackets of its own."""
    if "[" in pattern:
        return pattern
    return "".join(f"[{c.lower()}{c.upper()}]" if c.isascii() and c.isalpha() else c for c in pattern)


def by_number(path: Path) -> list[tuple[int, str]]:
    """Sort key: names with their numbers as numbers, 10 after 9."""
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"([0-9]+)", str(path))]


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name too long for any file
        return False


def _rows(path: Path, where: str, within: Path) -> Iterator[tuple[int, dict[str, str]]]:
    heading, lines = read_rows(path, where=where, within=within)
    expected = ",".join(("id", *PATCH_COLUMNS))
    if missing := [name for name in PATCH_COLUMNS if name not in heading]:
        raise UserError(Fault(where, f"{path.name} has no column {', '.join(missing)}", expected))
    yield from lines


def _patch(row: Mapping[str, str], shape: tuple[int, int]) -> tuple[tuple[int, ...], tuple[float, ...]]:
    values = {}
    for name in PATCH_COLUMNS:
        text = row.get(name, "")
        try:
            values[name] = float(text)
        except ValueError:
            values[name] = math.nan
        if not math.isfinite(values[name]):
            raise ValueError(f"{name} is {text or 'empty'}, not a number")
    x, y, width, height = box = tuple(round(values[name]) for name in PATCH_COLUMNS[:4])
    if width < 1 or height < 1 or x < 0 or y < 0 or x + width > shape[1] or y + height > shape[0]:
        raise ValueError(
            f"the patch of {width} x {height} pixels at ({x}, {y}) is not inside the image of "
            f"{shape[1]} x {shape[0]}"
        )
    return box, tuple(values[name] for name in PATCH_COLUMNS[4:])
