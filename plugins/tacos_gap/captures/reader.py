"""Reads a folder of captures, and says all that is wrong with it at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tacos_framework.errors import Fault, UserError
from tacos_framework.settings import check
from tacos_framework.settings.yaml_reader import Document, read_yaml
from tacos_framework.values import ImageContext, ImageGeometry
from tacos_gap.captures.capture import Board, CaptureFolder, Noise, Objects, RealCapture
from tacos_gap.captures.doubts import doubt_of_files, doubts
from tacos_gap.captures.entries import (
    BoardEntry,
    CaptureCamera,
    CaptureEntry,
    CropEntry,
    FolderEntry,
    NoiseEntry,
)
from tacos_gap.captures.files import CaptureFiles
from tacos_gap.captures.noise_estimate import estimate_noise
from tacos_gap.captures.plausibility import faults_of, limitations_of, order_faults

FILE = "captures.yaml"
MAX_FRAMES = 6
"""Frames of one capture that are used; more add little and cost time."""

FOCAL_LENGTH_MM = 4.0
"""Stands for a focal length that nobody stated, until boards tell it."""

Render = Callable[[Path, str], NDArray[np.float32]]
"""Renders the expected values of a capture, (1 or N, H, W, C) [DN], from a recipe and the capture's id."""


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
                str(path.parent),
                f"there is no {path.name}",
                "a folder of captures",
                "See the how-to on captures.",
            )
        )
    document = read_yaml(path)
    entry, faults, _ = check(FolderEntry, document.data, document.where)
    if entry is None:
        raise UserError(faults)
    reader = _Reader(path.parent, document, entry, render)
    if reader.files.faults:
        raise UserError(reader.files.faults)
    captures = [capture for i in range(len(entry.captures)) if (capture := reader.capture(i)) is not None]
    faults = [*reader.files.faults, *order_faults(captures, reader.where_of)]
    if faults:
        raise UserError(faults)
    from tacos_gap.targets.expectation import with_own_expectations  # targets build on captures

    limits = (*reader.limitations, *(text for capture in captures for text in limitations_of(capture)))
    usable, left_out = with_own_expectations(captures)
    if not usable:
        raise UserError([Fault(reader.where_of[text.partition(": ")[0]], text) for text in left_out])
    return CaptureFolder(path.parent, usable, (*limits, *doubts(captures), *left_out))


