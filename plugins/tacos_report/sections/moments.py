"""Frames of the same moments through each camera, to one angular scale."""

from __future__ import annotations

from collections.abc import Iterator

from tacos_report.page import Block, Frame, FrameRow, Paragraph
from tacos_report.palette import camera_variable
from tacos_report.pictures import picture, row_width_px, side_by_side
from tacos_report.study_data import StudyData

_MOMENTS_SHOWN = 3
_FRAME_PX = 640


def blocks(study: StudyData) -> Iterator[Block]:
    rows = list(_rows(study))
    if rows:
        many = "All frames of a row are" if len(study.cameras) > 1 else "Each frame is"
        yield Paragraph(
            f"{many} drawn to one angular scale with the horizons level, so a wider picture is a wider "
            "field of view. Frames as the sensor gives them, noise included.",
            quiet=True,
        )
    yield from rows


def _rows(study: StudyData) -> Iterator[FrameRow]:
    cameras = [(index, camera) for index, camera in enumerate(study.cameras) if camera.samples]
    if not cameras:
        return
    placed = side_by_side([camera for _, camera in cameras])
    for moment in range(min(_MOMENTS_SHOWN, *(len(camera.samples) for _, camera in cameras))):
        found = [
            (index, camera, image, place)
            for (index, camera), place in zip(cameras, placed, strict=True)
            if (image := picture(camera.samples[moment], _FRAME_PX))
        ]
        if found:
            yield FrameRow(
                tuple(
                    Frame(
                        image.uri,
                        f"Moment {moment + 1} seen by the {camera.title}",
                        camera.title,
                        f"{image.width_px} × {image.height_px} px",
                        camera_variable(index),
                        place.width,
                        place.top,
                    )
                    for index, camera, image, place in found
                ),
                row_width_px([image for _, _, image, _ in found], [place for *_, place in found]),
            )
