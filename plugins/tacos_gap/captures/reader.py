"""Reads a folder of captures, and says all that is wrong with it at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Document, Fault, ImageContext, ImageGeometry, UserError, check, read_yaml
from tacos_gap.captures.capture import (
    Board,
    CaptureFolder,
    Noise,
    Objects,
    RealCapture,
    usual_gain_db,
)
from tacos_gap.captures.doubts import doubt_of_files, doubts
from tacos_gap.captures.entries import BoardEntry, CaptureEntry, FolderEntry
from tacos_gap.captures.expected_values import ExpectedValues, Render
from tacos_gap.captures.files import MAX_FRAMES, CaptureFiles
from tacos_gap.captures.large import as_kept
from tacos_gap.captures.lens_and_sensor import FOCAL_LENGTH_MM, filters_of, geometry_of, unstated
from tacos_gap.captures.missing import FILE, nothing_to_read
from tacos_gap.captures.other_yaml import something_else
from tacos_gap.captures.plausibility import faults_of, limitations_of, order_faults
from tacos_gap.captures.stated_noise import StatedNoise
from tacos_gap.captures.targets.expectation import with_own_expectations
from tacos_gap.captures.time_order import in_time_order, time_doubts

_NOT_YET_ESTIMATED = Noise((0.0,), (0.0,), known=False)

_ASSUMED_MS = 30.0
"""Stands for an exposure time that is not stated [ms]."""


def read_captures(folder: str | Path, render: Render | None = None) -> CaptureFolder:
    """Read ``captures.yaml`` and every file it names.

    - `render`: renders expected values for captures that name a `scene` recipe; without it they are refused.

    Raises UserError with every fault found: wrong entries with line and column, files that are missing,
    cannot be read, or do not fit.
    """
    path, document, entry = read_entries(folder)
    reader = _Reader(path.parent, document, entry, render)
    if reader.files.faults:
        raise UserError(reader.files.faults)
    listed = [capture for i in range(len(entry.captures)) if (capture := reader.capture(i)) is not None]
    captures = in_time_order(listed)
    faults = [*reader.files.faults, *order_faults(captures, reader.where_of)]
    if faults:
        raise UserError(faults)
    limits = (*reader.limitations, *(text for capture in captures for text in limitations_of(capture)))
    usable, left_out = with_own_expectations(captures)
    if not usable:
        raise UserError([Fault(reader.where_of[text.partition(": ")[0]], text) for text in left_out])
    if len({capture.context.gain_db for capture in usable}) > 1:
        usual_db = usual_gain_db(usable)
        usable = tuple(replace(c, context=replace(c.context, charges_at_db=usual_db)) for c in usable)
    return CaptureFolder(path.parent, usable, (*limits, *time_doubts(listed), *doubts(captures), *left_out))


def read_entries(folder: str | Path) -> tuple[Path, Document, FolderEntry]:
    """Entries of ``captures.yaml``, its files not yet opened; its path, and the lines it stands in.

    Raises UserError when it is not there, or has entries that are wrong, with line and column.
    """
    path = Path(folder)
    path = path if path.suffix in (".yaml", ".yml") else path / FILE
    if path.name == FILE and not path.is_file():
        raise UserError(nothing_to_read(path.parent))
    document = read_yaml(path, aliases=True)
    if other := something_else(path, document.data):
        raise UserError(other)
    entry, faults, _ = check(FolderEntry, document.data, document.where)
    if entry is None:
        raise UserError(faults)
    return path, document, entry


class _Reader:
    """Reads capture after capture, keeping faults."""

    def __init__(self, folder: Path, document: Document, entry: FolderEntry, render: Render | None):
        self.entry = entry
        self.files = CaptureFiles(folder, document, entry.camera.channels, entry.camera.bit_depth)
        self.limitations: list[str] = []
        self.where_of: dict[str, str] = {}
        if not entry.captures:
            self.files.fault(("captures",), "there are no captures", "one at least")
        for i, capture in enumerate(entry.captures):
            if capture.id in self.where_of:
                self.files.fault(("captures", i, "id"), f"the id {capture.id!r} stands twice", "unique ids")
            self.where_of[capture.id] = document.where(("captures", i))
        try:
            geometry_of(entry.camera, None)
        except ValueError as error:
            self.files.fault(("camera", "crop"), str(error), "files that lie on the sensor")
        self.noise = StatedNoise(entry, self.files)
        self.expected = ExpectedValues(entry, self.files, render)
        if entry.camera.focal_length_mm is None and all(each.kind != "board" for each in entry.captures):
            self.limitations.append(
                f"focal_length_mm is not stated, and no boards show it: {FOCAL_LENGTH_MM:g} mm is assumed. "
                f"Nothing is said about it."
            )

    def capture(self, i: int) -> RealCapture | None:
        entry, camera, files = self.entry.captures[i], self.entry.camera, self.files
        before = len(files.faults)
        self._check_needs(i, entry)
        geometry = self._geometry(i, entry)
        if geometry is None:
            return None
        shape = (geometry.height_px, geometry.width_px)
        paths = files.found(i, "real", entry.real)
        real = files.stack(i, "real", paths[:MAX_FRAMES], shape)
        self._limit(entry, paths)
        expected = self.expected.of(i, entry, shape, len(paths), usable=real is not None)
        valid = self._valid(i, entry, shape)
        context = self._context(i, entry, shape)
        objects = self._objects(i, entry, shape)
        patches = files.patches(i, entry.chart.patches, shape) if entry.chart else None
        noise = self.noise.at(i, entry)
        if len(files.faults) > before or real is None:
            return None
        capture = RealCapture(
            id=entry.id,
            kind=entry.kind,
            real_dn=real,
            expected_dn=expected,
            valid=valid,
            geometry=geometry,
            context=context,
            noise=noise or _NOT_YET_ESTIMATED,
            exposure_stated=entry.exposure_ms is not None,
            group=entry.group,
            level_uncertainty=entry.level_uncertainty,
            expected_frames=entry.simulated_frames or 0,
            board=_board(entry.board) if entry.board else None,
            coding=files.coding(i, paths[0]),
            edge_angle_deg=entry.edge.angle_deg if entry.edge else None,
            patches=patches,
            row_time_us=entry.row_time_us,
            motion_blurred=entry.motion_blurred,
            taken_s=entry.taken_s,
            unstated=unstated(camera),
            objects=objects,
        )
        capture = as_kept(capture)
        for key, what, wanted, remedy in faults_of(capture):
            files.fault(("captures", i, key), what, wanted, remedy)
        return capture if len(files.faults) == before else None

    def _geometry(self, i: int, entry: CaptureEntry) -> ImageGeometry | None:
        try:
            return geometry_of(self.entry.camera, entry)
        except ValueError as error:
            self.files.fault(("captures", i, "crop"), str(error), "files that lie on the sensor")
            return None

    def _limit(self, entry: CaptureEntry, paths: Sequence[Path]) -> None:
        if len(paths) > MAX_FRAMES:
            self.limitations.append(
                f"{entry.id}: {MAX_FRAMES} of its {len(paths)} frames are used, the first ones."
            )
        self.limitations += doubt_of_files(entry.id, [path.suffix for path in paths])
        if entry.kind == "board" and (entry.simulated is not None or entry.scene is not None):
            self.limitations.append(
                f"{entry.id}: `simulated` is not used; a board is compared with its best pose."
            )

    def _valid(self, i: int, entry: CaptureEntry, shape: tuple[int, int]) -> NDArray[np.bool_]:
        """(H, W) where the expectation says something: everywhere without a mask, or after a fault of it."""
        mask = self.files.array(i, "mask", entry.mask, shape)
        return np.ones(shape, bool) if mask is None else mask.reshape(*shape, -1)[..., 0] != 0

    def _context(self, i: int, entry: CaptureEntry, shape: tuple[int, int]) -> ImageContext:
        camera = self.entry.camera
        return ImageContext(
            exposure_s=(entry.exposure_ms or _ASSUMED_MS) * 1e-3,
            gain_db=entry.gain_db,
            f_number=camera.f_number,
            black_level_dn=camera.black_level_dn,
            white_level_dn=camera.white,
            depth_m=self._depth(i, entry, shape),
            velocity_px_s=self._velocity(i, entry, shape),
            frame_interval_s=entry.frame_interval_ms and entry.frame_interval_ms * 1e-3,
            reference_row=entry.row_time_reference,
            cfa=filters_of(camera, entry),
        )

    def _depth(self, i: int, entry: CaptureEntry, shape: tuple[int, int]) -> NDArray[np.float64] | None:
        depth_m = self.files.array(i, "depth", entry.depth, shape, infinite=True)
        if depth_m is not None and (depth_m <= 0).any():
            what = f"{entry.depth} holds depths of 0 or below"
            self.files.fault(("captures", i, "depth"), what, "metres above 0")
        return depth_m

    def _check_needs(self, i: int, entry: CaptureEntry) -> None:
        fault = self.files.fault
        if entry.kind == "bracket" and entry.exposure_ms is None:
            fault(("captures", i), f"{entry.id!r}, a bracket, has no exposure_ms", "exposure_ms: 10")
        if entry.kind == "dark" and entry.exposure_ms is None:
            self.limitations.append(
                f"{entry.id}: it does not say its exposure time. {_ASSUMED_MS:g} ms is assumed, so a rate of "
                f"dark current has no scale; write exposure_ms."
            )
        if entry.kind == "board" and entry.board is None:
            fault(
                ("captures", i),
                f"{entry.id!r} does not describe its board",
                "board: {inner_corners: [9, 6], square_mm: 25}",
            )
        if entry.simulated is not None and entry.scene is not None:
            fault(("captures", i, "scene"), f"{entry.id!r} has both simulated and scene", "one of the two")

    def _velocity(self, i: int, entry: CaptureEntry, shape: tuple[int, int]) -> NDArray[np.float64] | None:
        given = entry.velocity_px_s
        if isinstance(given, str):
            return self.files.array(i, "velocity_px_s", given, (*shape, 2))
        return None if given is None else np.array(given, np.float64)

    def _objects(self, i: int, entry: CaptureEntry, shape: tuple[int, int]) -> Objects | None:
        if entry.objects is None:
            return None
        if entry.kind == "sequence":
            self.files.fault(("captures", i, "objects"), "a sequence has objects", "objects of a still")
            return None
        found = self.files.array(i, "objects", entry.objects.ids, shape)
        if found is None:
            return None
        ids, most = found.reshape(*shape, -1)[..., 0], len(entry.objects.classes)
        if (ids != np.rint(ids)).any() or ids.min() < 0 or ids.max() > most:
            what = f"{entry.objects.ids} holds ids from {ids.min():g} to {ids.max():g}"
            self.files.fault(("captures", i, "objects"), what, f"whole numbers from 0 to {most}, as classes")
            return None
        return Objects(ids.astype(np.int32), ("background", *entry.objects.classes))


def _board(entry: BoardEntry) -> Board:
    if entry.pattern != "charuco":
        return Board(entry.inner_corners, entry.square_mm, entry.pattern)
    return Board(
        entry.inner_corners, entry.square_mm, entry.pattern, entry.marker_mm or 0.0, entry.dictionary
    )
