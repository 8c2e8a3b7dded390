"""Frames of a folder, measured: bright levels with the darkness that belongs to each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tacos_files.camera_images import has_one_value, read_frame, roughness, usual_bit_depth
from tacos_framework import Fault, UserError
from tacos_plugins.emva_calibration.frame_table import TABLE, FrameGroup
from tacos_plugins.emva_calibration.moments import Frame, Moments, moments_of
from tacos_plugins.emva_calibration.nonuniformity import SpatialVariance, spatial_variance

STACK_FRAMES = 8
"""From so many frames a group serves for nonuniformity; the standard takes 50 or more."""

LEAST_LEVELS = 3
"""Bright levels that the gain takes."""

_NARROWEST_PX = 16
_FAR_ROUGHER = 8.0
_MOST_DRIFT = 0.15


@dataclass(frozen=True)
class Channel:
    """One colour of the camera: groups of frames beside what they say."""

    name: str
    groups: tuple[tuple[FrameGroup, Moments], ...]
    stacks: tuple[tuple[FrameGroup, SpatialVariance], ...]
    bit_depth: int
    step_dn: int
    bytes_swapped: bool = False
    """True if files hold the two bytes of a sample in the wrong order, and they were swapped."""

    def of(self, kind: str) -> list[tuple[FrameGroup, Moments]]:
        """The groups that are bright, or dark."""
        return [each for each in self.groups if each[0].kind == kind]


def measure_channels(
    folder: Path,
    groups: Sequence[FrameGroup],
    mosaic: str,
    bit_depth: int | None,
    told: Callable[[str], None] = lambda text: None,
) -> tuple[tuple[Channel, ...], tuple[FrameGroup, ...]]:
    """Moments of all groups, channel by channel, green or mono first, and the groups of one frame, left out.

    Raises `UserError` with every file that cannot be read or does not fit, or when no level has two frames.
    """
    single = tuple(group for group in groups if len(group.files) < 2)
    paired = [group for group in groups if len(group.files) >= 2]
    for kind in ("bright", "dark"):
        if not any(group.kind == kind for group in paired):
            raise UserError(
                Fault(
                    str(folder),
                    f"no {kind} level has two frames: noise is what changes from one to the other",
                    "two frames of each level, of the same light and exposure",
                    f"Take two {kind} frames at each level without changing anything, and list both "
                    "with the same exposure and photons_per_pixel.",
                )
            )
    if single and sum(group.kind == "bright" for group in paired) < LEAST_LEVELS:
        raise UserError(
            Fault(
                str(folder),
                f"{len(single)} of {len(groups)} levels have one frame: too few are left for the gain",
                f"two frames of {LEAST_LEVELS} bright levels or more, better 50",
            )
        )
    reader = _FrameReader(folder, mosaic)
    reader.find_byte_order(paired)
    found: dict[str, list[tuple[FrameGroup, Moments]]] = {name: [] for name in reader.planes}
    stacks: dict[str, list[tuple[FrameGroup, SpatialVariance]]] = {name: [] for name in reader.planes}
    for group in paired:
        faults = len(reader.faults)
        for name in reader.planes:
            try:
                of_group = moments_of(reader.frames(group, name))
                if len(group.files) >= STACK_FRAMES:
                    stacks[name].append((group, spatial_variance(reader.frames(group, name))))
            except UserError as error:
                reader.keep(error)
                break
            found[name].append((group, of_group))
            reader.faults += _not_one_light(folder, group, of_group)
        if len(reader.faults) == faults and found[name][-1][1].frames:
            told(str(group))
    if reader.faults:
        raise UserError(reader.faults)
    bits = 0
    for each in found.values():
        for _, of_group in each:
            bits |= of_group.bits
    step = _step(bits)
    depth = _bit_depth(bits // step, bit_depth, folder)
    return tuple(
        Channel(
            name,
            tuple((group, m.scaled(step)) for group, m in found[name]),
            tuple((group, _in_steps(spatial, step)) for group, spatial in stacks[name]),
            depth,
            step,
            reader.swapped,
        )
        for name in found
    ), single


def faults_of_files(folder: Path, groups: Sequence[FrameGroup], mosaic: str) -> list[Fault]:
    """What is wrong with the files of groups, where their table has faults of its own."""
    return _FrameReader(folder, mosaic).faults_of(groups)


def _not_one_light(folder: Path, group: FrameGroup, found: Moments) -> list[Fault]:
    """Faults of frames of different light under one name."""
    most = max(_MOST_DRIFT * found.mean_dn, 5 * np.sqrt(found.variance_dn2), 1.0)
    if found.drift_dn <= most and found.spread_dn <= 2 * most:
        return []
    return [
        Fault(
            str(folder),
            f"the frames of {group} differ in mean by {found.spread_dn:.3g} DN, at a mean of "
            f"{found.mean_dn:.4g}",
            "frames of one light and one exposure",
            "Where light changes and exposure does not, tell levels apart by photons_per_pixel or a "
            "column level.",
        )
    ]


def _step(bits: int) -> int:
    """By how much samples were shifted up: 16 where 12 bits lie at the top of 16; 1 where they were not."""
    return bits & -bits if bits >= 256 else 1


def _bit_depth(bits: int, stated: int | None, folder: Path) -> int:
    least = max(bits.bit_length(), 1)
    if stated is None:
        return usual_bit_depth(bits)
    if stated < least:
        what = f"samples reach {bits} DN, beyond {stated} bits"
        raise UserError(Fault(str(folder), what, f"bit_depth: {least} or more", "Correct bit_depth."))
    return stated


def _in_steps(spatial: SpatialVariance, step: int) -> SpatialVariance:
    two = 1 / step**2
    return SpatialVariance(
        spatial.frames, spatial.mean_dn / step, spatial.total_dn2 * two, spatial.row_dn2 * two,
        spatial.column_dn2 * two, spatial.pixel_dn2 * two, spatial.gradual_dn2 * two, spatial.error_dn2 * two,
    )  # fmt: skip


class _FrameReader:
    """Reads frames one by one as the planes of a channel, and keeps faults."""

    def __init__(self, folder: Path, mosaic: str):
        self.folder = folder
        self.faults: list[Fault] = []
        self.swapped = False
        self._size: tuple[tuple[int, ...], str] | None = None
        self._seen: dict[bytes, Path] = {}
        places: dict[str, list[tuple[int, int]]] = {}
        for place, colour in enumerate("" if mosaic == "none" else mosaic):
            places.setdefault(colour, []).append((place // 2, place % 2))
        self.planes = {colour: places[colour] for colour in "GRB"} if places else {"mono": []}

    def find_byte_order(self, groups: Sequence[FrameGroup]) -> None:
        """Decide by the first bright frame in which one order of bytes is far smoother than the other."""
        for group in groups:
            if group.kind != "bright":
                continue
            try:
                image = read_frame(group.files[0], str(group.files[0]), self.folder)[..., 0]
            except UserError:  # reported where all frames are read
                continue
            as_stored, swapped = roughness(image), roughness(image.byteswap())
            if max(as_stored, swapped) > _FAR_ROUGHER * min(as_stored, swapped):
                self.swapped = as_stored > swapped
                return

    def faults_of(self, groups: Sequence[FrameGroup]) -> list[Fault]:
        """What is wrong with the files of groups, each read once."""
        for group in groups:
            try:
                for _ in self.frames(group, next(iter(self.planes))):
                    pass
            except UserError as error:
                self.keep(error)
        return self.faults

    def keep(self, error: UserError) -> None:
        """Keep what one file was refused for, once."""
        self.faults += [fault for fault in error.faults if fault not in self.faults]

    def frames(self, group: FrameGroup, channel: str) -> Iterator[Frame]:
        """Frames of a group; faults of all of its files come in one error."""
        faults: list[Fault] = []
        for path in group.files:
            try:
                image = self._read(path)
            except UserError as error:
                faults += error.faults
                continue
            if faults:
                continue
            places = self.planes[channel]
            height, width = (length // 2 * 2 for length in image.shape)
            yield [image[row:height:2, column:width:2] for row, column in places] or [image]
        if faults:
            raise UserError(faults)

    def _read(self, path: Path) -> NDArray[np.integer]:
        image = read_frame(path, str(path), self.folder)
        if image.shape[2] == 3 and not (image == image[..., :1]).all():
            raise UserError(
                Fault(
                    str(path),
                    "this frame has colours: demosaicing has mixed the noise of neighbours",
                    "one number for each photosite",
                    "Save raw frames, and name their mosaic: cfa: RGGB.",
                )
            )
        size = image.shape[:2]
        if min(size) < _NARROWEST_PX:
            least = f"{_NARROWEST_PX} x {_NARROWEST_PX} at least, better 200 x 200"
            raise UserError(Fault(str(path), f"this frame has {size[1]} x {size[0]} pixels", least))
        first, name = self._size or (size, path.name)
        self._size = (first, name)
        if size != first:
            what = f"this frame has {size[1]} x {size[0]} pixels"
            raise UserError(Fault(str(path), what, f"{first[1]} x {first[0]}, as {name}"))
        found = image[..., 0]
        self._refuse_copy(path, found)
        return found.byteswap() if self.swapped and found.itemsize > 1 else found

    def _refuse_copy(self, path: Path, image: NDArray[np.integer]) -> None:
        """Refuse a frame that repeats another one; those of one value, as saturated ones, may."""
        digest = blake2b(image.tobytes(), digest_size=16).digest()
        first = self._seen.setdefault(digest, path)
        if first != path and not has_one_value(image):
            raise UserError(
                Fault(
                    str(path),
                    f"this frame is a copy of {first.name}, sample by sample",
                    "frames taken one after another, whose noise differs",
                    f"Take it anew, or take its line out of {TABLE}.",
                )
            )
