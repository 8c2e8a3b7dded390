"""Gathering of evidence: captures are prepared, and measured in as many processes as are of use."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any

from tacos_framework import usable_cores
from tacos_gap.captures import CaptureFolder, RealCapture
from tacos_gap.captures.even_light import with_even_light
from tacos_gap.captures.large import (
    enough_pixels,
    left_out,
    measured_part,
    not_searched_over,
    part_of,
    searched_over,
)
from tacos_gap.captures.mean_of_files import without_clipped_expectation
from tacos_gap.captures.sharp_edges import with_sharp_edges
from tacos_gap.evidence import Evidence, ImageEvidence, PictureEvidence
from tacos_gap.evidence.boards import boards_found, evidence_of_boards
from tacos_gap.evidence.elsewhere import EvidenceProcess, measured, processes_beside
from tacos_gap.statistics.unmeasured import nothing_seen, unmeasured
from tacos_gap.statistics.views import view_of

MOST_PROCESSES = 4
"""Processes that a diagnosis uses by itself: each takes .2 GiB beside its captures."""


def processes_for(
    folder: CaptureFolder, effects: Mapping[str, type[Any]], workers: int | None
) -> list[EvidenceProcess]:
    """Processes on their way beside this one, as many as have captures to simulate.

    `workers`: how many in all, this one among them; None for one for each core, at most `MOST_PROCESSES`.
    """
    most = workers or min(usable_cores(), MOST_PROCESSES)
    pictures = sum(capture.kind != "board" for capture in folder.captures)
    sensors = [capture.sensor for capture in folder.captures if capture.sensor is not None]
    return processes_beside(max(min(most, pictures) - 1, 0), [*effects.values(), *sensors])


def gather(
    folder: CaptureFolder, seed: int, processes: Sequence[EvidenceProcess] = ()
) -> tuple[list[Evidence], list[str]]:
    """Evidence of the captures, in this process and in others; and in sentences, what was left out."""
    found = boards_found(folder).captures
    captures = searched_over(found)
    enough = enough_pixels(captures)
    pictures = [_prepared(capture, enough) for capture in captures if capture.kind != "board"]
    prepared = [each for each in pictures if not isinstance(each, str)]
    images = measured(partial(_measured, seed), prepared, processes)
    boards = evidence_of_boards([capture for capture in captures if capture.corners is not None], seed)
    said = not_searched_over(found, captures)
    said += [each for each in pictures if isinstance(each, str)]
    said += [text for each in images for text in unmeasured(each.capture)]
    whole = {capture.id: capture for capture in captures}
    said += [text for each in images if (text := left_out(whole[each.capture.id], each.capture))]
    return [*images, *boards], [*said, *(text for each in images if (text := _not_taken(each)))]


def _not_taken(evidence: PictureEvidence) -> str:
    """In a sentence, which statistics of a capture could not be taken; empty where all were."""
    if not (names := evidence.left_out):
        return ""
    listed = ", ".join(view_of(name).title.lower() for name in names)
    return f"{evidence.capture.id}: not compared, as some simulations gave no number: {listed}."


def _prepared(capture: RealCapture, enough: int) -> RealCapture | str:
    """The part of a picture that is measured, or in a sentence why it is left out."""
    with _naming(capture):
        if (reason := nothing_seen(capture)) is not None:
            return reason
        if capture.expected_dn is None:
            capture = with_sharp_edges(capture)
        if (reason := nothing_seen(capture)) is not None:
            return reason
        capture = without_clipped_expectation(capture)
        if not capture.valid.any():
            return f"{capture.id}: white has cut off the files its expectation is a mean of; it is left out."
        if (part := measured_part(capture, enough)) is not None:
            capture = part_of(capture, part)
        return with_even_light(capture).of_at_most(enough)


def _measured(seed: int, capture: RealCapture) -> PictureEvidence:
    with _naming(capture):
        return ImageEvidence(capture, seed).renuisanced(())


@contextmanager
def _naming(capture: RealCapture) -> Iterator[None]:
    """What is raised inside names the capture."""
    try:
        yield
    except Exception as error:
        error.add_note(f"while measuring the capture {capture.id!r}")
        raise