class _Reader:
    """Reads capture after capture, keeping faults."""

    def __init__(self, folder: Path, document: Document, entry: FolderEntry, render: Render | None):
        self.entry = entry
        self.render = render
        self.files = CaptureFiles(folder, document, entry.camera.channels)
        self.limitations: list[str] = []
        self.where_of: dict[str, str] = {}
        if not entry.captures:
            self.files.fault(("captures",), "there are no captures", "one at least")
        for i, capture in enumerate(entry.captures):
            if capture.id in self.where_of:
                self.files.fault(("captures", i, "id"), f"the id {capture.id!r} stands twice", "unique ids")
            self.where_of[capture.id] = document.where(("captures", i))
        try:
            _geometry(entry.camera, None)
        except ValueError as error:
            self.files.fault(("camera", "crop"), str(error), "files that lie on the sensor")
        self._check_noise()
        if entry.camera.focal_length_mm is None and all(each.kind != "board" for each in entry.captures):
            self.limitations.append(
                f"focal_length_mm is not stated, and there are no boards to tell it: {FOCAL_LENGTH_MM:g} mm "
                f"is assumed. Nothing is said about it."
            )

    def capture(self, i: int) -> RealCapture | None:
        """A capture; None after its faults were kept."""
        entry, camera, files = self.entry.captures[i], self.entry.camera, self.files
        before = len(files.faults)
        self._check_needs(i, entry)
        try:
            geometry = _geometry(camera, entry)
        except ValueError as error:
            files.fault(("captures", i, "crop"), str(error), "files that lie on the sensor")
            return None
        shape = (geometry.height_px, geometry.width_px)
        paths = files.found(i, "real", entry.real)
        if len(paths) > MAX_FRAMES:
            self.limitations.append(
                f"{entry.id}: {MAX_FRAMES} of its {len(paths)} frames are used, the first ones."
            )
        real = files.stack(i, "real", paths[:MAX_FRAMES], shape)
        self.limitations += doubt_of_files(entry.id, [path.suffix for path in paths])
        expected = self._expected(i, entry, shape, len(paths), usable=real is not None)
        mask = files.array(i, "mask", entry.mask, shape)
        depth = files.array(i, "depth", entry.depth, shape, infinite=True)
        if depth is not None and (depth <= 0).any():
            files.fault(
                ("captures", i, "depth"), f"{entry.depth} holds depths of 0 or below", "metres above 0"
            )
        velocity = self._velocity(i, entry, shape)
        objects = self._objects(i, entry, shape)
        patches = files.patches(i, entry.chart.patches, shape) if entry.chart else None
        noise = self._noise(i, entry)
        if len(files.faults) > before or real is None:
            return None
        valid = np.ones(shape, bool) if mask is None else mask.reshape(*shape, -1)[..., 0] != 0
        capture = RealCapture(
            id=entry.id,
            kind=entry.kind,
            real_dn=real,
            expected_dn=expected,
            valid=valid,
            geometry=geometry,
            context=ImageContext(
                exposure_s=(entry.exposure_ms or 30.0) * 1e-3,
                gain_db=entry.gain_db,
                f_number=camera.f_number,
                black_level_dn=camera.black_level_dn,
                white_level_dn=camera.white,
                depth_m=depth,
                velocity_px_s=velocity,
                frame_interval_s=entry.frame_interval_ms and entry.frame_interval_ms * 1e-3,
                reference_row=entry.row_time_reference,
                cfa=camera.cfa,
            ),
            noise=noise
            or estimate_noise(
                real, expected, valid, camera.black_level_dn, camera.white, mosaic=camera.cfa is not None
            ),
            exposure_stated=entry.exposure_ms is not None,
            group=entry.group,
            level_uncertainty=entry.level_uncertainty,
            expected_frames=entry.simulated_frames or 0,
            board=_board(entry.board) if entry.board else None,
            edge_angle_deg=entry.edge.angle_deg if entry.edge else None,
            patches=patches,
            row_time_us=entry.row_time_us,
            unstated=_unstated(camera),
            objects=objects,
        )
        for key, what, wanted, remedy in faults_of(capture):
            files.fault(("captures", i, key), what, wanted, remedy)
        return capture if len(files.faults) == before else None

    def _check_needs(self, i: int, entry: CaptureEntry) -> None:
        fault = self.files.fault
        if entry.kind in ("dark", "bracket") and entry.exposure_ms is None:
            fault(("captures", i), f"{entry.id!r}, a {entry.kind}, has no exposure_ms", "exposure_ms: 10")
        if entry.kind == "board" and entry.board is None:
            fault(
                ("captures", i),
                f"{entry.id!r} does not describe its board",
                "board: {inner_corners: [9, 6], square_mm: 25}",
            )
        if entry.simulated is not None and entry.scene is not None:
            fault(("captures", i, "scene"), f"{entry.id!r} has both simulated and scene", "one of the two")

    # what is expected -------------------------------------------------------------------------------------

    def _expected(
        self, i: int, entry: CaptureEntry, shape: tuple[int, int], frames: int, *, usable: bool
    ) -> NDArray[np.float32] | None:
        given, camera = entry.simulated, self.entry.camera
        if entry.kind == "board":
            return None
        if isinstance(given, float) or (given is None and entry.kind == "dark"):
            if not usable:  # nor may its size be taken at its word
                return None
            level = camera.black_level_dn if given is None else given
            return np.full((1, *shape, camera.channels), level, np.float32)
        if given is not None:
            paths = self.files.found(i, "simulated", given)
            if frames and self._one_or_one_per_frame(i, "simulated", len(paths), frames):
                return self.files.stack(i, "simulated", paths[:MAX_FRAMES], shape)
            return None
        return self._rendered(i, entry, entry.scene, shape, frames) if entry.scene else None

    def _one_or_one_per_frame(self, i: int, key: str, expected: int, frames: int) -> bool:
        if expected > 1 and expected != frames:
            self.files.fault(
                ("captures", i, key),
                f"{self.entry.captures[i].id!r} expects {expected} images and has {frames} frames",
                "one, or one per frame",
            )
            return False
        return True

    def _rendered(
        self, i: int, entry: CaptureEntry, scene: str, shape: tuple[int, int], frames: int
    ) -> NDArray[np.float32] | None:
        files = self.files
        if self.render is None:
            files.fault(("captures", i, "scene"), "nothing renders recipes here", "simulated: FILE")
            return None
        before = len(files.faults)
        try:
            images = self.render(files.folder / scene, entry.id)
        except UserError as error:
            for fault in error.faults:
                files.fault(
                    ("captures", i, "scene"), f"{fault.where}: {fault.what}", fault.expected, fault.remedy
                )
            return None
        wanted = (*shape, self.entry.camera.channels)
        if images.shape[1:] != wanted:
            files.fault(
                ("captures", i, "scene"),
                f"{scene} renders images of {images.shape[1:]}",
                f"{wanted}: height, width, channels of the files",
                "Give the recipe the camera of the files.",
            )
        self._one_or_one_per_frame(i, "scene", len(images), frames)
        return images[:MAX_FRAMES] if len(files.faults) == before else None

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

    # noise ------------------------------------------------------------------------------------------------

    @property
    def _blocks(self) -> Sequence[NoiseEntry]:
        given = self.entry.noise
        if isinstance(given, str):
            return ()
        return (given,) if isinstance(given, NoiseEntry) else given

    def _check_noise(self) -> None:
        channels = self.entry.camera.channels
        seen: set[float] = set()
        for place, block in enumerate(self._blocks):
            at = ("noise",) if isinstance(self.entry.noise, NoiseEntry) else ("noise", place)
            for name in ("photon_dn", "thermal_dn2"):
                if isinstance(getattr(block, name), tuple) and channels == 1:
                    self.files.fault((*at, name), f"{name} has 3 numbers for 1 channel", "one number")
            if block.gain_db in seen:
                self.files.fault(at, f"two blocks are for gain_db {block.gain_db:g}", "one block per gain")
            seen.add(block.gain_db)

    def _noise(self, i: int, entry: CaptureEntry) -> Noise | None:
        blocks = self._blocks
        if not blocks:
            return None
        matching = [block for block in blocks if block.gain_db == entry.gain_db]
        if not matching and len(blocks) == 1 and "gain_db" not in blocks[0].model_fields_set:
            gains = {capture.gain_db for capture in self.entry.captures}
            matching = list(blocks) if len(gains) == 1 else []
        if not matching:
            self.files.fault(
                ("captures", i),
                f"noise has no block for gain_db {entry.gain_db:g} of {entry.id!r}",
                "noise: a list with one block per gain_db",
            )
            return None
        return Noise(_per_channel(matching[0].photon_dn), _per_channel(matching[0].thermal_dn2))


