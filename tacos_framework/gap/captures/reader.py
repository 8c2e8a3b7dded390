"""Reads a folder of captures, and says all that is wrong with it at once."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.errors import Fault, UserError
from tacos_framework.gap.captures.capture import Board, Capture, CaptureFolder, Noise
from tacos_framework.gap.captures.entries import CameraEntry, CaptureEntry, CropEntry, FolderEntry, NoiseEntry
from tacos_framework.gap.captures.images import read_array, read_image
from tacos_framework.gap.captures.noise_estimate import estimate_noise
from tacos_framework.gap.captures.plausibility import limitations_of, order_faults
from tacos_framework.settings import check
from tacos_framework.values import ImageContext, ImageGeometry
from tacos_framework.yaml_reader import Document, read_yaml

FILE = "captures.yaml"
MAX_FRAMES = 6
"""Frames of one capture that are used; more add little and cost time."""

Render = Callable[[Path], NDArray[np.float32]]
"""Renders the expected values of a capture from a recipe: (1, H, W, C) [DN]."""


def read_captures(folder: str | Path, render: Render | None = None) -> CaptureFolder:
    """Read ``captures.yaml`` and every file it names.

    Parameters
    ----------
    folder
        The folder, or the path of its ``captures.yaml``.
    render
        Renders expected values for captures that name a `scene` recipe; without it they are refused.

    Raises
    ------
    UserError
        With every fault found: wrong entries with line and column, files that are missing, cannot be read,
        or do not fit.
    """
    path = Path(folder)
    path = path if path.suffix in (".yaml", ".yml") else path / FILE
    if path.parent.is_dir() and not path.is_file():
        raise UserError(
            Fault(
                str(path.parent), f"there is no {FILE}", "a folder of captures", "See the how-to on captures."
            )
        )
    document = read_yaml(path)
    entry, faults, _ = check(FolderEntry, document.data, document.where)
    if entry is None:
        raise UserError(faults)
    reader = _Reader(path.parent, document, entry, render)
    captures = [capture for i in range(len(entry.captures)) if (capture := reader.capture(i)) is not None]
    faults = [*reader.faults, *order_faults(captures, reader.where_of)]
    if faults:
        raise UserError(faults)
    limits = (*reader.limitations, *(text for capture in captures for text in limitations_of(capture)))
    return CaptureFolder(path.parent, tuple(captures), limits)


class _Reader:
    """Reads capture after capture, keeping faults."""

    def __init__(self, folder: Path, document: Document, entry: FolderEntry, render: Render | None):
        self.folder = folder
        self.document = document
        self.entry = entry
        self.render = render
        self.faults: list[Fault] = []
        self.limitations: list[str] = []
        self.where_of: dict[str, str] = {}
        counted = Counter(capture.id for capture in entry.captures)
        for i, capture in enumerate(entry.captures):
            self.where_of[capture.id] = document.where(("captures", i))
            if counted[capture.id] > 1:
                counted[capture.id] = 0
                self._fault(("captures", i, "id"), f"the id {capture.id!r} stands twice", "unique ids")

    def _fault(self, path: tuple[str | int, ...], what: str, expected: str = "", remedy: str = "") -> None:
        self.faults.append(Fault(self.document.where(path), what, expected, remedy))

    def capture(self, i: int) -> Capture | None:
        """A capture; None after its faults were kept."""
        entry = self.entry.captures[i]
        before = len(self.faults)
        self._check_needs(i, entry)
        try:
            geometry = _geometry(self.entry.camera, entry)
        except ValueError as error:
            self._fault(("captures", i, "crop"), str(error), "files that lie on the sensor")
            return None
        shape = (geometry.height_px, geometry.width_px)
        real = self._stack(i, "real", self._real_paths(i, entry), shape)
        expected = self._expected(i, entry, shape)
        mask = self._array(i, "mask", entry.mask, shape)
        depth = self._array(i, "depth", entry.depth, shape)
        velocity = entry.velocity_px_s
        moved = (
            self._array(i, "velocity_px_s", velocity, (*shape, 2))
            if isinstance(velocity, str)
            else None
            if velocity is None
            else np.array(velocity, np.float64)
        )
        patches = self._patches(i, entry, shape)
        if len(self.faults) > before or real is None:
            return None
        if expected is not None and len(expected) not in (1, len(real)):
            self._fault(
                ("captures", i, "simulated"),
                f"{len(expected)} files of {entry.id!r} for {len(real)} frames",
                "one, or one per frame",
            )
            return None
        camera = self.entry.camera
        context = ImageContext(
            exposure_s=(entry.exposure_ms or 30.0) * 1e-3,
            gain_db=entry.gain_db,
            f_number=camera.f_number,
            black_level_dn=camera.black_level_dn,
            white_level_dn=camera.white,
            depth_m=depth,
            velocity_px_s=moved,
            frame_interval_s=entry.frame_interval_ms and entry.frame_interval_ms * 1e-3,
            reference_row=entry.row_time_reference,
            cfa=camera.cfa,
        )
        if not self._plausible_scale(i, real, expected):
            return None
        valid = np.ones(shape, bool) if mask is None else mask.reshape(*shape, -1)[..., 0] != 0
        noise = self._noise(i, entry) or estimate_noise(
            real, expected, valid, camera.black_level_dn, camera.white
        )
        return Capture(
            id=entry.id,
            kind=entry.kind,
            real_dn=real,
            expected_dn=expected,
            valid=valid,
            geometry=geometry,
            context=context,
            noise=noise,
            exposure_stated=entry.exposure_ms is not None,
            group=entry.group,
            level_uncertainty=entry.level_uncertainty,
            expected_frames=entry.simulated_frames or 0,
            board=Board(entry.board.inner_corners, entry.board.square_mm) if entry.board else None,
            edge_angle_deg=entry.edge.angle_deg if entry.edge else None,
            patches=patches,
        )

    def _check_needs(self, i: int, entry: CaptureEntry) -> None:
        if entry.kind in ("dark", "bracket") and entry.exposure_ms is None:
            self._fault(
                ("captures", i), f"{entry.id!r}, a {entry.kind}, has no exposure_ms", "exposure_ms: 10"
            )
        if entry.kind == "board" and entry.board is None:
            self._fault(
                ("captures", i),
                f"{entry.id!r} does not describe its board",
                "board: {inner_corners: [9, 6], square_mm: 25}",
            )
        if entry.kind not in ("dark", "board", "edge") and entry.simulated is None and entry.scene is None:
            self._fault(
                ("captures", i), f"{entry.id!r} has no simulated", "the expected values: a file or a number"
            )

    # files ------------------------------------------------------------------------------------------------

    def _real_paths(self, i: int, entry: CaptureEntry) -> list[Path]:
        names = [entry.real] if isinstance(entry.real, str) else list(entry.real)
        paths: list[Path] = []
        for name in names:
            if any(sign in name for sign in "*?["):
                found = sorted(self.folder.glob(name)) if not Path(name).is_absolute() else []
                if not found:
                    self._fault(("captures", i, "real"), f"no file matches {name!r}", str(self.folder))
                paths += found
            else:
                paths.append(self.folder / name)
        if len(paths) > MAX_FRAMES:
            self.limitations.append(
                f"{entry.id}: {MAX_FRAMES} of its {len(paths)} frames are used, the first ones."
            )
        return paths[:MAX_FRAMES]

    def _stack(
        self, i: int, key: str, paths: list[Path], shape: tuple[int, int]
    ) -> NDArray[np.float32] | None:
        where = self.document.where(("captures", i, key))
        images = []
        for path in paths:
            try:
                image = self._one_channel_or_three(read_image(path, where), path, where)
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
            images.append(image.astype(np.float32))
        return np.stack(images) if images and len(images) == len(paths) else None

    def _one_channel_or_three(self, image: NDArray[Any], path: Path, where: str) -> NDArray[Any]:
        channels = self.entry.camera.channels
        if image.shape[2] == channels:
            return image
        if channels == 1 and (image == image[..., :1]).all():
            return image[..., :1]
        raise UserError(
            Fault(
                where, f"{path.name} has {image.shape[2]} channels", f"{channels}", "Correct camera.channels."
            )
        )

    def _expected(self, i: int, entry: CaptureEntry, shape: tuple[int, int]) -> NDArray[np.float32] | None:
        given, camera = entry.simulated, self.entry.camera
        if entry.kind == "board":
            return None
        if isinstance(given, float) or (given is None and entry.kind == "dark"):
            level = camera.black_level_dn if given is None else given
            return np.full((1, *shape, camera.channels), level, np.float32)
        if given is not None:
            names = [given] if isinstance(given, str) else list(given)
            return self._stack(i, "simulated", [self.folder / name for name in names], shape)
        if entry.scene is not None:
            return self._rendered(i, entry.scene, shape)
        return None

    def _rendered(self, i: int, scene: str, shape: tuple[int, int]) -> NDArray[np.float32] | None:
        if self.render is None:
            self._fault(("captures", i, "scene"), "nothing renders recipes here", "simulated: FILE")
            return None
        try:
            image = self.render(self.folder / scene)
        except UserError as error:
            place = self.document.where(("captures", i, "scene"))
            self.faults += [Fault(f"{place}: {f.where}", f.what, f.expected, f.remedy) for f in error.faults]
            return None
        wanted = (*shape, self.entry.camera.channels)
        if image.shape[1:] != wanted:
            self._fault(("captures", i, "scene"), f"{scene} renders {image.shape[1:]}", f"{wanted}")
            return None
        return image

    def _array(
        self, i: int, key: str, name: str | None, shape: tuple[int, ...]
    ) -> NDArray[np.float64] | None:
        if name is None:
            return None
        where = self.document.where(("captures", i, key))
        path = self.folder / name
        try:
            array = (
                read_array(path, where)
                if path.suffix == ".npy" and path.is_file()
                else read_image(path, where)
            )
        except UserError as error:
            self.faults.extend(error.faults)
            return None
        if array.shape[: len(shape)] != shape:
            self.faults.append(Fault(where, f"{name} has the shape {array.shape}", f"{shape}"))
            return None
        return array.astype(np.float64)

    def _patches(
        self, i: int, entry: CaptureEntry, shape: tuple[int, int]
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]] | None:
        if entry.chart is None:
            return None
        where = self.document.where(("captures", i, "chart"))
        try:
            rows = list(_patch_rows(self.folder / entry.chart.patches))
        except (OSError, ValueError, KeyError, csv.Error) as error:
            self.faults.append(
                Fault(where, f"{entry.chart.patches} cannot be used: {error}", "id,x,y,width,height,r,g,b")
            )
            return None
        boxes = np.array([row[0] for row in rows], np.int64).reshape(-1, 4)
        inside = (boxes[:, :2] >= 0).all() and (boxes[:, :2] + boxes[:, 2:] <= shape[::-1]).all()
        if not len(boxes) or not inside or (boxes[:, 2:] < 1).any():
            self.faults.append(Fault(where, "patches lie outside the image, or there are none"))
            return None
        return boxes, np.array([row[1] for row in rows], np.float64)

    # numbers ----------------------------------------------------------------------------------------------

    def _noise(self, i: int, entry: CaptureEntry) -> Noise | None:
        blocks = self.entry.noise
        if blocks == "unknown" or isinstance(blocks, str):
            return None
        several = (blocks,) if isinstance(blocks, NoiseEntry) else blocks
        matching = [block for block in several if block.gain_db == entry.gain_db]
        if not matching and isinstance(blocks, NoiseEntry):
            matching = [blocks]
        if not matching:
            self._fault(("captures", i), f"noise: has no block for gain_db {entry.gain_db:g} of {entry.id!r}")
            return None
        return Noise(_per_channel(matching[0].photon_dn), _per_channel(matching[0].thermal_dn2))

    def _plausible_scale(
        self, i: int, real: NDArray[np.float32], expected: NDArray[np.float32] | None
    ) -> bool:
        white = self.entry.camera.white
        if real.max() > white:
            self._fault(
                ("captures", i, "real"),
                f"values reach {real.max():g}",
                f"at most the white level, {white:g}",
                "Correct camera.bit_depth or white_level_dn; values are right-aligned.",
            )
            return False
        if real.min() < 0:
            self._fault(("captures", i, "real"), f"values go down to {real.min():g}", "0 or above")
            return False
        if expected is not None and 0 < expected.max() <= 1 and real.mean() > 8 and white >= 255:
            self._fault(
                ("captures", i, "simulated"),
                f"values run from {expected.min():g} to {expected.max():g}",
                f"digital numbers up to {white:g}, as in the files",
                "Multiply it by the white level.",
            )
            return False
        return True


def _per_channel(value: float | tuple[float, ...]) -> tuple[float, ...]:
    return tuple(value) if isinstance(value, tuple) else (value,)


def _patch_rows(path: Path) -> Iterator[tuple[tuple[int, ...], tuple[float, ...]]]:
    with path.open(newline="", encoding="utf-8-sig") as file:
        for row in csv.DictReader(file, skipinitialspace=True):
            box = tuple(round(float(row[key])) for key in ("x", "y", "width", "height"))
            yield box, tuple(float(row[key]) for key in ("r", "g", "b"))


def _geometry(camera: CameraEntry, entry: CaptureEntry) -> ImageGeometry:
    width = entry.width_px or camera.width_px
    height = entry.height_px or camera.height_px
    own_size = entry.width_px is not None or entry.height_px is not None
    crop = entry.crop or (None if own_size and camera.crop is None else camera.crop)
    crop = crop or CropEntry(full_width_px=width, full_height_px=height)
    centre = camera.principal_point_px
    if centre is None:
        centre = ((crop.full_width_px - 1) / 2 - crop.x, (crop.full_height_px - 1) / 2 - crop.y)
    elif entry.crop is not None:
        base = camera.crop
        centre = (centre[0] + (base.x if base else 0) - crop.x, centre[1] + (base.y if base else 0) - crop.y)
    return ImageGeometry(
        width_px=width,
        height_px=height,
        focal_length_px=camera.focal_length_mm * 1e3 / camera.pixel_um,
        centre_px=centre,
        pixel_um=camera.pixel_um,
        offset_px=(crop.x, crop.y),
        full_width_px=crop.full_width_px,
        full_height_px=crop.full_height_px,
    )
