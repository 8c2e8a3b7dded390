"""All photographs looked at, and those kept that one folder of captures can hold."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from hashlib import sha256
from pathlib import Path

from tacos_files.camera_images import has_one_value, read_image
from tacos_framework import Fault, UserError
from tacos_framework.files import read_bytes
from tacos_gap.photographs.given import Given
from tacos_gap.photographs.left_out import left_out, why_unreadable
from tacos_gap.photographs.picture import Picture, bits_of, look_at, printable_name


def looked_at(
    paths: Sequence[Path], given: Given, tell: Callable[[str], None]
) -> tuple[list[Picture], list[str]]:
    """The pictures of files, in the order they were taken, each seen at the depth that all of them need.

    Beside them sentences on the files that cannot be read.

    Raises UserError with what is wrong with every file, when none of them can be read.
    """
    pictures: list[Picture] = []
    faults: list[tuple[Path, Fault]] = []
    for path in paths:
        tell(path.name)
        try:
            pictures.append(look_at(path, given.black_level_dn, given.bit_depth, given.cfa))
        except UserError as error:
            faults += ((path, fault) for fault in error.faults)
    if not pictures:
        raise UserError(fault for _, fault in faults)
    names = [(path.name, printable_name(path), fault) for path, fault in faults]
    said = left_out((shown, why_unreadable(name, shown, fault)) for name, shown, fault in names)
    return sorted(_at_one_depth(pictures, given), key=lambda picture: picture.facts.taken), said


def _at_one_depth(pictures: Sequence[Picture], given: Given) -> list[Picture]:
    """Pictures, seen again where brighter ones show another depth of the camera: a dark is dark to that."""
    of_no_said_depth = [p for p in pictures if p.sample != "uint8" and p.facts.white_level_dn is None]
    if given.bit_depth is not None or not of_no_said_depth:
        return list(pictures)
    brightest = max(of_no_said_depth, key=lambda picture: picture.largest_dn)
    bits = bits_of(brightest.largest_dn, brightest.sample)
    again = {picture for picture in of_no_said_depth if picture.bits != bits}
    return [look_at(p.path, given.black_level_dn, bits, given.cfa) if p in again else p for p in pictures]


def of_one_form(pictures: Sequence[Picture]) -> tuple[list[Picture], list[str]]:
    """Those of the size, channels and depth that most have, none twice, and a sentence for each left out."""
    said: list[str] = []

    def leave_out(reasons: Mapping[Picture, str]) -> None:
        nonlocal pictures
        said.extend(left_out((picture.name, why) for picture, why in reasons.items()))
        pictures = [picture for picture in pictures if picture not in reasons]

    counts = Counter(picture.size_px for picture in pictures)
    size = max(counts, key=lambda each: (counts[each], each[0] * each[1]))
    leave_out({p: _of_other_size(p.size_px, size) for p in pictures if p.size_px != size})

    grey, rgb = ([p for p in pictures if p.channels == channels] for channels in (1, 3))
    if grey and not all(picture.mono for picture in rgb):
        if len(rgb) >= len(grey):
            leave_out(dict.fromkeys(grey, "has one channel, and most have three"))
        else:
            colour = [picture for picture in rgb if not picture.mono]
            leave_out(dict.fromkeys(colour, "is in colour, and most have one channel"))

    eight = [picture for picture in pictures if picture.sample == "uint8"]
    deeper = [picture for picture in pictures if picture.sample != "uint8"]
    if eight and deeper:
        if len(deeper) >= len(eight):
            leave_out(dict.fromkeys(eight, "has 8 bits a sample, and most have more"))
        else:
            leave_out(dict.fromkeys(deeper, "has more than 8 bits a sample, and most have 8"))

    leave_out({copy: f"is the same, byte by byte, as {p.name}" for copy, p in _copies(pictures).items()})
    return list(pictures), said


def _of_other_size(own_px: tuple[int, int], most_px: tuple[int, int]) -> str:
    what = f"has {own_px[0]} x {own_px[1]} pixels, and most have {most_px[0]} x {most_px[1]}"
    turned = " (turned by a program? Files are needed as the camera wrote them)"
    return what + turned * (own_px == most_px[::-1])


def _copies(pictures: Sequence[Picture]) -> dict[Picture, Picture]:
    """Pictures that another is a copy of, by the copy; frames without noise may well be alike."""
    first: dict[tuple[int, bytes], Picture] = {}
    copies: dict[Picture, Picture] = {}
    sizes = Counter(picture.path.stat().st_size for picture in pictures)
    for picture in pictures:
        size = picture.path.stat().st_size
        if sizes[size] == 1:
            continue
        digest = sha256(read_bytes(picture.path, "image_mb")).digest()
        original = first.setdefault((size, digest), picture)
        if original is not picture and not has_one_value(read_image(picture.path, picture.name)):
            copies[picture] = original
    return copies
