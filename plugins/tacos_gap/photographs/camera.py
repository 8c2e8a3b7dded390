"""The camera by all of its files together, and what they do not say."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import or_
from typing import Any

import cv2
import numpy as np

from tacos_framework import Fault, UserError
from tacos_gap.captures.alignment import FEWEST_UNUSED, low_bits_unused, shifted_left
from tacos_gap.photographs.boards import BoardView
from tacos_gap.photographs.facts import OF_NAME
from tacos_gap.photographs.given import Given, Guess
from tacos_gap.photographs.names import of_several_cameras
from tacos_gap.photographs.picture import Picture
from tacos_plugins.effects.board_calibration import opencv_in_one_thread
from tacos_plugins.effects.darks import pedestal_dn

USUAL_PIXEL_UM = 3.0

_GIVEN, _EXIF, _RAW, _GUESS = "as given", "EXIF", "the RAW files", "a guess"
"""Where a value is from."""

_FEWEST_VIEWS = 3
_FEWEST_PAIRS = 3

_LONGEST = 2.5
"""Longer over shorter side beyond which a picture is doubted: films are cut to 2.39, panoramas begin at 3."""

_LEVELS_AGREE = 0.005
"""Share of full scale within which a black level and darks agree: pedestals lie at 6 %."""


@dataclass(frozen=True)
class CameraFound:
    """The entry ``camera`` of a folder.

    - `source`: key -> where the value is from, for a comment.
    """

    entry: dict[str, Any]
    source: dict[str, str]
    doubts: tuple[str, ...]
    guesses: tuple[Guess, ...]


def camera_of(pictures: Sequence[Picture], given: Given, focal_px: float | None) -> CameraFound:
    """Put together what pictures say of their camera.

    - `pictures`: all of one size.
    - `given`: what was said on the command line.
    - `focal_px`: focal length by the views of a board; None without them [px].

    Raises UserError when what was said contradicts the pictures.
    """
    width, height = pictures[0].size_px
    channels = 1 if all(picture.mono for picture in pictures) else 3
    if given.cfa and channels == 3:
        raise UserError(Fault("--cfa", "the pictures are in colour", "a mosaic has one channel"))
    camera = _Answers({"width_px": width, "height_px": height})
    _settle_lens(camera, pictures, given, focal_px)
    _settle_white(camera, pictures, given)
    _settle_black(camera, pictures, given)
    camera.entry["channels"] = channels
    camera.settle("cfa", (given.cfa, _GIVEN), (_usual(p.facts.cfa for p in pictures), _RAW))
    doubts = (*camera.doubts, *_doubts(pictures, camera.entry))
    guesses = (*camera.guesses, *_guessed_filters(pictures, camera.entry))
    return CameraFound(camera.entry, camera.source, doubts, guesses)


class _Answers:
    def __init__(self, known: dict[str, Any]):
        self.entry = known
        self.source: dict[str, str] = {}
        self.doubts: list[str] = []
        self.guesses: list[Guess] = []

    def settle(self, key: str, *answers: tuple[Any, str], guess: Any = None, unsure: str = "") -> None:
        """Take the first answer there is, each with where it is from; else guess, and say so."""
        found = next((each for each in answers if each[0] is not None), None)
        if found is None and guess is not None:
            found = guess, _GUESS
            self.guesses.append(Guess(unsure, key, f"{guess:g}"))
        if found is not None:
            self.entry[key], self.source[key] = found


def _settle_lens(camera: _Answers, pictures: Sequence[Picture], given: Given, focal_px: float | None) -> None:
    facts = [picture.facts for picture in pictures]
    camera.settle(
        "pixel_um",
        (given.pixel_um, _GIVEN),
        (_usual(f.pixel_um for f in facts), _EXIF),
        guess=USUAL_PIXEL_UM,
        unsure=f"The pixels are taken to be {USUAL_PIXEL_UM:g} um; other cameras have 1 to 10. Only lengths "
        f"in micrometres depend on it (--pixel-um).",
    )
    pixel_um, focal_mm = camera.entry["pixel_um"], _usual(f.focal_length_mm for f in facts)
    camera.settle(
        "focal_length_mm",
        (given.focal_length_mm, _GIVEN),
        (focal_mm if camera.source["pixel_um"] != _GUESS else None, _EXIF),
        (focal_px and round(focal_px * pixel_um / 1e3, 4), "the views of the board"),
        (focal_mm, _EXIF),
        guess=round(camera.entry["width_px"] * pixel_um / 1e3, 4),
        unsure="The focal length is taken for that of a view of 53 degrees across; boards replace it "
        "(--focal-length-mm).",
    )
    if given.focal_length_mm is None:  # a file or a guess says where boards begin, and is nobody's belief
        camera.entry["lens_is_a_start"] = True
        camera.source["lens_is_a_start"] = "a first guess; boards replace it"
    camera.settle("f_number", (_usual(f.f_number for f in facts), _EXIF))


def _settle_white(camera: _Answers, pictures: Sequence[Picture], given: Given) -> None:
    """Bits, and the white level where RAW files say one."""
    bits = given.bit_depth or max(picture.bits for picture in pictures)
    camera.settle("bit_depth", (given.bit_depth, _GIVEN), (bits, "the largest value of the files"))
    white_dn = _usual(picture.facts.white_level_dn for picture in pictures)
    highest = max(pictures, key=lambda picture: picture.largest_dn)
    if white_dn is None:
        if highest.largest_dn > 2**bits - 1:
            what = f"is {bits}, and values of {highest.name} reach {highest.largest_dn:g}"
            needed = f"{int(highest.largest_dn).bit_length()} or more"
            raise UserError(Fault("--bit-depth", what, needed))
        return
    camera.settle(
        "white_level_dn",
        (white_dn if white_dn >= highest.largest_dn else None, _RAW),
        (highest.largest_dn, "the largest value, beyond what the RAW files say"),
    )


def _settle_black(camera: _Answers, pictures: Sequence[Picture], given: Given) -> None:
    """The black level, and whether the darks agree."""
    raw_dn = _usual((picture.facts.black_level_dn for picture in pictures), zero=True)
    dark_dn = _dark_level(pictures)
    camera.settle(
        "black_level_dn",
        (given.black_level_dn, _GIVEN),
        (raw_dn or None, _RAW),
        (dark_dn, "the level of the darks"),
        (raw_dn, _RAW),
        guess=0.0,
        unsure="The black level is taken to be 0, as in files made for a display; there is no dark picture. "
        "Take one with the cap on (--black-level-dn).",
    )
    black_dn, full_scale_dn = camera.entry["black_level_dn"], 2 ** camera.entry["bit_depth"]
    if dark_dn is not None and abs(dark_dn - black_dn) > max(2.0, _LEVELS_AGREE * full_scale_dn):
        camera.doubts.append(
            f"The black level is {black_dn:g} DN ({camera.source['black_level_dn']}), and the darks "
            f"lie at {dark_dn:g} DN: light got in, the time was long, or the level is another "
            f"(--black-level-dn)."
        )


def _usual(values: Any, *, zero: bool = False) -> Any:
    said = [value for value in values if value is not None and (zero or value)]
    return Counter(said).most_common(1)[0][0] if said else None


def _dark_level(pictures: Sequence[Picture]) -> float | None:
    """Level of the darks at no exposure [DN]; of the gain of the shortest, as the pedestal may follow it."""
    darks = [picture for picture in pictures if picture.shown.kind == "dark"]
    if not darks:
        return None
    darks.sort(key=lambda dark: (dark.facts.exposure_ms or math.inf, dark.middle_dn))
    first = darks[0]
    timed = [dark for dark in darks if dark.facts.exposure_ms and _gain(dark) == _gain(first)]
    ends = [((dark.facts.exposure_ms or 0.0) / 1e3, dark.middle_dn) for dark in (first, [first, *timed][-1])]
    return round(pedestal_dn(*ends), 2)


def _gain(picture: Picture) -> tuple[float | None, float | None]:
    return picture.facts.iso, picture.facts.gain_db


def _guessed_filters(pictures: Sequence[Picture], entry: dict[str, Any]) -> Iterator[Guess]:
    if entry["channels"] == 1 and "cfa" not in entry and any(picture.lattice for picture in pictures):
        yield Guess(
            "Grey files are taken for those of a camera without colour filters, although neighbouring pixels "
            "differ as behind them: if this is a mosaic, say which (--cfa GRBG).",
            "cfa",
        )


def _doubts(pictures: Sequence[Picture], entry: dict[str, Any]) -> Iterator[str]:
    facts = [picture.facts for picture in pictures]
    if len(cameras := sorted({f.camera for f in facts if f.camera})) > 1:
        yield f"The pictures are of several cameras: {', '.join(cameras)}. Import one camera at a time."
    elif len(pairs := of_several_cameras(picture.path for picture in pictures)) >= _FEWEST_PAIRS:
        yield (
            f"{len(pairs)} pairs of pictures are named as of two cameras ({' and '.join(pairs[0])}), and "
            f"taken for those of one. Import one camera at a time."
        )
    if any(f.lossy for f in facts):
        yield (
            "The files are lossy, and what a camera does to such files (tone curve, denoising, sharpening, "
            "JPEG) will be among the causes. RAW files show more of sensor and lens."
        )
    if software := sorted({f.software for f in facts if f.software and not f.raw}):
        yield f"Written by {', '.join(software)}: make sure that nothing was edited, resized or rotated."
    if any(f.orientation not in (0, 1) for f in facts):
        yield "Some pictures were taken upright or upside down; their files are read as the sensor lies."
    if len({f.focal_length_mm for f in facts if f.focal_length_mm}) > 1:
        yield "The focal length changed between pictures: a zoom has to stay where it is."
    if len({f.f_number for f in facts if f.f_number}) > 1:
        yield "The aperture changed between pictures: it is best left alone."
    for source in dict.fromkeys(f.time_from for f in facts if f.time_from):
        first = next(picture for picture in pictures if picture.facts.time_from == source)
        whence = "the names of files or folders" if source == OF_NAME else source
        yield f"Exposure times were read from {whence} ({first.name}: {first.facts.exposure_ms:g} ms)."
    unused = low_bits_unused(reduce(or_, (picture.used_bits for picture in pictures)))
    if unused >= FEWEST_UNUSED and entry["bit_depth"] - unused >= 8:
        yield shifted_left(entry["bit_depth"] - unused, unused)
    elif entry["bit_depth"] > 8 and "white_level_dn" not in entry:
        yield (
            f"No value needs more than {entry['bit_depth']} bits: if the camera has more, say so "
            f"(--bit-depth)."
        )
    sides = entry["width_px"], entry["height_px"]
    if max(sides) > _LONGEST * min(sides):
        yield (
            f"Pictures of {sides[0]} x {sides[1]} pixels are longer than sensors are. A panorama is made of "
            f"many pictures and tells of no lens; of a window of the sensor, write its `crop`."
        )
    if max(sides) > 4000:
        yield "The pictures are large: a diagnosis will take its time, and four frames of each are plenty."


def focal_px_of_views(views: Sequence[BoardView], size_px: tuple[int, int]) -> float | None:
    """Focal length by tilted views of a board, a lens that bends by k1 and k2 beside it (Zhang 2000) [px].

    None with fewer than three views, and where they do not agree to a pixel.
    """
    if len(views) < _FEWEST_VIEWS:
        return None
    flags = cv2.CALIB_FIX_ASPECT_RATIO | cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K3
    flags |= cv2.CALIB_FIX_PRINCIPAL_POINT
    guess = np.array(
        [[size_px[0], 0, (size_px[0] - 1) / 2], [0, size_px[0], (size_px[1] - 1) / 2], [0, 0, 1.0]]
    )
    points, corners = zip(*((view.points, view.corners_px.reshape(-1, 1, 2)) for view in views), strict=True)
    try:
        with opencv_in_one_thread():
            rms, matrix, *_ = cv2.calibrateCamera(
                points, corners, size_px, guess, None, flags=flags | cv2.CALIB_USE_INTRINSIC_GUESS
            )
    except cv2.error:  # views that are all alike
        return None
    return float(matrix[0, 0]) if rms < 1.5 else None
