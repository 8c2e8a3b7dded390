"""Views of each camera: fields of view from the side and from above."""

from __future__ import annotations

from collections.abc import Iterator

from tacos_report.figures.side_view import side_view
from tacos_report.figures.top_view import top_view
from tacos_report.page import Block, Drawing, Legend, SideBySide
from tacos_report.palette import camera_variable
from tacos_report.study_data import StudyData


def blocks(study: StudyData) -> Iterator[Block]:
    drawings = tuple(_drawings(study))
    if drawings and len(study.cameras) > 1:
        yield Legend(tuple((camera.title, camera_variable(i)) for i, camera in enumerate(study.cameras)))
    if drawings:
        yield SideBySide(drawings)


def _drawings(study: StudyData) -> Iterator[Drawing]:
    if any("vfov_deg" in camera.derived for camera in study.cameras):
        yield Drawing(
            side_view(study.cameras, study.eye_height_m, study.carrier, study.ground),
            "From the side: vertical fields of view and pitch. Bars below begin at the nearest "
            f"{study.ground} each camera sees.",
        )
    if any("hfov_deg" in camera.derived for camera in study.cameras):
        yield Drawing(
            top_view(study.cameras),
            "From above: horizontal fields of view about the optical axis, edge to edge.",
        )