def _per_channel(value: float | tuple[float, ...]) -> tuple[float, ...]:
    return tuple(value) if isinstance(value, tuple) else (value,)


def _board(entry: BoardEntry) -> Board:
    if entry.pattern != "charuco":
        return Board(entry.inner_corners, entry.square_mm, entry.pattern)
    return Board(
        entry.inner_corners, entry.square_mm, entry.pattern, entry.marker_mm or 0.0, entry.dictionary
    )


def _unstated(camera: CaptureCamera) -> frozenset[str]:
    """What of the lens is nobody's claim: a centre that goes without saying is one, beside a focal length."""
    if camera.focal_length_mm is not None:
        return frozenset()
    return frozenset({"focal_length", *(() if camera.principal_point_px else ("principal_point",))})


def _geometry(camera: CaptureCamera, entry: CaptureEntry | None) -> ImageGeometry:
    """Where the files of a capture lie on the sensor; those of the camera itself for None."""
    width = (entry and entry.width_px) or camera.width_px
    height = (entry and entry.height_px) or camera.height_px
    own_crop = entry.crop if entry else None
    crop = own_crop or camera.crop or CropEntry(full_width_px=width, full_height_px=height)
    centre = camera.principal_point_px
    if centre is None:
        centre = ((crop.full_width_px - 1) / 2 - crop.x, (crop.full_height_px - 1) / 2 - crop.y)
    elif own_crop is not None:
        base = camera.crop
        centre = (centre[0] + (base.x if base else 0) - crop.x, centre[1] + (base.y if base else 0) - crop.y)
    return ImageGeometry(
        width_px=width,
        height_px=height,
        focal_length_px=(camera.focal_length_mm or FOCAL_LENGTH_MM) * 1e3 / camera.pixel_um,
        centre_px=centre,
        pixel_um=camera.pixel_um,
        offset_px=(crop.x, crop.y),
        full_width_px=crop.full_width_px,
        full_height_px=crop.full_height_px,
    )
