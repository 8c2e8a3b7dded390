"""Folders of captures, their boards found."""

from __future__ import annotations

from dataclasses import replace

from tacos_gap.captures.capture import CaptureFolder
from tacos_gap.evidence.boards.detection import with_corners
from tacos_gap.evidence.boards.unstated_lens import with_lens_of_boards


def boards_found(folder: CaptureFolder) -> CaptureFolder:
    """The folder with the points of all boards, and a focal length from them where nobody stated one.

    Captures whose board was not found are left out; its limitations say what to do about each. A folder whose
    boards were found already is returned as it is.
    """
    if all(capture.corners is not None for capture in folder.captures if capture.kind == "board"):
        return folder
    captures, unseen = with_corners(folder.captures)
    captures, said = with_lens_of_boards(captures)
    return replace(folder, captures=captures, limitations=(*folder.limitations, *unseen, *said))
